//! Flow control of RS-274: O-words. One pass over the program finds what belongs together; the runner follows it.

use std::collections::HashMap;

use crate::finding::{self, Finding, Severity};
use crate::program::{Program, WordKind};

/// What an O-word line does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Start of a subroutine.
    Sub,
    /// Its end.
    EndSub,
    /// Back to the caller.
    Return,
    /// Runs a subroutine.
    Call,
    /// `if`.
    If,
    /// `elseif`.
    ElseIf,
    /// `else`.
    Else,
    /// `endif`.
    EndIf,
    /// `while` at the start of a loop.
    While,
    /// Its end.
    EndWhile,
    /// Start of a loop that ends with a `while`.
    Do,
    /// `while` at the end of a `do` loop.
    DoWhile,
    /// `repeat`.
    Repeat,
    /// Its end.
    EndRepeat,
    /// Leaves a loop.
    Break,
    /// Goes on with a loop's next turn.
    Continue,
}

/// One O-word line.
#[derive(Clone, Debug)]
pub struct Statement {
    /// What it does.
    pub flow: Flow,
    /// Its block.
    pub block: usize,
    /// Label in lower case without spaces; a computed one as it is written.
    pub label: String,
    /// Byte after the keyword: conditions and arguments.
    pub arguments: usize,
    /// First byte.
    pub at: usize,
    /// Block of the partner at the start: of the loop, of the `if`.
    pub start: usize,
    /// Block of the next alternative of an `if`, or the end.
    pub next: usize,
    /// Block of the partner at the end: `endwhile`, `endif`, `endsub`.
    pub end: usize,
}

const KEYWORDS: [(&str, Flow); 15] = [
    ("sub", Flow::Sub),
    ("endsub", Flow::EndSub),
    ("return", Flow::Return),
    ("call", Flow::Call),
    ("if", Flow::If),
    ("elseif", Flow::ElseIf),
    ("else", Flow::Else),
    ("endif", Flow::EndIf),
    ("while", Flow::While),
    ("endwhile", Flow::EndWhile),
    ("do", Flow::Do),
    ("repeat", Flow::Repeat),
    ("endrepeat", Flow::EndRepeat),
    ("break", Flow::Break),
    ("continue", Flow::Continue),
];

/// The flow control of a program.
#[derive(Debug, Default)]
pub struct Table {
    statements: HashMap<usize, Statement>,
    subroutines: HashMap<String, usize>,
}

impl Table {
    /// Reads every O-word line and matches beginnings with ends. What does not fit is reported and left out.
    pub fn read(program: &Program, findings: &mut Vec<Finding>) -> Self {
        if !program.dialect().flow {
            return Self::default();
        }
        let mut statements = Vec::new();
        for word in program
            .words()
            .iter()
            .filter(|word| word.kind == WordKind::Flow)
        {
            match parse(program, word.start as usize, word.end as usize) {
                Some(statement) => statements.push(statement),
                None => report(
                    findings,
                    word.start as usize,
                    "an O-word without a label or a known keyword",
                ),
            }
        }
        let matched = Matcher {
            open: Vec::new(),
            findings,
        }
        .run(&mut statements);
        let subroutines = statements
            .iter()
            .filter(|statement| statement.flow == Flow::Sub && matched.contains(&statement.block))
            .map(|statement| (statement.label.clone(), statement.block))
            .collect();
        let kept = statements
            .into_iter()
            .filter(|statement| matched.contains(&statement.block));
        Self {
            statements: kept.map(|statement| (statement.block, statement)).collect(),
            subroutines,
        }
    }

    /// The O-word line of a block.
    pub fn statement(&self, block: usize) -> Option<&Statement> {
        self.statements.get(&block)
    }

    /// Block of the `sub` line with that label.
    pub fn subroutine(&self, label: &str) -> Option<usize> {
        self.subroutines.get(label).copied()
    }
}

fn report(findings: &mut Vec<Finding>, at: usize, what: &str) {
    let hint =
        "write o100 sub … o100 endsub, o100 while [..] … o100 endwhile: one label for a pair"
            .to_owned();
    finding::add(
        findings,
        Finding::new(Severity::Error, finding::FLOW, at, what.to_owned(), hint),
    );
}

fn parse(program: &Program, start: usize, end: usize) -> Option<Statement> {
    let source = program.source().get(..end)?;
    let label_start = start
        + 1
        + source
            .get(start + 1..)?
            .iter()
            .take_while(|byte| byte.is_ascii_whitespace())
            .count();
    let label_end = label_start + label_length(source.get(label_start..)?)?;
    let kept = source
        .get(label_start..label_end)?
        .iter()
        .filter(|byte| !byte.is_ascii_whitespace());
    let label: String = kept
        .map(|byte| char::from(byte.to_ascii_lowercase()))
        .collect();
    let rest = source.get(label_end..)?;
    let keyword_start = label_end
        + rest
            .iter()
            .take_while(|byte| byte.is_ascii_whitespace())
            .count();
    let rest = source.get(keyword_start..)?;
    let length = rest
        .iter()
        .take_while(|byte| byte.is_ascii_alphabetic())
        .count();
    let keyword = rest.get(..length)?.to_ascii_lowercase();
    let (_, flow) = KEYWORDS
        .iter()
        .find(|(text, _)| text.as_bytes() == keyword.as_slice())?;
    let block = program.block_at(start);
    let arguments = keyword_start + length;
    Some(Statement {
        flow: *flow,
        block,
        label,
        arguments,
        at: start,
        start: block,
        next: block,
        end: block,
    })
}

