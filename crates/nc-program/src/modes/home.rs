//! Returns to stored machine positions.

use crate::drilling::cycle_arguments::numbers;
use crate::finding;
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::reading::program::Word;
use crate::run::{Runner, AXES};

/// A linear axis by the machine's name of it: `X1`.
pub(crate) const MACHINE_AXIS: u8 = b'l';

impl Runner<'_> {
    /// Through the given point to the stored machine position of the axes given (all axes when none is).
    pub(crate) fn home(&mut self, request: &Request, number: usize) {
        let some = self.names_axis(request);
        if some {
            let (through, words) = self.target(request, false);
            self.emit(MoveKind::Rapid, through, words);
        } else if !request.any(b"ABCo") {
            self.state.frame.rotary.go_home();
        }
        let home = self.state.frame.home.get(number).copied().unwrap_or_default();
        let increments = self.dialect_increments().unwrap_or([0; 3]);
        let goes = |axis: usize| !some || [AXES[axis], increments[axis]].iter().any(|l| request.get(*l).is_some());
        let end = self.on_machine([0, 1, 2].map(|axis| goes(axis).then_some(home[axis])), self.state.frame.total());
        self.emit(MoveKind::Rapid, end, [INHERITED; 3]);
        if self.program.dialect().rules.home_ends_length {
            self.cancel_tool_offset();
        }
    }

    /// M140 MB MAX: the tool's axis to the limit of its travel.
    pub(crate) fn retract(&mut self, request: &Request, word: i32) {
        if self.names_axis(request) {
            return self.note_opaque(word, "what it does beside a move is not in the path");
        }
        let third = self.state.modal.plane.axes().2;
        self.go_to_machine_zero([0, 1, 2].map(|axis| axis == third));
        self.note_opaque(word, "the limit of travel is the machine's, taken as its zero");
    }

    /// G74, G75: the axes named, by their own names (X) or the machine's (X1), whatever their values.
    pub(crate) fn fixed_point(&mut self, request: &Request, word: i32) {
        let block = self.program.words_of(self.block);
        let machine = |letter: u8| block.iter().any(|word| word.letter == MACHINE_AXIS && self.begins(word, letter));
        self.go_to_machine_zero(AXES.map(|letter| request.get(letter).is_some() || machine(letter)));
        self.note_opaque(word, "the fixed point is the machine's, taken as its zero");
    }

    /// `CYCLE800(FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, …)`: a plane that is neither moved nor turned is none;
    /// FR 1 first retracts the tool's axis. Without arguments the swivelled plane ends.
    pub(crate) fn swivel(&mut self, word: i32) {
        if self.whole_text(word).ends_with("()") {
            return;
        }
        let Some(arguments) = self.cycle_arguments(word) else { return };
        let [retracts, _, _, _, plane @ ..] = numbers::<13>(&arguments);
        let level = plane.iter().all(|value| *value == Some(0.0));
        match retracts.unwrap_or(0.0) {
            0.0 if level => {}
            1.0 if level => self.retract(&Request::new(), word),
            _ => self.unfollowed(word),
        }
    }

    fn begins(&self, word: &Word, letter: u8) -> bool {
        self.program.text(word).first().is_some_and(|first| first.eq_ignore_ascii_case(&letter))
    }

    fn go_to_machine_zero(&mut self, axes: [bool; 3]) {
        let end = self.on_machine(axes.map(|goes| goes.then_some(0.0)), self.state.frame.total());
        self.emit(MoveKind::Rapid, end, [INHERITED; 3]);
    }

    /// The program's coordinates of the place where some axes stand at those of the machine and the others where they are;
    /// `origin` is what is taken from a place of the machine. In turned coordinates a missing one is reported.
    pub(crate) fn on_machine(&mut self, places: [Option<f64>; 3], origin: [f64; 3]) -> [f64; 3] {
        let (frame, position) = (&mut self.state.frame, self.state.position);
        let Some(linear) = frame.whole else {
            return [0, 1, 2].map(|axis| places[axis].map_or(position[axis], |place| place - origin[axis]));
        };
        let stands = linear.place(position);
        let goes = [0, 1, 2].map(|axis| places[axis].map_or(stands[axis], |place| place - origin[axis]));
        let mixes = |axis: usize| (0..3).any(|other| other != axis && linear.matrix[axis][other] != 0.0);
        if (0..3).any(|axis| places[axis].is_some() && mixes(axis)) {
            frame.rename([0, 1, 2].map(mixes));
        }
        frame.back(goes)
    }

    /// The same of the axes named; without one nothing moves.
    pub(crate) fn home_named(&mut self, request: &Request, number: usize, word: i32) {
        if self.names_axis(request) {
            if number > 0 {
                self.note_opaque(word, "the second reference point is the machine's, taken as its zero");
            }
            return self.home(request, number);
        }
        let message = "a return to the reference point without an axis: nothing moves".into();
        self.warn(finding::MISPLACED, self.block_start(), message, "name the axes: G28 U0 W0, or G91 G28 Z0");
    }
}
