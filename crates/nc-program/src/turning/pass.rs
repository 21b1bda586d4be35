//! Simple turning cycles: a pass along, a threading pass or a facing pass, and back to where it began; the longitudinal cycle
//! of the GE 2000T, of several passes.

use crate::finding;
use crate::modes::request::Request;
use crate::path::{MoveKind, Turned, INHERITED};
use crate::run::{Runner, AXES};

/// What a simple cycle cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Down at rapid, along Z at feed, out at feed, back at rapid (G90, G77).
    Along,
    /// Down at rapid, along Z in step with the spindle, out and back at rapid (G92, G78).
    Thread,
    /// Along Z at rapid, to X at feed, back along Z at feed, out at rapid (G94, G79).
    Face,
}

/// Values that stay from pass to pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passes {
    pass: Pass,
    /// End of the cut (x, z), mm; NaN where not given yet.
    end: [f64; 2],
    /// Start less end of the cut, across the direction of cutting: a radius, or for a facing pass a length along Z.
    taper: f64,
}

impl Passes {
    pub const fn new(pass: Pass) -> Self {
        Self { pass, end: [f64::NAN; 2], taper: 0.0 }
    }

    /// The moves of one pass from (x, z), which is where it ends.
    fn steps(&self, [x, z]: [f64; 2]) -> [(MoveKind, [f64; 2]); 4] {
        use MoveKind::{Line, Rapid, Thread};
        let [x_end, z_end] = self.end;
        match self.pass {
            Pass::Along => [(Rapid, [x_end + self.taper, z]), (Line, self.end), (Line, [x, z_end]), (Rapid, [x, z])],
            Pass::Thread => {
                [(Rapid, [x_end + self.taper, z]), (Thread, self.end), (Rapid, [x, z_end]), (Rapid, [x, z])]
            }
            Pass::Face => [(Rapid, [x, z_end + self.taper]), (Line, self.end), (Line, [x_end, z]), (Rapid, [x, z])],
        }
    }
}

impl Runner<'_> {
    /// The moves of a turning cycle to the end that its block's words state.
    pub(crate) fn emit_turned(
        &mut self,
        moves: impl IntoIterator<Item = (MoveKind, [f64; 3])>,
        words: [i32; 3],
        to: [f64; 3],
    ) {
        let first = self.path.len();
        moves.into_iter().for_each(|(kind, position)| self.emit(kind, position, [INHERITED; 3]));
        self.path.turned.push(Turned { first, end: self.path.len(), words, to, milled: None });
    }

    /// A simple cycle comes into force.
    pub(crate) fn start_passes(&mut self, pass: Pass, word: i32) {
        self.state.passes = Some(Passes::new(pass));
        if pass == Pass::Thread {
            self.note_opaque(word, "how the tool is pulled out at the thread's end is the control's; taken as square");
        }
    }

    /// A block under a simple cycle: what it does not give is that of the pass before.
    pub(crate) fn pass(&mut self, request: &Request) {
        let Some(mut passes) = self.state.passes else { return };
        let (end, words) = self.target(request, false);
        for (place, axis) in [0, 2].into_iter().enumerate() {
            let increment = self.dialect_increments().is_some_and(|letters| request.any(&[letters[axis]]));
            if increment || request.any(&[AXES[axis]]) {
                passes.end[place] = end[axis];
            }
        }
        let older = if passes.pass == Pass::Face { b'K' } else { b'I' };
        let taper = request.get(b'R').or(request.get(older)).map(|taper| taper * self.state.modal.mm());
        passes.taper = taper.unwrap_or(passes.taper);
        self.state.passes = Some(passes);
        let [x, y, z] = self.state.position;
        if passes.end.iter().any(|value| value.is_nan()) {
            let message = "a simple turning cycle without the X and the Z of its end".into();
            return self.refuse(finding::MISPLACED, self.block_start(), message, "write both, or U and W");
        }
        let to = [passes.end[0], y, passes.end[1]];
        let moves = passes.steps([x, z]).map(|(kind, [x, z])| (kind, [x, y, z]));
        self.emit_turned(moves, words, to);
    }
}

