//! Where the tool was at the last touch: COORDS_ACTUAL of [6876 §3.3], whether the correction was in force or not.

use error_eval::Vector;

/// Remembers where the tool was, because a touch that is seen in a period happened where the last one sent the drives.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Latch {
    touched: bool,
    tool_was_at: Option<Vector>,
    /// Machine coordinates, mm.
    pub(super) at: Vector,
}

impl Latch {
    /// At the rising edge of `touch` keeps where the last period sent the tool.
    pub(super) fn take(&mut self, touch: bool) {
        if let (true, false, Some(at)) = (touch, self.touched, self.tool_was_at) {
            self.at = at;
        }
        self.touched = touch;
    }

    /// Where this period sends the tool: command + correction + E, with E = −`model`. With nothing in force that is
    /// COORDS_CONTROLLER − COMP_MTG, with all of it the command itself, and it holds on the way from one to the other.
    pub(super) fn send(&mut self, position: &Vector, correction: &Vector, model: &Vector) {
        let mut at = *position;
        for ((at, c), model) in at.iter_mut().zip(correction).zip(model) {
            *at += c - model;
        }
        self.tool_was_at = at.iter().all(|part| part.is_finite()).then_some(at);
    }
}
