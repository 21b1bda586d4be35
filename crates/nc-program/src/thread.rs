//! Threads cut in passes (G76): LinuxCNC's, and those of Fanuc and Haas lathes.

use crate::dialect::FlowStyle;
use crate::finding;
use crate::path::{MoveKind, INHERITED};
use crate::request::Request;
use crate::run::Runner;

/// More passes than this are a slip of the depth of cut.
const MOST: usize = 10_000;
/// Lengths of Fanuc's G76 that take no decimal point count such steps: inch and mm.
const STEP: [f64; 2] = [1e-4, 1e-3];

/// What Fanuc's first block of two says, for those that follow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThreadData {
    finishes: usize,
    angle: f64,
    least: f64,
    allowance: f64,
}

impl ThreadData {
    pub const NONE: Self = Self { finishes: 1, angle: 0.0, least: 0.0, allowance: 0.0 };
}

/// A thread in the plane of (x, z), mm, x a radius; its depths are counted from its crest.
struct Thread {
    /// Where the tool stands.
    start: [f64; 2],
    /// Crest where the thread ends.
    end: [f64; 2],
    /// Crest at the start less that at the end.
    taper: f64,
    /// Into the part: −1 outside, +1 inside.
    inward: f64,
    /// Depth of each pass.
    depths: Vec<f64>,
    /// Tangent of the angle at which the passes go in.
    slant: f64,
}

impl Thread {
    fn along(&self) -> f64 {
        (self.end[1] - self.start[1]).signum()
    }

    /// Where a pass of that depth begins and ends: its x at both, and its z.
    fn pass(&self, depth: f64) -> [[f64; 2]; 2] {
        let x = self.end[0] + self.inward * depth;
        [[x + self.taper, self.start[1] + self.along() * depth * self.slant], [x, self.end[1]]]
    }
}

