//! Macros called with arguments (G65), which become local parameters, or after each move (G66, until G67), which nest as
//! Mitsubishi's M700V manual has it (page 308).

use crate::dialect::G;
use crate::finding::{self, Severity, Unseen};
use crate::modes::modal::Motion;
use crate::modes::request::Request;
use crate::order::visit::{times, Visit};
use crate::reading::program::{Program, Word, WordKind};
use crate::run::Runner;
use crate::values::expression::is_vacant;

/// Letters in order of the parameter that each becomes, from #1; a space where there is none.
const LETTERS: &[u8; 26] = b"ABCIJKDEF H M   QRSTUVWXYZ";

/// The parameter that the first I becomes.
const FIRST_OF_SETS: u32 = 4;

/// Whether a block calls a macro that touches the work or the tool: Renishaw's Inspection Plus, by its number.
pub fn calls_touch(program: &Program, block: usize) -> bool {
    let words = program.words_of(block);
    let is_touch = |word: &Word| {
        let number = (word.letter == b'P' && word.kind == WordKind::Number).then_some(word.value.round() as u32);
        matches!(number, Some(9801..=9804 | 9810..=9823 | 9832..=9834 | 9843 | 9851..=9853))
    };
    words.iter().any(|word| program.code(word) == Some(G::CallMacro)) && words.iter().any(is_touch)
}

/// Numbers of parameters and their values.
pub(crate) type Arguments = Vec<(u32, f64)>;

impl Runner<'_> {
    /// G65 P, L times.
    pub(crate) fn call_macro(&mut self, request: &Request, word: i32) {
        match self.macro_called(request) {
            Some((start, arguments)) => self.visit_macro(start, times(request), &arguments),
            None if calls_touch(self.program, self.block) => {
                self.touched(word, 100..150);
                self.state.modal.motion = Motion::Opaque;
            }
            None => self.note_unseen(word, Unseen::Block, "what it does is not in the path"),
        }
    }

    /// The block at which the macro of P starts, and its arguments. One that is not in this file is not followed.
    pub(crate) fn macro_called(&mut self, request: &Request) -> Option<(usize, Arguments)> {
        let number = request.get(b'P').filter(|p| (0.0..=99_999_999.0).contains(p)).map(|p| p.round() as u32);
        let start = number.and_then(|number| self.labels().program(number))?;
        let (sets, numbered) = (self.argument_sets(), LETTERS.iter().enumerate());
        let given = numbered.filter_map(|(place, letter)| {
            let number = place as u32 + 1;
            let in_set = !sets.is_empty() && (4..=6).contains(&number);
            Some((request.word(*letter), number, request.get(*letter).filter(|_| !in_set)?))
        });
        let mut all: Vec<_> = given.collect();
        all.extend(&sets);
        all.sort_by_key(|(word, ..)| *word); // of two for one parameter the later counts
        Some((start, all.into_iter().map(|(_, number, value)| (number, value)).collect()))
    }

    /// I, J and K that stand more than once in the block: #4 to #6, then #7 to #9 and so on, a set for each that does not
    /// come after the one before in the order I, J, K (argument specification II), each behind the index of its word. Empty
    /// where none is repeated.
    fn argument_sets(&mut self) -> Vec<(i32, u32, f64)> {
        let program = self.program;
        let words = program.word_range(self.block).map(|index| (index as i32, &program.words()[index]));
        let words = words.filter(|(_, word)| b"IJK".contains(&word.letter));
        let words: Vec<_> =
            words.filter(|(_, word)| matches!(word.kind, WordKind::Number | WordKind::Expression)).collect();
        let repeated = words
            .iter()
            .enumerate()
            .any(|(at, (_, word))| words[..at].iter().any(|(_, one)| one.letter == word.letter));
        let (mut sets, mut first, mut last) = (Vec::new(), FIRST_OF_SETS, 0);
        for (index, word) in words.into_iter().filter(|_| repeated) {
            if word.letter <= last {
                first += 3;
            }
            last = word.letter;
            let value = match word.kind {
                WordKind::Number if program.text(word).contains(&b'.') || word.value == 0.0 => word.value,
                WordKind::Number => {
                    let what = "an argument that comes again is read with a decimal point alone".to_owned();
                    self.refuse(finding::NUMBER, word.start as usize, what, "write a point");
                    f64::NAN
                }
                _ => self.value(program.value_start(word)).0,
            };
            sets.push((index, first + u32::from(word.letter - b'I'), value));
        }
        sets
    }

    /// Runs a macro, with parameters of its own.
    pub(crate) fn visit_macro(&mut self, start: usize, times: u64, arguments: &[(u32, f64)]) {
        let depth = self.visits.len();
        self.visit(start, times);
        if self.visits.len() > depth {
            self.state.store.enter_macro(arguments);
            self.owns_parameters();
        }
    }

    /// Whether a value at a byte is nothing but a parameter: one that was left out makes a word as good as not written.
    pub(crate) fn is_parameter(&self, at: usize, end: usize) -> bool {
        let text = self.program.source().get(at..end).unwrap_or(&[]).trim_ascii();
        text.split_first().is_some_and(|(mark, digits)| *mark == b'#' && digits.iter().all(u8::is_ascii_digit))
    }

    /// Reports a value that an argument left out would decide: the control may take it as zero.
    pub(crate) fn require_value(&mut self, value: f64, at: usize) {
        if value.is_nan() && !is_vacant(value) && self.in_macro() {
            let message = "an argument that was left out is part of this value".to_owned();
            self.refuse(finding::EXPRESSION, at, message, "give the argument where the macro is called");
        }
    }
}

