//! Flow control of Sinumerik: IF, WHILE, FOR, LOOP, REPEAT without labels, jumps to labels, programs called by name.

use crate::dialect::G;
use crate::finding::{self, Severity};
use crate::modes::request::Request;
use crate::order::flow::{Flow, Statement};
use crate::order::labels::{called, Direction};
use crate::reading::names::{self, after, Name};
use crate::reading::program::{Program, Word};
use crate::run::Runner;
use crate::values::parameters::{Key, Type};

/// The jumps, and which way each looks.
const JUMPS: [(&[u8], Direction); 4] = [
    (b"GOTOF", Direction::Forward),
    (b"GOTOB", Direction::Backward),
    (b"GOTOC", Direction::Either),
    (b"GOTO", Direction::Either),
];

/// A line of flow control.
pub(crate) fn parse(program: &Program, word: &Word) -> Option<Statement> {
    let (at, end) = (word.start as usize, word.end());
    let source = program.source().get(..end)?;
    let (name, arguments) = names::meaning(source, at, program.dialect())?;
    let Name::Flow(named) = name else { return None };
    let rest = source.get(arguments..)?;
    let flow = match named {
        Flow::If if position(rest, b"GOTO").is_some() => Flow::JumpIf,
        Flow::Do if !rest.trim_ascii().is_empty() => Flow::Section,
        _ => named,
    };
    let block = program.block_at(at);
    Some(Statement { flow, block, label: String::new(), at, arguments, start: block, next: block, end: block })
}

/// Where a word stands in a text, in either case.
fn position(text: &[u8], word: &[u8]) -> Option<usize> {
    text.windows(word.len()).position(|window| window.eq_ignore_ascii_case(word))
}

