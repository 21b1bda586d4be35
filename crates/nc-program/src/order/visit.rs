//! Calls by number: subprograms, and the contour that a finishing cycle runs.

use crate::dialect::{FlowStyle, G};
use crate::finding::{self, Severity, Unseen};
use crate::modes::frame::Frame;
use crate::modes::linear::Linear;
use crate::modes::modal::Modal;
use crate::modes::request::{Jump, Request};
use crate::order::labels::{label, program_name, Labels};
use crate::path::{MoveKind, INHERITED};
use crate::reading::names::is_name;
use crate::reading::program::Word;
use crate::run::Runner;
use crate::turning::rough::Rough;

/// Calls may nest this deep.
const DEPTH: usize = 64;

/// What a subprogram that saves brings back at its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Saved {
    modal: Modal,
    register: [f64; 3],
    fine: [f64; 3],
    frame: Option<Linear>,
}

/// Somewhere to come back from.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Visit {
    /// A subprogram: its first block, the runs left, and the block to go on with; whether it has parameters of its own,
    /// and whether it was called after a move (G66).
    Program { start: usize, left: u64, back: usize, own: bool, modal: bool, saved: Option<Saved> },
    /// A contour: its last block, the block to go on with, the machine position to return to, if any, and the modal state that
    /// is put back then.
    Contour { last: usize, back: usize, from: Option<[f64; 3]>, after: Option<Modal> },
}

impl Visit {
    /// Runs that are left.
    pub(crate) fn left(&self) -> u64 {
        match self {
            Self::Program { left, .. } => *left,
            Self::Contour { .. } => 0,
        }
    }
}