/// So many macros may be in force.
const LEVELS: usize = 4;

/// A macro that every move calls.
#[derive(Clone, Debug)]
pub(crate) struct ModalMacro {
    start: usize,
    times: u64,
    arguments: Arguments,
}

impl Runner<'_> {
    /// G66 P, L times, with arguments. What is not in this file is not followed.
    pub(crate) fn set_modal_macro(&mut self, request: &Request, word: i32) {
        let Some((start, arguments)) = self.macro_called(request) else {
            let (what, hint) = ("what it does is not in the path", "put the macro into the program's own file");
            return self.report_unseen(Severity::Warning, Unseen::Block, word, what, hint);
        };
        let full = self.state.modal_macros.len() >= LEVELS;
        if full {
            let message =
                format!("{}: more than {LEVELS} macros after each move are not followed", self.word_text(word));
            self.warn(finding::OPAQUE, self.word_start(word), message, "end the ones before by G67");
        }
        if !(full || self.changes_its_own_call(word)) {
            self.state.modal_macros.push(ModalMacro { start, times: times(request), arguments });
        }
    }

    /// G67: of several macros the last one ends.
    pub(crate) fn end_modal_macro(&mut self, word: i32) {
        if !self.changes_its_own_call(word) {
            self.state.modal_macros.pop();
        }
    }

    /// After a move: one of the program calls the last macro, one of that macro the one before it, and so on.
    pub(crate) fn call_modal_macro(&mut self) {
        let macros = &self.state.modal_macros;
        let Some(called) = macros.len().checked_sub(self.modal_calls() + 1).and_then(|index| macros.get(index)) else {
            return;
        };
        let (ModalMacro { start, times, arguments }, depth) = (called.clone(), self.visits.len());
        self.visit_macro(start, times, &arguments);
        if let Some(Visit::Program { modal, .. }) = self.visits.get_mut(depth) {
            *modal = true;
        }
    }

    /// How many of the calls under way came after a move.
    fn modal_calls(&self) -> usize {
        self.visits.iter().filter(|visit| matches!(visit, Visit::Program { modal: true, .. })).count()
    }

    /// Says, of a code in a macro that runs after a move, that it is not followed.
    fn changes_its_own_call(&mut self, word: i32) -> bool {
        let inside = self.modal_calls() > 0;
        if inside {
            let message = format!("{}: inside of a macro after each move it is not followed", self.word_text(word));
            self.warn(finding::OPAQUE, self.word_start(word), message, "say it in the program that calls the macro");
        }
        inside
    }
}