impl Runner<'_> {
    /// Executes a line of these; gives the block to go on with.
    pub(crate) fn follow_structured(&mut self, statement: &Statement) -> usize {
        let next = statement.block + 1;
        match statement.flow {
            Flow::Until if self.holds(statement) => next,
            Flow::Until | Flow::EndLoop => statement.start + 1,
            Flow::For => self.start_for(statement),
            Flow::EndFor => self.again_for(statement),
            Flow::Jump => self.jump_from(statement.at, next),
            Flow::JumpIf => self.jump_if(statement, next),
            Flow::Case => self.jump_by_value(statement, next),
            Flow::Declare => {
                self.declare(statement.arguments);
                next
            }
            Flow::Section => {
                self.next = next;
                self.repeat_section(statement);
                self.next
            }
            _ => self.follow_label(statement),
        }
    }

    /// `REPEAT START P=3`: what lies from the label to ENDLABEL, or to this line, is run three times more; `REPEAT START
    /// END`: what lies between two labels; `REPEATB START`: the block of the label. The labels' own blocks count.
    fn repeat_section(&mut self, statement: &Statement) {
        let text = self.line_text(statement.arguments);
        let (mut names, mut times) = (Vec::new(), Some(1));
        for part in text.split_ascii_whitespace() {
            match part.strip_prefix("p=") {
                Some(count) => times = count.parse().ok(),
                None => names.push(part.as_bytes()),
            }
        }
        let (here, labels) = (statement.block, self.labels());
        let to = |label: &[u8], from, way| labels.target(label, from, way);
        let label = names.first().copied().unwrap_or(b"");
        let first = to(label, here, Direction::Backward).or_else(|| to(label, here, Direction::Forward));
        let of_block = self.table_word(statement).eq_ignore_ascii_case(b"REPEATB");
        let last = first.and_then(|first| match names.get(1) {
            _ if of_block => Some(first),
            Some(end) => to(end, first, Direction::Forward),
            None => to(b"endlabel", first, Direction::Forward)
                .filter(|end| *end < here || first > here)
                .or_else(|| here.checked_sub(1).filter(|_| first < here)),
        });
        if let (Some(first), Some(last), Some(times), true) = (first, last, times, names.len() < 3) {
            return self.repeat_between(first, last, times);
        }
        let hint = "name labels of this program, and the number of times as P=3";
        let message = "what is to be repeated, or how often, is not known".into();
        self.refuse(finding::FLOW, statement.at, message, hint);
    }

    /// The keyword of a line.
    fn table_word(&self, statement: &Statement) -> &[u8] {
        self.program.source().get(statement.at..statement.arguments).unwrap_or(&[]).trim_ascii()
    }

    /// `FOR R1=1 TO 5`: the variable, and whether its value is within the bound.
    fn for_bound(&mut self, at: usize, assign: Option<f64>) -> Option<bool> {
        let at = names::skip(self.program.source(), at, |byte| byte == b' ');
        let key = self.key(at)?;
        let source = self.program.source();
        let equals = at + position(source.get(at..)?, b"=")?;
        let (first, end) = self.value(equals + 1);
        let bound = after(source, end, b"TO").map(|to| self.value(to).0);
        let Some(bound) = bound.filter(|_| end > equals + 1) else {
            self.refuse(finding::FLOW, at, "FOR without its TO".into(), "write FOR R1=1 TO 5");
            return None;
        };
        let value = match assign {
            None => first,
            Some(step) => self.state.store.get(&key).unwrap_or(f64::NAN) + step,
        };
        self.state.store.set(key, value);
        Some(value <= bound)
    }

    fn start_for(&mut self, statement: &Statement) -> usize {
        match self.for_bound(statement.arguments, None) {
            Some(true) => statement.block + 1,
            _ => statement.end + 1,
        }
    }

    fn again_for(&mut self, statement: &Statement) -> usize {
        let start = self.table.statement(statement.start).map(|start| start.arguments);
        match start.and_then(|at| self.for_bound(at, Some(1.0))) {
            Some(true) => statement.start + 1,
            _ => statement.block + 1,
        }
    }

    /// `IF R1>0 GOTOF A`, also with ELSE and another jump.
    fn jump_if(&mut self, statement: &Statement, next: usize) -> usize {
        let (value, end) = self.value(statement.arguments);
        if end == statement.arguments {
            return next; // a fault, reported already
        }
        if value != 0.0 && !value.is_nan() {
            return self.jump_from(end, next);
        }
        let source = self.program.source();
        let line_end = self.program.blocks().get(statement.block).map_or(end, |block| block.end as usize);
        let otherwise = source.get(end..line_end).and_then(|rest| position(rest, b"ELSE"));
        otherwise.map_or(next, |offset| self.jump_from(end + offset + 4, next))
    }

    /// The jump behind the value that fits, else the one behind DEFAULT.
    fn jump_by_value(&mut self, statement: &Statement, next: usize) -> usize {
        let (value, end) = self.value(statement.arguments);
        let line_end = self.program.blocks().get(statement.block).map_or(end, |block| block.end as usize);
        let source = self.program.source().get(..line_end).unwrap_or(&[]);
        let Some(mut at) = after(source, end, b"OF").filter(|_| end > statement.arguments) else {
            self.refuse(finding::FLOW, statement.at, "CASE without its OF".into(), "write CASE(R1) OF 1 GOTOF A");
            return next;
        };
        loop {
            if let Some(otherwise) = after(source, at, b"DEFAULT") {
                return self.jump_from(otherwise, next);
            }
            let start = names::skip_blank(source, at);
            if start >= line_end {
                return next;
            }
            let (constant, behind) = self.value(start);
            if behind == start || constant == value {
                return self.jump_from(behind, next);
            }
            let jump = JUMPS.iter().find_map(|(word, _)| after(source, behind, word)).unwrap_or(behind);
            let label = names::skip_blank(source, jump);
            at = names::skip(source, label, names::is_name).max(start + 1);
        }
    }

    /// A jump written at a byte; `next` where it leads nowhere.
    fn jump_from(&mut self, at: usize, next: usize) -> usize {
        let source = self.program.source();
        let found = JUMPS.iter().find_map(|(word, direction)| Some((after(source, at, word)?, *direction)));
        let Some((target, direction)) = found else {
            self.refuse(finding::FLOW, at, "a condition without a jump".into(), "write IF R1>0 GOTOF END");
            return next;
        };
        let target = names::skip_blank(source, target);
        let end = names::skip(source, target, names::is_name);
        let label = source.get(target..end).unwrap_or(&[]);
        match self.labels().target(label, self.block, direction) {
            Some(block) => block,
            None => {
                let message = format!("there is no \"{}\" to jump to that way", finding::excerpt(label));
                self.refuse(finding::FLOW, target, message, "write the label of a block, as LABEL:, or its N number");
                next
            }
        }
    }

    /// `DEF REAL A=5, B`: what is given no value is zero.
    fn declare(&mut self, at: usize) {
        let source = self.program.source();
        let space = |at: usize| names::skip_blank(source, at);
        let start = space(at);
        let mut at = names::name_end(source, start).unwrap_or(start);
        let of = Type::of(&String::from_utf8_lossy(source.get(start..at).unwrap_or(&[])));
        at = space(at);
        while let Some(end) = names::name_end(source, at) {
            let key = Key::named(source.get(at..end).unwrap_or(&[]));
            at = space(end);
            let mut value = 0.0;
            if source.get(at) == Some(&b'=') {
                let (given, after) = self.value(at + 1);
                (value, at) = (given, space(after));
            }
            self.state.store.declare(key, of, value);
            if source.get(at) != Some(&b',') {
                return;
            }
            at = space(at + 1);
        }
    }

    /// Runs the program that a word names, P times, of an OSP Q times; one that is not in the file is a remark.
    pub(crate) fn call_named(&mut self, word: usize, request: &Request) {
        let Some(found) = self.program.words().get(word) else { return };
        let (name, repeats) = called(self.program, found);
        let times = request.get(b'P').map(|times| times.round().max(0.0) as u64);
        let (severity, message) = match (self.labels().named_program(&name), repeats) {
            (Some(start), Some(repeats)) => {
                return self.visit(start, times.unwrap_or(repeats));
            }
            (Some(start), None) if self.call_procedure(start, times.unwrap_or(1), word as i32) => return,
            (Some(_), None) => (Severity::Warning, "a call with arguments is not followed".to_owned()),
            (None, _) => (Severity::Note, format!("program {} is not in this file", name.to_ascii_uppercase())),
        };
        let hint = "put what it does into the program, or its file beside it: it is not in the path";
        self.report(severity, finding::OPAQUE, found.start as usize, message, hint);
    }

    /// `POCKET(10,R1)`: runs the program, whose `PROC POCKET(REAL L, REAL B=5)` names its arguments; whether it does so.
    fn call_procedure(&mut self, start: usize, times: u64, word: i32) -> bool {
        let program = self.program;
        let head = |word: &&Word| program.code(word) == Some(G::Procedure);
        let Some(head) = (start..start + 4).find_map(|block| program.words_of(block).iter().find(head)) else {
            return false;
        };
        let text = String::from_utf8_lossy(program.text(head)).to_ascii_lowercase();
        let Some((own, _)) = text.split_once('(').and_then(|(_, rest)| rest.split_once(')')) else { return false };
        let Some(given) = self.cycle_arguments(word) else { return false };
        let mut arguments = Vec::new();
        for (index, own) in own.split(',').enumerate() {
            let (own, default) = own.split_once('=').unwrap_or((own, "0"));
            let Some((of, name)) = own.trim().rsplit_once(' ') else { return false };
            let value = given.get(index).filter(|given| given.span != (0, 0)).map(|given| given.value);
            let Some(value) = value.or_else(|| default.trim().parse().ok()) else { return false };
            let given_back = of.split_whitespace().any(|of| of == "var"); // its value goes back to the caller
            if given_back || given.get(index).is_some_and(|given| given.text.is_some()) {
                return false;
            }
            arguments.push((name, Type::of(of.trim()), value));
        }
        if given.len() > arguments.len() {
            return false;
        }
        let depth = self.visits.len();
        self.visit(start, times);
        for (name, of, value) in arguments.into_iter().filter(|_| self.visits.len() > depth) {
            self.state.store.declare(Key::named(name.as_bytes()), of, value);
        }
        true
    }
}