/// Depths that grow with a root of the number of passes, to the full one, which is cut `times` times.
///
/// `first · n^(1 / degression)`: 1 is a constant depth, 2 a constant area. No step is less than `least`.
fn depths(first: f64, full: f64, degression: f64, least: f64, times: usize) -> Option<Vec<f64>> {
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

impl Runner<'_> {
    /// G76 of either kind.
    pub(crate) fn thread_cycle(&mut self, request: &Request, word: i32) {
        if self.program.dialect().flow != FlowStyle::Macro {
            self.lead_mm = request.get(b'P').map_or(f64::NAN, |lead| lead * self.state.modal.mm());
            self.linuxcnc_thread(request);
        } else if self.names_axis(request) {
            self.macro_thread(request, word);
        } else {
            self.state.thread = self.thread_data(request);
        }
    }

    fn refuse_thread(&mut self) {
        let hint = "a threading cycle wants its end, the depth of the first pass and a greater one of the thread";
        let message = "a threading cycle whose depths make no sense".to_owned();
        self.refuse(finding::MISPLACED, self.block_start(), message, hint);
    }

    /// P lead, Z end, I crest less position, J first and K full depth, R degression, Q angle, H further finishing passes,
    /// E length of the slopes at the ends that L tells: 1 the start's, 2 the end's, 3 both. X stays the driving line.
    fn linuxcnc_thread(&mut self, request: &Request) {
        let [x, y, z] = self.state.position;
        let across = |letter: u8| request.get(letter).map(|value| value * self.state.modal.axis_mm(0));
        let peak = across(b'I').unwrap_or(f64::NAN);
        let (end, _) = self.target(request, false);
        let times = request.get(b'H').unwrap_or(0.0).round().clamp(0.0, MOST as f64) as usize + 1;
        let (first, full) = (across(b'J').unwrap_or(f64::NAN), across(b'K').unwrap_or(f64::NAN));
        let found = depths(first, full, request.get(b'R').unwrap_or(1.0), 0.0, times).filter(|_| !peak.is_nan());
        let Some(depths) = found else { return self.refuse_thread() };
        let slant = request.get(b'Q').unwrap_or(0.0).to_radians().tan();
        let thread =
            Thread { start: [x, z], end: [x + peak, end[2]], taper: 0.0, inward: peak.signum(), depths, slant };
        let slopes = request.get(b'L').unwrap_or(0.0).round() as i64;
        let slope = request.get(b'E').unwrap_or(0.0) * self.state.modal.mm() * thread.along();
        for depth in &thread.depths {
            let [[cut, from], [_, to]] = thread.pass(*depth);
            let left = full - depth;
            let to = to - thread.along() * left * thread.slant;
            let (clear, above) = (x - thread.inward * left, cut - thread.inward * full);
            let mut go = |kind: MoveKind, x: f64, z: f64| self.emit(kind, [x, y, z], [INHERITED; 3]);
            go(MoveKind::Rapid, clear, from);
            if slopes & 1 == 1 {
                go(MoveKind::Line, above, from);
                go(MoveKind::Thread, cut, from + slope);
            } else {
                go(MoveKind::Rapid, cut, from);
            }
            if slopes & 2 == 2 {
                go(MoveKind::Thread, cut, to - slope);
                go(MoveKind::Thread, above, to);
            } else {
                go(MoveKind::Thread, cut, to);
            }
            go(MoveKind::Rapid, clear, to);
        }
        self.emit(MoveKind::Rapid, [x, y, end[2]], [INHERITED; 3]);
    }

    /// `P011060`: passes of full depth, pull-out, angle of the tool; Q least step, R allowance of the finishing pass.
    fn thread_data(&self, request: &Request) -> ThreadData {
        let packed = request.get(b'P').unwrap_or(0.0).round().clamp(0.0, 999_999.0) as usize;
        let before = self.state.thread;
        ThreadData {
            finishes: if request.any(b"P") { (packed / 10_000).max(1) } else { before.finishes },
            angle: if request.any(b"P") { (packed % 100) as f64 } else { before.angle },
            least: self.stepped(request, b'Q').unwrap_or(before.least),
            allowance: request.get(b'R').map_or(before.allowance, |r| r * self.state.modal.mm()),
        }
    }

    /// A length that may be written as a number of least steps: mm.
    fn stepped(&self, request: &Request, letter: u8) -> Option<f64> {
        let value = request.get(letter)?;
        let step = if self.has_point(request.word(letter)) { 1.0 } else { STEP[usize::from(!self.state.modal.inch)] };
        Some(value * self.state.modal.mm() * step)
    }

    /// Fanuc: X, Z end at the root, R taper, P height, Q depth of the first pass; Haas: I, K, D, and A the tool's angle.
    fn macro_thread(&mut self, request: &Request, word: i32) {
        let mm = self.state.modal.mm();
        let ([x, y, z], (end, _)) = (self.state.position, self.target(request, false));
        let one_block = request.any(b"K");
        let data = if one_block { ThreadData::NONE } else { self.state.thread };
        let (height, first) = if one_block {
            (request.get(b'K').map(|k| k * mm), self.stepped(request, b'D'))
        } else {
            (self.stepped(request, b'P'), self.stepped(request, b'Q'))
        };
        let (height, first) = (height.unwrap_or(f64::NAN), first.unwrap_or(f64::NAN));
        let angle = if one_block { request.get(b'A').unwrap_or(0.0) } else { data.angle };
        let taper = request.get(b'R').or(request.get(b'I')).unwrap_or(0.0) * mm;
        let rough = depths(first, height - data.allowance, 2.0, data.least, 1);
        let Some(mut depths) = rough.filter(|_| height >= first) else { return self.refuse_thread() };
        if data.allowance > 0.0 {
            depths.push(height);
        }
        depths.extend(std::iter::repeat_n(height, data.finishes - 1));
        self.note_opaque(
            word,
            "where its passes begin and are pulled out is the control's; taken along the flank, square",
        );
        let inward = (end[0] - x).signum();
        let crest = end[0] - inward * height;
        let slant = (angle / 2.0).to_radians().tan();
        let thread = Thread { start: [x, z], end: [crest, end[2]], taper, inward, depths, slant };
        for depth in &thread.depths {
            let [from, to] = thread.pass(*depth);
            let steps = [(MoveKind::Rapid, [x, from[1]]), (MoveKind::Rapid, from), (MoveKind::Thread, to)];
            let back = [(MoveKind::Rapid, [x, to[1]]), (MoveKind::Rapid, [x, z])];
            for (kind, [x, z]) in steps.into_iter().chain(back) {
                self.emit(kind, [x, y, z], [INHERITED; 3]);
            }
        }
    }
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
