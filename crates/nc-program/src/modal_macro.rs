//! Macros called after each move (G66, until G67), which nest as Mitsubishi's M700V manual has it (page 308).

use crate::arguments::Arguments;
use crate::finding;
use crate::request::Request;
use crate::run::Runner;
use crate::visit::{times, Visit};

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
        let Some((start, arguments)) = self.macro_called(request, word) else { return };
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