/// Length of a label: digits, `<name>`, or a computed one in brackets or from a parameter.
fn label_length(text: &[u8]) -> Option<usize> {
    match *text.first()? {
        b'<' => memchr::memchr(b'>', text).map(|found| found + 1),
        b'[' => memchr::memchr(b']', text).map(|found| found + 1),
        b'#' => Some(1 + label_length(text.get(1..)?)?),
        byte if byte.is_ascii_digit() => {
            Some(text.iter().take_while(|byte| byte.is_ascii_digit()).count())
        }
        _ => None,
    }
}

struct Matcher<'a> {
    /// Indices of statements not closed yet.
    open: Vec<usize>,
    findings: &'a mut Vec<Finding>,
}

impl Matcher<'_> {
    /// Fills in the partners; gives the blocks of all statements that have theirs.
    fn run(mut self, statements: &mut [Statement]) -> std::collections::HashSet<usize> {
        let mut matched = std::collections::HashSet::new();
        for index in 0..statements.len() {
            self.visit(statements, index, &mut matched);
        }
        for index in std::mem::take(&mut self.open) {
            if let Some(statement) = statements.get(index) {
                report(
                    self.findings,
                    statement.at,
                    "a loop, condition or subroutine without an end",
                );
            }
        }
        matched
    }

    fn visit(
        &mut self,
        statements: &mut [Statement],
        index: usize,
        matched: &mut std::collections::HashSet<usize>,
    ) {
        let Some(statement) = statements.get(index).cloned() else {
            return;
        };
        match statement.flow {
            Flow::Call => drop(matched.insert(statement.block)),
            Flow::While
                if self
                    .innermost(statements, &statement.label, Flow::Do)
                    .is_some() =>
            {
                self.close(statements, index, Flow::Do, matched);
                if let Some(found) = statements.get_mut(index) {
                    found.flow = Flow::DoWhile;
                }
            }
            Flow::Sub | Flow::If | Flow::While | Flow::Do | Flow::Repeat => self.open.push(index),
            Flow::EndSub => self.close(statements, index, Flow::Sub, matched),
            Flow::EndWhile => self.close(statements, index, Flow::While, matched),
            Flow::EndRepeat => self.close(statements, index, Flow::Repeat, matched),
            Flow::EndIf => self.close(statements, index, Flow::If, matched),
            Flow::ElseIf | Flow::Else | Flow::Return | Flow::Break | Flow::Continue => {
                self.inside(statements, index)
            }
            Flow::DoWhile => {}
        }
    }

    /// Position in `open` of the innermost opening of that kind, if it carries the label.
    fn innermost(&self, statements: &[Statement], label: &str, flow: Flow) -> Option<usize> {
        let position = self.open.iter().rposition(|index| {
            statements
                .get(*index)
                .is_some_and(|open| open.flow == flow && open.label == label)
        })?;
        Some(position)
    }

    /// A statement within something open: it waits for the end to be known.
    fn inside(&mut self, statements: &[Statement], index: usize) {
        let Some(statement) = statements.get(index) else {
            return;
        };
        let within = self.open.iter().any(|open| {
            statements
                .get(*open)
                .is_some_and(|open| open.label == statement.label)
        });
        if within {
            self.open.push(index);
        } else {
            report(
                self.findings,
                statement.at,
                "a line that belongs to no loop, condition or subroutine of its label",
            );
        }
    }

    /// Ends what `index` closes: the opening, and the lines in between that carry its label.
    fn close(
        &mut self,
        statements: &mut [Statement],
        index: usize,
        flow: Flow,
        matched: &mut std::collections::HashSet<usize>,
    ) {
        let Some(closing) = statements.get(index).cloned() else {
            return;
        };
        let Some(position) = self.innermost(statements, &closing.label, flow) else {
            return report(self.findings, closing.at, "an end without its beginning");
        };
        let group: Vec<usize> = self.open.drain(position..).chain([index]).collect();
        let blocks: Vec<usize> = group
            .iter()
            .filter_map(|member| statements.get(*member))
            .map(|s| s.block)
            .collect();
        let start = blocks.first().copied().unwrap_or(closing.block);
        for (order, member) in group.iter().enumerate() {
            let Some(statement) = statements.get_mut(*member) else {
                continue;
            };
            if statement.label != closing.label {
                report(
                    self.findings,
                    statement.at,
                    "a loop, condition or subroutine without an end",
                );
                continue;
            }
            statement.start = start;
            statement.end = closing.block;
            statement.next = blocks.get(order + 1).copied().unwrap_or(closing.block);
            matched.insert(statement.block);
        }
    }
}
