//! Flow control of RS-274: O-words. One pass over the program finds what belongs together; the runner follows it.

use std::collections::HashMap;

use crate::dialect::FlowStyle;
use crate::finding::{self, Finding, Severity, Unseen};
use crate::order::macros::MacroTable;
use crate::order::structured;
use crate::reading::program::{Program, Word, WordKind};

/// What an O-word line does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    Sub,
    EndSub,
    Return,
    Call,
    If,
    ElseIf,
    Else,
    EndIf,
    While,
    EndWhile,
    Do,
    /// The `while` that ends a `do` loop.
    DoWhile,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// The end of a `do` loop that goes on until something holds.
    Until,
    /// A loop without end.
    Loop,
    EndLoop,
    For,
    EndFor,
    Jump,
    /// A jump on a condition.
    JumpIf,
    /// Repeats blocks between labels.
    Section,
    /// Declares variables.
    Declare,
    /// A jump by a value: `CASE(R1) OF 1 GOTOF A 2 GOTOF B DEFAULT GOTOF C`.
    Case,
    /// The label of a section; 0 ends one that was called.
    Label,
    /// Calls or repeats a section.
    CallLabel,
    /// A jump where two values compare.
    Compare,
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

impl Flow {
    /// Whether it starts something that needs an end.
    fn opens(self) -> bool {
        matches!(self, Self::Sub | Self::If | Self::While | Self::Do | Self::Repeat | Self::Loop | Self::For)
    }

    /// What it ends.
    fn closes(self) -> Option<Self> {
        match self {
            Self::EndSub => Some(Self::Sub),
            Self::EndIf => Some(Self::If),
            Self::EndWhile => Some(Self::While),
            Self::DoWhile | Self::Until => Some(Self::Do),
            Self::EndLoop => Some(Self::Loop),
            Self::EndFor => Some(Self::For),
            Self::EndRepeat => Some(Self::Repeat),
            _ => None,
        }
    }

    /// Whether it belongs to no other line.
    fn stands_alone(self) -> bool {
        matches!(self, Self::Call | Self::Jump | Self::JumpIf | Self::Section | Self::Declare | Self::Case)
            || matches!(self, Self::Label | Self::CallLabel | Self::Compare)
    }

    /// Whether an `if` whose condition fails goes on here.
    fn is_alternative(self) -> bool {
        matches!(self, Self::ElseIf | Self::Else | Self::EndIf)
    }
}

/// One O-word line.
#[derive(Clone, Debug)]
pub(crate) struct Statement {
    pub flow: Flow,
    pub block: usize,
    /// Label in lower case without spaces; a computed one as it is written.
    pub label: String,
    /// First byte.
    pub at: usize,
    /// Byte after the keyword: conditions and arguments.
    pub arguments: usize,
    /// Block that starts what the line belongs to.
    pub start: usize,
    /// Block of the next alternative of an `if`.
    pub next: usize,
    /// Block that ends what the line belongs to.
    pub end: usize,
}

/// The flow control of a program.
#[derive(Debug, Default)]
pub(crate) struct Table {
    statements: HashMap<usize, Statement>,
    /// Flow control of custom macros.
    pub macros: MacroTable,
    subroutines: HashMap<String, usize>,
}

impl Table {
    /// Reads every O-word line and matches beginnings with ends. What does not fit is reported and left out.
    pub fn read(program: &Program, findings: &mut Vec<Finding>) -> Self {
        let mut matcher = Matcher { program, open: HashMap::new(), table: Self::default(), findings };
        if program.dialect().flow == FlowStyle::Macro {
            matcher.table.macros = MacroTable::read(program, matcher.findings);
        } else {
            for word in program.words().iter().filter(|word| word.kind == WordKind::Flow) {
                matcher.add(word);
            }
        }
        matcher.finish()
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

struct Matcher<'a> {
    program: &'a Program,
    /// Lines that wait for their end, by label.
    open: HashMap<String, Vec<Statement>>,
    table: Table,
    findings: &'a mut Vec<Finding>,
}

impl Matcher<'_> {
    fn add(&mut self, word: &Word) {
        let structured = matches!(self.program.dialect().flow, FlowStyle::Structured | FlowStyle::Labels);
        let parsed = if structured { structured::parse(self.program, word) } else { parse(self.program, word) };
        let Some(mut statement) = parsed else {
            let text = finding::excerpt(self.program.text(word));
            return self.refuse(word.start as usize, format!("\"{text}\" has no label or no known keyword"));
        };
        if statement.flow == Flow::While && !structured && self.innermost(&statement.label) == Some(Flow::Do) {
            statement.flow = Flow::DoWhile;
        }
        if statement.flow.stands_alone() {
            self.table.statements.insert(statement.block, statement);
        } else if let Some(opening) = statement.flow.closes() {
            self.close(statement, opening);
        } else if statement.flow.opens() || self.innermost(&statement.label).is_some() {
            self.open.entry(statement.label.clone()).or_default().push(statement);
        } else {
            self.refuse(statement.at, format!("\"{}\" belongs to nothing of its label", self.name(&statement)));
        }
    }

