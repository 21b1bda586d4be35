//! The longitudinal turning cycle of the GE 2000T, taken apart into moves.

use crate::finding;
use crate::path::MoveKind;
use crate::request::Request;
use crate::run::Runner;

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
