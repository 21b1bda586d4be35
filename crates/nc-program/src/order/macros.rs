//! Flow control of custom macros: IF, GOTO, WHILE, DO, END.

use std::collections::HashMap;

use crate::finding::{self, Finding, Severity};
use crate::modes::gather::ALARM;
use crate::reading::names;
use crate::reading::program::{Program, WordKind};
use crate::run::Runner;
use crate::values::parameters::Key;

/// Keywords, and whether a bracket (or else a digit, a bracket or a parameter) follows.
const KEYWORDS: [(&[u8], &[u8]); 5] =
    [(b"IF", b"["), (b"WHILE", b"["), (b"GOTO", b"0123456789#["), (b"DO", b"0123456789"), (b"END", b"0123456789")];

/// Statements that write to a device outside and move nothing.
const OUTPUT: [&[u8]; 4] = [b"POPEN", b"PCLOS", b"DPRNT[", b"BPRNT["];

/// Whether a statement starts at a byte that writes out values: DPRNT and what belongs to it.
pub(crate) fn writes_out(source: &[u8], at: usize) -> bool {
    OUTPUT.iter().any(|keyword| after(source, at, keyword).is_some())
}

/// Whether a macro statement starts at a byte.
pub(crate) fn begins(source: &[u8], at: usize) -> bool {
    KEYWORDS.iter().any(|(keyword, next)| {
        after(source, at, keyword).is_some_and(|end| source.get(end).is_some_and(|byte| next.contains(byte)))
    })
}

/// One past a keyword and the white space after it, where the text has it at `at`.
fn after(source: &[u8], at: usize, keyword: &[u8]) -> Option<usize> {
    names::after(source, at, keyword).map(|end| names::skip_blank(source, end))
}

/// The macro statements of a program, and which block ends or starts which loop.
#[derive(Debug, Default)]
pub(crate) struct MacroTable {
    statements: HashMap<usize, (usize, usize)>,
    partners: HashMap<usize, usize>,
}

impl MacroTable {
    /// Finds them all; an END without DO or a DO without END is reported.
    pub fn read(program: &Program, findings: &mut Vec<Finding>) -> Self {
        let mut table = Self::default();
        let mut open: Vec<(u8, usize, usize)> = Vec::new();
        for word in program.words().iter().filter(|word| word.kind == WordKind::Flow) {
            let (start, block) = (word.start as usize, program.block_at(word.start as usize));
            table.statements.insert(block, (start, word.end()));
            let text = program.text(word);
            let last = text.last().copied().unwrap_or(0);
            let is = |keyword: &[u8]| after(text, 0, keyword).is_some();
            if is(b"END") {
                match open.iter().rposition(|(number, ..)| *number == last) {
                    Some(position) => {
                        let (_, start, _) = open.remove(position);
                        table.partners.extend([(block, start), (start, block)]);
                    }
                    None => report(findings, start, "an END without its DO"),
                }
            } else if is(b"DO") || is(b"WHILE") {
                open.push((last, block, start));
            }
        }
        open.into_iter().for_each(|(.., at)| report(findings, at, "a DO without its END"));
        table
    }

    /// First and one past the last byte of a block's macro statement.
    pub fn statement(&self, block: usize) -> Option<(usize, usize)> {
        self.statements.get(&block).copied()
    }
}

fn report(findings: &mut Vec<Finding>, at: usize, message: &str) {
    let hint = "one number for a pair: WHILE[..]DO1 … END1".to_owned();
    finding::add(
        findings,
        Finding { severity: Severity::Error, code: finding::FLOW, message: message.to_owned(), hint, at },
    );
}

fn is_true(value: f64) -> bool {
    value != 0.0 && !value.is_nan()
}

impl Runner<'_> {
    /// Executes the macro statement between two bytes.
    pub(crate) fn follow_macro(&mut self, start: usize, end: usize) {
        let source = self.program.source();
        let keyword = |text: &[u8]| after(source, start, text);
        if let Some(at) = keyword(b"IF") {
            self.conditional(at, end);
        } else if let Some(at) = keyword(b"GOTO") {
            self.go_to(at);
        } else if let Some(at) = keyword(b"WHILE") {
            let value = self.value(at).0;
            self.require_value(value, at);
            if !is_true(value) {
                self.next = self.table.macros.partners.get(&self.block).map_or(self.next, |found| found + 1);
            }
        } else if keyword(b"END").is_some() {
            self.next = self.table.macros.partners.get(&self.block).copied().unwrap_or(self.next);
        }
    }

    fn conditional(&mut self, at: usize, end: usize) {
        let (value, rest) = self.value(at);
        self.require_value(value, at);
        let source = self.program.source();
        let (then, go) = (after(source, rest, b"THEN"), after(source, rest, b"GOTO"));
        match (then, go) {
            (None, None) if rest > at => {
                let hint = "write IF[..]GOTO10 or IF[..]THEN#1=0";
                self.refuse(finding::FLOW, rest, "IF without GOTO or THEN".into(), hint);
            }
            _ if !is_true(value) => {}
            (Some(at), _) => self.assign_at(at, end),
            (_, Some(at)) => self.go_to(at),
            _ => {}
        }
    }

    /// `#1=#2+3` after THEN.
    fn assign_at(&mut self, at: usize, end: usize) {
        let text = self.program.source().get(at..end).unwrap_or(&[]);
        let (Some(equals), true) = (memchr::memchr(b'=', text), text.first() == Some(&b'#')) else {
            return self.refuse(finding::FLOW, at, "THEN without an assignment".into(), "write IF[..]THEN#1=0");
        };
        if let Some(key) = self.key(at) {
            let value = self.assigned(at + equals + 1, end);
            if key == Key::Number(ALARM) {
                self.report_alarm(at);
                self.until = 0;
            }
            self.state.store.set(key, value);
        }
    }

    fn go_to(&mut self, at: usize) {
        let (number, _) = self.value(at);
        if let Some(block) = self.numbered_block(number, at) {
            self.next = block;
        }
    }
}
