//! Returns to stored machine positions.

use crate::finding;
use crate::path::{MoveKind, INHERITED};
use crate::request::Request;
use crate::run::{Runner, AXES};

impl Runner<'_> {
    /// Through the given point to the stored machine position of the axes given (all axes when none is).
    pub(crate) fn home(&mut self, request: &Request, number: usize) {
        let some = self.names_axis(request);
        if some {
            let (through, words) = self.target(request, false);
            self.emit(MoveKind::Rapid, through, words);
        }
        let total = self.state.frame.total();
        let home = self.state.frame.home.get(number).copied().unwrap_or_default();
        let increments = self.dialect_increments().unwrap_or([0; 3]);
        let goes = |axis: usize| !some || [AXES[axis], increments[axis]].iter().any(|l| request.get(*l).is_some());
        let end = [0, 1, 2].map(|axis| if goes(axis) { home[axis] - total[axis] } else { self.state.position[axis] });
        self.emit(MoveKind::Rapid, end, [INHERITED; 3]);
        if self.program.dialect().rules.home_ends_length {
            self.cancel_tool_offset();
        }
    }

    /// The same of the axes named; without one nothing moves.
    pub(crate) fn home_named(&mut self, request: &Request, number: usize) {
        if self.names_axis(request) {
            return self.home(request, number);
        }
        let message = "a return to the reference point without an axis: nothing moves".into();
        self.warn(finding::MISPLACED, self.block_start(), message, "name the axes: G28 U0 W0, or G91 G28 Z0");
    }
}
