//! Threads cut in passes: their depths and their moves, in the plane of (x, z), mm, x a radius.

use crate::path::MoveKind;

/// More passes than this are a slip of the depth of cut.
pub(crate) const MOST: usize = 10_000;

/// A move and where it ends.
type Step = (MoveKind, [f64; 2]);

/// A thread; its depths are counted from its crest.
pub(crate) struct Thread {
    /// Where the tool stands.
    pub start: [f64; 2],
    /// Crest where the thread ends.
    pub end: [f64; 2],
    /// Crest at the start less that at the end.
    pub taper: f64,
    /// Into the part: −1 outside, +1 inside.
    pub inward: f64,
    /// Depth of each pass.
    pub depths: Vec<f64>,
    /// Tangent of the angle at which the passes go in.
    pub slant: f64,
}

/// Slopes at the ends of a thread, over a length along Z.
pub(crate) struct Slopes {
    pub at_start: bool,
    pub at_end: bool,
    pub length: f64,
}

impl Thread {
    fn full(&self) -> f64 {
        self.depths.last().copied().unwrap_or(0.0)
    }

    fn along(&self) -> f64 {
        (self.end[1] - self.start[1]).signum()
    }

    /// Where a pass of that depth begins and ends.
    fn pass(&self, depth: f64) -> [[f64; 2]; 2] {
        let x = self.end[0] + self.inward * depth;
        [[x + self.taper, self.start[1] + self.along() * depth * self.slant], [x, self.end[1]]]
    }

    /// Fanuc's way: down square, out at 45° over the last `pull_out` of the thread's length, back to the start after each
    /// pass. The slope ends where the tool is as far out as where it started.
    pub fn square_steps(&self, pull_out: f64) -> Vec<Step> {
        let [x, z] = self.start;
        let one = |depth: &f64| {
            let [from, to] = self.pass(*depth);
            let [cut, out] = self.pulled_out(from, to, pull_out);
            let mut steps = vec![(MoveKind::Rapid, [x, from[1]]), (MoveKind::Rapid, from), (MoveKind::Thread, cut)];
            if out != cut {
                steps.push((MoveKind::Thread, out));
            }
            steps.extend([(MoveKind::Rapid, [x, out[1]]), (MoveKind::Rapid, [x, z])]);
            steps
        };
        self.depths.iter().flat_map(one).collect()
    }

    /// Where a pass leaves the thread, and the end of its slope.
    fn pulled_out(&self, from: [f64; 2], to: [f64; 2], length: f64) -> [[f64; 2]; 2] {
        let whole = (to[1] - from[1]).abs();
        let length = length.min(whole);
        let share = if length > 0.0 { length / whole } else { 0.0 };
        let cut = [to[0] - share * (to[0] - from[0]), to[1] - self.along() * length];
        let rise = length.min((self.inward * (cut[0] - self.start[0])).max(0.0));
        [cut, [cut[0] - self.inward * rise, cut[1] + self.along() * rise]]
    }

    /// LinuxCNC's way: each pass clear of its own depth by the same distance, shifted whole along the flank.
    pub fn flank_steps(&self, slopes: &Slopes) -> Vec<Step> {
        let mut steps: Vec<_> = self.depths.iter().flat_map(|depth| self.flank_pass(*depth, slopes)).collect();
        steps.push((MoveKind::Rapid, [self.start[0], self.end[1]]));
        steps
    }

    fn flank_pass(&self, depth: f64, slopes: &Slopes) -> Vec<Step> {
        let [[cut, from], [_, to]] = self.pass(depth);
        let left = self.full() - depth;
        let to = to - self.along() * left * self.slant;
        let (clear, above) = (self.start[0] - self.inward * left, cut - self.inward * self.full());
        let slope = self.along() * slopes.length;
        let mut steps = vec![(MoveKind::Rapid, [clear, from])];
        if slopes.at_start {
            steps.extend([(MoveKind::Line, [above, from]), (MoveKind::Thread, [cut, from + slope])]);
        } else {
            steps.push((MoveKind::Rapid, [cut, from]));
        }
        if slopes.at_end {
            steps.extend([(MoveKind::Thread, [cut, to - slope]), (MoveKind::Thread, [above, to])]);
        } else {
            steps.push((MoveKind::Thread, [cut, to]));
        }
        steps.push((MoveKind::Rapid, [clear, to]));
        steps
    }
}

/// Depths that grow with a root of the number of passes, to the full one, which is cut `times` times.
///
/// `first · n^(1 / degression)`: 1 is a constant depth, 2 a constant area. No step is less than `least`. `None` where
/// they make no sense.
pub(crate) fn depths(first: f64, full: f64, degression: f64, least: f64, times: usize) -> Option<Vec<f64>> {
    if !(first > 0.0 && full.is_finite() && degression >= 1.0) {
        return None;
    }
    let (mut found, mut depth) = (Vec::new(), first);
    while depth < full {
        found.push(depth);
        if found.len() > MOST {
            return None;
        }
        let next = first * ((found.len() + 1) as f64).powf(1.0 / degression);
        depth = next.max(depth + least);
    }
    found.extend(std::iter::repeat_n(full, times.min(MOST)));
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::depths;

    #[test]
    fn depths_of_equal_area_and_their_least_step() {
        assert_eq!(depths(0.5, 1.0, 2.0, 0.0, 2).unwrap(), [0.5, 0.5 * 2f64.sqrt(), 0.5 * 3f64.sqrt(), 1.0, 1.0]);
        assert_eq!(depths(0.5, 1.0, 2.0, 0.25, 1).unwrap(), [0.5, 0.75, 1.0]);
        for (first, full, degression) in [(0.0, 1.0, 1.0), (1e-9, 1.0, 1.0), (f64::NAN, 1.0, 1.0), (0.1, 1.0, 0.5)] {
            assert!(depths(first, full, degression, 0.0, 1).is_none());
        }
    }
}