/// The longitudinal turning cycle of NISTIR 6811, A.1.2, in a plane of (x, z): x a radius, mm.
#[derive(Clone, Copy, Debug)]
pub struct Turning {
    /// Where the tool stands when the cycle is called and where it returns to.
    pub start: [f64; 2],
    /// Depth of the last pass (X) and where the exit taper leaves the zone (Z), at the height of the start.
    pub end: [f64; 2],
    /// Greatest depth of cut of a pass.
    pub depth_of_cut: f64,
    /// Where the exit taper begins at the depth of the last pass.
    pub taper_start_z: f64,
}

/// More passes than this are a slip of the depth of cut.
const MOST_PASSES: f64 = 10_000.0;

/// A move of a cycle: at feed or rapid, to (x, z).
pub type Step = (bool, [f64; 2]);

impl Turning {
    /// The moves: each pass goes down at the start, cuts along Z to the taper, up the taper to the pass before, and
    /// back. Every pass takes the full depth of cut, the last what is left. `None` when the depth of cut makes no sense.
    pub fn steps(&self) -> Option<Vec<Step>> {
        let ([x_start, z_start], [x_end, _]) = (self.start, self.end);
        let total = x_end - x_start;
        let passes = (total.abs() / self.depth_of_cut - 1e-9).ceil();
        if !(self.depth_of_cut > 0.0 && (1.0..=MOST_PASSES).contains(&passes)) {
            return None;
        }
        let mut steps = Vec::new();
        let mut above = x_start;
        for pass in 1..=passes as usize {
            let depth = (pass as f64 * self.depth_of_cut).min(total.abs());
            let x = if pass as f64 == passes { x_end } else { x_start + depth.copysign(total) };
            steps.push((false, [x, z_start]));
            steps.push((true, [x, self.exit_z(x)]));
            steps.push((true, [above, self.exit_z(above)]));
            steps.push((false, [above, z_start]));
            above = x;
        }
        steps.push((false, self.start));
        Some(steps)
    }

    fn exit_z(&self, x: f64) -> f64 {
        let from_end = (x - self.end[0]) / (self.start[0] - self.end[0]);
        self.taper_start_z + from_end * (self.end[1] - self.taper_start_z)
    }
}

impl Runner<'_> {
    /// A longitudinal turning cycle, taken apart.
    pub(crate) fn turning_cycle(&mut self, request: &Request) {
        let (end, words) = self.target(request, false);
        let mm = self.state.modal.mm();
        let cycle = Turning {
            start: [self.state.position[0], self.state.position[2]],
            end: [end[0], end[2]],
            depth_of_cut: request.cycle_parameter(1).unwrap_or(0.0) * mm,
            taper_start_z: request.cycle_parameter(2).map_or(end[2], |value| value * mm),
        };
        let Some(steps) = cycle.steps() else {
            let (depth, total) = (cycle.depth_of_cut, end[0] - self.state.position[0]);
            let message = format!("a turning cycle of {total:.5} mm in passes of {depth:.5} mm");
            let hint = "give P1=, the depth of cut on the radius, and an X other than the start's";
            return self.refuse(finding::MISPLACED, self.block_start(), message, hint);
        };
        let y = self.state.position[1];
        let kind = |at_feed| if at_feed { MoveKind::Line } else { MoveKind::Rapid };
        self.emit_turned(steps.into_iter().map(|(at_feed, [x, z])| (kind(at_feed), [x, y, z])), words, end);
    }
}

#[cfg(test)]
mod tests {
    use super::Turning;

    #[test]
    fn passes_of_the_full_depth_then_the_rest() {
        let cycle = Turning { start: [10.0, 1.0], end: [5.0, -20.0], depth_of_cut: 2.0, taper_start_z: -15.0 };
        let steps = cycle.steps().unwrap();
        let depths: Vec<f64> = steps.chunks(4).map(|pass| pass[0].1[0]).collect();
        assert_eq!(depths, [8.0, 6.0, 5.0, 10.0]);
        assert_eq!(steps[9], (true, [5.0, -15.0]));
        assert_eq!(steps[10], (true, [6.0, -16.0]));
        assert_eq!(steps.last(), Some(&(false, [10.0, 1.0])));
    }

    #[test]
    fn a_depth_of_cut_that_makes_no_sense() {
        for depth_of_cut in [0.0, -1.0, 1e-9, f64::NAN] {
            let cycle = Turning { start: [10.0, 1.0], end: [5.0, -20.0], depth_of_cut, taper_start_z: -15.0 };
            assert!(cycle.steps().is_none());
        }
    }
}