    fn refuse(&mut self, at: usize, message: String) {
        let hint = match self.program.dialect().flow {
            FlowStyle::Structured => "each IF, WHILE, FOR, LOOP and REPEAT has its own end",
            _ => "one label for a pair: o100 while [..] … o100 endwhile",
        };
        let hint = hint.to_owned();
        finding::add(
            self.findings,
            Finding { severity: Severity::Error, code: finding::FLOW, message, hint, at, unseen: Unseen::Nothing },
        );
    }

    /// What a line is called in messages: its label, or its keyword.
    fn name(&self, statement: &Statement) -> String {
        if self.program.dialect().flow != FlowStyle::Structured {
            return format!("o{}", statement.label);
        }
        finding::excerpt(self.program.source().get(statement.at..statement.arguments).unwrap_or(&[]))
    }

    /// What the innermost open line of a label starts.
    fn innermost(&self, label: &str) -> Option<Flow> {
        let flows = self.open.get(label)?.iter().map(|statement| statement.flow);
        flows.rev().find(|flow| flow.opens())
    }

    /// Ends what was opened last under the label: its lines get to know each other.
    fn close(&mut self, closing: Statement, opening: Flow) {
        let waiting = self.open.entry(closing.label.clone()).or_default();
        let position = waiting.iter().rposition(|statement| statement.flow.opens());
        let Some(position) = position.filter(|found| waiting.get(*found).is_some_and(|open| open.flow == opening))
        else {
            return self.refuse(closing.at, format!("the end of \"{}\" without its beginning", self.name(&closing)));
        };
        let end = closing.block;
        let mut group: Vec<Statement> = waiting.drain(position..).collect();
        group.push(closing);
        let start = group.first().map_or(end, |first| first.block);
        let mut next = end;
        for mut statement in group.into_iter().rev() {
            (statement.start, statement.next, statement.end) = (start, next, end);
            if statement.flow.is_alternative() {
                next = statement.block;
            }
            if statement.flow == Flow::Sub {
                self.table.subroutines.insert(statement.label.clone(), statement.block);
            }
            self.table.statements.insert(statement.block, statement);
        }
    }

    fn finish(mut self) -> Table {
        let mut left: Vec<Statement> = std::mem::take(&mut self.open).into_values().flatten().collect();
        left.sort_by_key(|statement| statement.at);
        for statement in left {
            self.refuse(statement.at, format!("\"{}\" without its end", self.name(&statement)));
        }
        self.table
    }
}

fn parse(program: &Program, word: &Word) -> Option<Statement> {
    let (at, end) = (word.start as usize, word.end());
    let source = program.source().get(..end)?;
    let label_start = skip_space(source, at + 1);
    let label_end = label_start + label_length(source.get(label_start..)?)?;
    let kept = source.get(label_start..label_end)?.iter().filter(|byte| !byte.is_ascii_whitespace());
    let label = kept.map(|byte| char::from(byte.to_ascii_lowercase())).collect();
    let (mut keyword, mut arguments) = (Vec::new(), skip_space(source, label_end)); // `end sub` is `endsub`
    while let Some(letter) = source.get(arguments).filter(|byte| byte.is_ascii_alphabetic()) {
        keyword.push(letter.to_ascii_lowercase());
        arguments = skip_space(source, arguments + 1);
    }
    let (_, flow) = KEYWORDS.iter().find(|(text, _)| text.as_bytes() == keyword)?;
    let block = program.block_at(at);
    Some(Statement { flow: *flow, block, label, at, arguments, start: block, next: block, end: block })
}

fn skip_space(source: &[u8], at: usize) -> usize {
    at + source.iter().skip(at).take_while(|byte| byte.is_ascii_whitespace()).count()
}

/// Over white space and comments in a line.
pub(crate) fn skip_blank(source: &[u8], mut at: usize) -> usize {
    loop {
        at += source.iter().skip(at).take_while(|byte| matches!(byte, b' ' | b'\t' | b'\r')).count();
        let comment = source.get(at..).filter(|rest| rest.first() == Some(&b'('));
        let closed = comment.and_then(|rest| rest.iter().position(|byte| matches!(byte, b')' | b'\n')));
        match closed.filter(|length| source.get(at + length) == Some(&b')')) {
            Some(length) => at += length + 1,
            None => return at,
        }
    }
}

/// Length of a label: digits, `<name>`, or a computed one in brackets or from a parameter.
fn label_length(text: &[u8]) -> Option<usize> {
    match *text.first()? {
        b'<' => memchr::memchr(b'>', text).map(|found| found + 1),
        b'[' => memchr::memchr(b']', text).map(|found| found + 1),
        b'#' => Some(1 + label_length(text.get(1..)?)?),
        byte if byte.is_ascii_digit() => Some(text.iter().take_while(|byte| byte.is_ascii_digit()).count()),
        _ => None,
    }
}
