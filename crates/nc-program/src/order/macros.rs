//! Flow control of custom macros: IF, GOTO, WHILE, DO, END; and of OSP: IF, GOTO to blocks by their names.

use std::collections::HashMap;

use crate::finding::{self, Finding, Severity, Unseen};
use crate::modes::gather::ALARM;
use crate::order::labels::Direction;
use crate::reading::names;
use crate::reading::program::{Program, Word, WordKind};
use crate::run::Runner;
use crate::values::parameters::Key;

/// Keywords, and whether a bracket (or else a digit, a bracket or a parameter) follows.
const KEYWORDS: [(&[u8], &[u8]); 6] = [
    (b"IF", b"["),
    (b"WHILE", b"["),
    (b"WH", b"["), // the control takes the first two letters for the keyword
    (b"GOTO", b"0123456789#["),
    (b"DO", b"0123456789"),
    (b"END", b"0123456789"),
];

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

/// One past the WHILE, or its abbreviation, and the white space after it.
fn after_while(source: &[u8], at: usize) -> Option<usize> {
    after(source, at, b"WHILE").or_else(|| after(source, at, b"WH"))
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
            } else if is(b"DO") || after_while(text, 0).is_some() {
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
        Finding {
            severity: Severity::Error,
            code: finding::FLOW,
            message: message.to_owned(),
            hint,
            at,
            unseen: Unseen::Nothing,
        },
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
        } else if let Some(at) = after_while(source, start) {
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
        if self.only_guards(at, end) {
            return;
        }
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

    /// Whether all that a condition without a value decides is an alarm (`IF[#5405GE6000]THEN#3000=15`): the path is that of
    /// the program that goes on.
    fn only_guards(&mut self, at: usize, end: usize) -> bool {
        let Some((true, rest)) = self.is_undefined(at) else { return false };
        let Some(then) = after(self.program.source(), rest, b"THEN") else { return false };
        let alarm = self.program.source().get(then..end).and_then(|text| text.strip_prefix(b"#3000"));
        let alarms = alarm.is_some_and(|rest| rest.trim_ascii_start().first() == Some(&b'='));
        if alarms {
            let message = "whether the program stops here in its alarm depends on a value that is not known".to_owned();
            let hint = "the path is that of the program that goes on";
            self.report(Severity::Note, finding::FLOW, at, message, hint);
        }
        alarms
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

    /// `GOTO NEND`, `IF[V1 EQ 2]N10`: goes on at the block of that name, of the same program.
    pub(crate) fn go_to_name(&mut self, word: i32) {
        let (program, start) = (self.program, self.word_start(word));
        let (source, end) = (program.source(), program.word(word).map_or(start, Word::end));
        let mut at = start;
        if let Some(condition) = after(source, start, b"IF") {
            let (value, rest) = self.bracketed(condition);
            if !is_true(value) {
                return; // one without a value is reported already
            }
            at = names::skip_blank(source, rest);
        }
        let at = after(source, at, b"GOTO").unwrap_or(at);
        let name = source.get(at..end).unwrap_or(&[]).trim_ascii();
        if let Some(block) = self.labels().target(name, self.block, Direction::Either) {
            self.next = block;
            return;
        }
        let message = format!("block {} is not in this program", String::from_utf8_lossy(name));
        self.refuse(finding::FLOW, at, message, "write the name of a block behind IF[..] or GOTO");
    }

    fn go_to(&mut self, at: usize) {
        let (number, _) = self.value(at);
        if let Some(block) = self.numbered_block(number, at) {
            self.next = block;
        }
    }
}