impl Runner<'_> {
    /// Whether the run ends here: the next program's O number is reached. In a call the call ends.
    pub(crate) fn leaves_program(&mut self) -> bool {
        let starts = match self.program.dialect().flow {
            FlowStyle::Macro => label(self.program, self.block).is_some_and(|(letter, _)| letter == b'O'),
            FlowStyle::Structured => program_name(self.program, self.block).is_some(),
            _ => false,
        };
        if !starts || self.state.program_start.is_some_and(|start| start == self.block) {
            return false;
        }
        if self.state.program_start.is_none() && self.path.is_empty() {
            self.state.program_start = Some(self.block);
            return false;
        }
        !self.go_back()
    }

    /// Follows the block's call or return.
    pub(crate) fn jump(&mut self, request: &mut Request) {
        let target = request.get(b'P');
        match request.jump {
            Jump::None => {}
            Jump::Program => self.call_program(request),
            Jump::Elsewhere => {
                let message = "what runs next is not in this file, or depends on a signal of the machine".into();
                self.refuse(
                    finding::FLOW,
                    self.block_start(),
                    message,
                    "put it into the program's own file, without it",
                );
            }
            Jump::Named(word) => self.call_named(word, request),
            Jump::Block => {
                let (number, at) = (target.unwrap_or(f64::NAN), self.word_start(request.word(b'P')));
                if let Some(start) = self.numbered_block(number, at) {
                    self.visit(start, times(request));
                }
            }
            Jump::Return => {
                let called = self.go_back();
                request.ends = !called && target.is_none();
                if let Some(number) = target {
                    // P is the number of a block of the program that called.
                    let from = if called { self.next.saturating_sub(1) } else { self.block };
                    if let Some(block) = self.numbered_from(number, self.word_start(request.word(b'P')), from) {
                        self.next = block;
                    }
                }
            }
        }
    }

    /// `M98 P1000 L3`; without L also `M98 P31000`, the repetitions before the last four digits.
    fn call_program(&mut self, request: &Request) {
        let begins_at = [b'Q', self.program.dialect().rules.begins_at];
        if let Some(letter) = begins_at.into_iter().find(|letter| request.any(&[*letter])) {
            let word = self.word_text(request.word(letter));
            let message = format!("{word}: where in the program the call begins is not followed");
            let hint = "call a program from its beginning";
            return self.refuse(finding::FLOW, self.block_start(), message, hint);
        }
        let number = request.get(b'P').filter(|p| (0.0..=99_999_999.0).contains(p)).map_or(0, |p| p.round() as u32);
        let labels = self.labels();
        let (split, repeats) = (number % 10_000, u64::from(number / 10_000));
        let found = labels.program(number).map(|start| (start, times(request)));
        let packed = || labels.program(split).filter(|_| repeats > 0).map(|start| (start, repeats));
        let Some((start, left)) = found.or_else(packed) else {
            let message = format!("program O{number:04} is not in this file");
            let hint = "put it into the program's own file: what it does is not in the path";
            return self.refuse(finding::FLOW, self.block_start(), message, hint);
        };
        self.visit(start, left);
    }

    pub(crate) fn visit(&mut self, start: usize, left: u64) {
        if left == 0 || self.too_deep() {
            return;
        }
        let own = self.program.dialect().flow == FlowStyle::Structured; // what it declares
        if own {
            self.state.store.enter_procedure();
        }
        self.path.enter_call(self.block);
        self.visits.push(Visit::Program { start, left, back: self.next, own, modal: false, saved: None });
        (self.state.program_start, self.next) = (Some(start), start);
    }

    /// `CALL PGM TNC:\PLATE\BORES.H`: the program of that name in this text.
    pub(crate) fn call_file(&mut self, word: i32) {
        let text = self.whole_text(word).to_lowercase();
        let path = text.trim_start_matches("call pgm").trim_matches(['"', ' ', '\t']);
        let name = path.rsplit(['\\', '/', ':']).next().unwrap_or(path);
        let name = name.strip_suffix(".h").unwrap_or(name);
        match self.labels().named_program(name) {
            Some(start) => self.visit(start, 1),
            None => {
                let hint = format!(
                    "put {}.H into the program's folder, or what it does into the program",
                    name.to_uppercase()
                );
                let what = "what it does is not in the path";
                self.report_unseen(Severity::Warning, Unseen::Block, word, what, &hint);
            }
        }
    }

    /// END PGM: back to where the program was called, whatever sections are under way in it.
    pub(crate) fn end_file(&mut self) {
        let called = |visit: &Visit| match visit {
            Visit::Program { start, .. } => program_name(self.program, *start).is_some(),
            Visit::Contour { .. } => false,
        };
        match self.visits.iter().rposition(called) {
            Some(index) => {
                while self.visits.len() > index + 1 {
                    self.visits.pop();
                    self.path.leave_call();
                }
                self.go_back();
            }
            None => self.next = usize::MAX,
        }
    }

    /// Whether a call under way has parameters of its own.
    pub(crate) fn in_macro(&self) -> bool {
        self.program.dialect().flow == FlowStyle::Macro
            && self.visits.iter().any(|visit| matches!(visit, Visit::Program { own: true, .. }))
    }

    /// The call just made has parameters of its own.
    pub(crate) fn owns_parameters(&mut self) {
        if let Some(Visit::Program { own, .. }) = self.visits.last_mut() {
            *own = true;
        }
    }

    fn too_deep(&mut self) -> bool {
        let deep = self.visits.len() >= DEPTH;
        if deep {
            let message = format!("programs call one another more than {DEPTH} deep");
            self.refuse(finding::LIMIT, self.block_start(), message, "check what ends the recursion");
        }
        deep
    }

    /// Ends the innermost call, or starts its next run. False when there is none.
    pub(crate) fn go_back(&mut self) -> bool {
        while let Some(visit) = self.visits.pop() {
            let Visit::Program { start, left, back, own, modal, saved } = visit else {
                self.path.leave_call();
                continue;
            };
            (self.state.program_start, self.next) = (Some(usize::MAX), back);
            if left > 1 {
                self.visits.push(Visit::Program { start, left: left - 1, back, own, modal, saved });
                (self.state.program_start, self.next) = (Some(start), start);
            } else {
                self.path.leave_call();
                if own {
                    self.state.store.leave();
                }
                if let Some(saved) = saved {
                    self.bring_back(saved);
                }
            }
            return true;
        }
        false
    }

    /// PROC with SAVE: the caller's modes and shift come back when the program ends.
    pub(crate) fn enter_procedure(&mut self, word: i32) {
        let saves = self.whole_text(word).as_bytes().split(|byte| !is_name(*byte)).any(|name| name == b"SAVE");
        let (modal, Frame { register, fine, parts: [frame, ..], .. }) = (self.state.modal, &self.state.frame);
        let (register, fine, frame) = (*register, *fine, *frame);
        if let Some(Visit::Program { saved, .. }) = self.visits.last_mut().filter(|_| saves) {
            *saved = saved.or(Some(Saved { modal, register, fine, frame }));
        }
    }

    /// The modes as they were; tool, speed and the work offset stay as they are, and so does F in the same unit.
    fn bring_back(&mut self, saved: Saved) {
        let now = self.state.modal;
        self.state.modal = Modal {
            feed: if now.feed_mode == saved.modal.feed_mode { now.feed } else { -1.0 },
            spindle_speed: now.spindle_speed,
            spindle_limit: now.spindle_limit,
            tool: now.tool,
            spindle_tool: now.spindle_tool,
            work_offset: now.work_offset,
            ..saved.modal
        };
        self.reframe(|frame| {
            (frame.register, frame.fine, frame.parts[0]) = (saved.register, saved.fine, saved.frame);
            frame.shift = saved.register;
        });
    }

    /// A finishing cycle runs the contour from N of P to N of Q.
    pub(crate) fn finish_contour(&mut self, request: &Request, word: i32) {
        if !request.any(b"P") || !request.any(b"Q") {
            let message = format!("{} without P and Q: nothing moves", self.word_text(word));
            return self.warn(finding::MISPLACED, self.word_start(word), message, "write G70 P.. Q..");
        }
        let Some(blocks) = self.contour_blocks(request) else { return };
        self.visit_contour(blocks, self.next, None, true);
    }

    pub(crate) fn visit_contour(
        &mut self,
        (first, last): (usize, usize),
        back: usize,
        after: Option<Modal>,
        returns: bool,
    ) {
        if !self.too_deep() {
            let from = self.state.frame.machine(self.state.position);
            self.path.enter_call(self.block);
            self.visits.push(Visit::Contour { last, back, from: returns.then_some(from), after });
            self.next = first;
        }
    }

    /// A roughing cycle cuts down to that contour, and passes its blocks over; without P and Q it is the first of two blocks.
    pub(crate) fn rough_contour(&mut self, request: &Request, rough: Rough, word: i32) {
        if !request.any(b"P") || !request.any(b"Q") {
            return self.rough_data(request, rough);
        }
        let Some((first, last)) = self.contour_blocks(request) else { return };
        if self.options.roughing {
            self.rough(request, rough, word, (first, last));
        } else {
            let what = "its roughing passes are not in the path; the contour is run by its finishing cycle";
            self.note_opaque(word, what);
        }
        self.next = if self.block < last { last + 1 } else { self.next };
        if self.contour_to_run(word, (first, last)) {
            let ends = [b'P', b'Q'].map(|letter| request.get(letter).unwrap_or(f64::NAN));
            if !self.labels().finishes(ends) {
                self.visit_contour((first, last), self.next, None, true);
            }
        }
    }

    /// Whether a contour that is roughed has to be run even where no cycle finishes it: by a field over the program.
    pub(crate) fn contour_to_run(&mut self, word: i32, (first, last): (usize, usize)) -> bool {
        let run = !self.options.roughing && self.options.roughed_contours;
        if run {
            self.roughed.push((word, first, last));
        }
        run
    }

    /// Reports the first roughing cycle whose contour has not been run.
    pub(crate) fn require_contours_run(&mut self) {
        let blocks = &self.path.block;
        let is_run = |first: usize, last: usize| blocks.iter().any(|block| (first..=last).contains(&(*block as usize)));
        let Some((word, ..)) = self.roughed.iter().find(|(_, first, last)| !is_run(*first, *last)).copied() else {
            return;
        };
        let message = format!("{}: its contour is not run by the finishing cycle that names it", self.word_text(word));
        let hint = "run the finishing cycle, or take it out: the contour is then displaced for the roughing alone";
        self.refuse(finding::FLOW, self.word_start(word), message, hint);
    }

    /// The blocks from N of P to N of Q. None in a contour that is drawn itself.
    fn contour_blocks(&mut self, request: &Request) -> Option<(usize, usize)> {
        let number = |letter: u8| (request.get(letter).unwrap_or(f64::NAN), self.word_start(request.word(letter)));
        let ((first, at_first), (last, at_last)) = (number(b'P'), number(b'Q'));
        let (first, last) = (self.numbered_block(first, at_first), self.numbered_block(last, at_last));
        let (mut first, last) = (first?, last?);
        let cycles = |word: &Word| matches!(self.program.code(word), Some(G::FinishContour | G::RoughContour(_)));
        // A number that is there twice: a contour with a cycle in it is none, and is not the one that is meant.
        while let Some(cycle) = (first..=last).find(|block| self.program.words_of(*block).iter().any(cycles)) {
            let next = self.labels().block(request.get(b'P').unwrap_or(f64::NAN).round() as u32, cycle);
            let Some((next, _)) = next.filter(|(next, _)| (cycle + 1..=last).contains(next)) else { break };
            first = next;
        }
        if last < first {
            let hint = "P names the first block of the contour, Q the last";
            self.refuse(finding::FLOW, at_last, "the contour's last block is before its first".into(), hint);
        } else if (first..=last).any(|block| self.program.words_of(block).iter().any(cycles)) {
            let message = "the contour of this cycle has a cycle with a contour in it".into();
            self.refuse(
                finding::FLOW,
                at_first,
                message,
                "number the contour's first and last block once in a program",
            );
            return None;
        } else if self.draws {
            let hint = "write the contour with moves alone, outside of its cycle";
            self.refuse(finding::FLOW, self.block_start(), "a contour that runs on a contour".into(), hint);
        }
        (first <= last && !self.draws).then_some((first, last))
    }

    /// After the last block of a contour: back to where its cycle began, by a rapid move.
    pub(crate) fn end_contour(&mut self) {
        let Some(Visit::Contour { last, back, from, after }) = self.visits.last().copied() else { return };
        if last != self.block {
            return;
        }
        self.visits.pop();
        self.path.leave_call();
        self.next = back;
        self.state.modal = after.unwrap_or(self.state.modal);
        self.state.comes_at_rapid = false;
        let Some(from) = from else { return };
        let total = self.state.frame.total();
        let end = self.state.frame.back([0, 1, 2].map(|axis| from[axis] - total[axis]));
        if end != self.state.position {
            self.emit(MoveKind::Rapid, end, [INHERITED; 3]);
            self.trace_return();
        }
    }

    /// The block of an N number; one that is missing, or there more than once, is reported.
    pub(crate) fn numbered_block(&mut self, number: f64, at: usize) -> Option<usize> {
        self.numbered_from(number, at, self.block)
    }

    /// The same, looked for after a block, in the program that it is of.
    fn numbered_from(&mut self, number: f64, at: usize, from: usize) -> Option<usize> {
        if number.is_nan() {
            return None; // reported already
        }
        let whole = (0.0..=99_999_999.0).contains(&number).then(|| number.round() as u32);
        match whole.and_then(|whole| self.labels().block(whole, from)) {
            Some((block, several)) => {
                if several {
                    let message = format!("block N{number} is there more than once: the next one is taken");
                    self.warn(finding::FLOW, at, message, "number each block that is called by its number once");
                }
                Some(block)
            }
            None => {
                let message = format!("block N{number} is not in this program");
                self.refuse(finding::FLOW, at, message, "write the N number of a block");
                None
            }
        }
    }

    pub(crate) fn labels(&self) -> &Labels {
        self.labels.get_or_init(|| Labels::read(self.program))
    }
}

/// L: how often; once without it.
pub(crate) fn times(request: &Request) -> u64 {
    request.get(b'L').map_or(1, |times| times.round().max(0.0) as u64)
}
