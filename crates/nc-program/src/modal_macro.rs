//! Macros called after each move (G66, until G67).

use crate::arguments::Arguments;
use crate::finding;
use crate::request::Request;
use crate::run::Runner;
use crate::visit::{times, Visit};

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
        if self.state.modal_macro.is_some() {
            let message =
                format!("{}: a macro after each move is in force; of two one is followed", self.word_text(word));
            let hint = "end the one before by G67, or let one macro call the other by G65";
            self.warn(finding::OPAQUE, self.word_start(word), message, hint);
        }
        self.state.modal_macro = Some(ModalMacro { start, times: times(request), arguments });
    }

    /// After a move: the macro in force is called, but after those that it makes itself.
    pub(crate) fn call_modal_macro(&mut self) {
        let Some(ModalMacro { start, times, arguments }) = self.state.modal_macro.clone() else { return };
        let own_move = |visit: &Visit| matches!(visit, Visit::Program { start: of, own: true, .. } if *of == start);
        if !self.visits.iter().any(own_move) {
            self.visit_macro(start, times, &arguments);
        }
    }
}
