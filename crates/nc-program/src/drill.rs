//! Drilling cycles taken apart: to the hole, to the plane R, down, and out again.

use crate::dialect::FlowStyle;
use crate::finding;
use crate::motion::POLAR;
use crate::path::{MoveKind, INHERITED};
use crate::request::Request;
use crate::run::{Runner, AXES};

/// How far above the last depth the tool goes back down at rapid after a peck: LinuxCNC's, mm.
pub(crate) const PECK_CLEARANCE: f64 = 0.254;
/// More repetitions, or pecks in all of them, than this are a slip.
const MOST: f64 = 10_000.0;

/// What a drilling cycle does in the hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drill {
    /// Down at feed, out at rapid (G81, G82, G86).
    Plain,
    /// Down by Q at a time, out of the hole in between (G83).
    Peck,
    /// Down by Q at a time, a little back in between (G73).
    Chip,
    /// Down and out to R at feed, on at rapid (G85, G89).
    Ream,
    /// Down and out all the way at feed (G74, G84 and G89 of LinuxCNC).
    Bore,
    /// Down and out at feed, the spindle the other way round (G84, G74).
    Tap,
}

/// Values that stay from hole to hole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    pub drill: Drill,
    /// The axis drilled along, where it is not the third of the plane.
    pub along: Option<usize>,
    /// The word that called it.
    word: i32,
    /// The words Z and R, program units turned to mm; NaN where not given yet.
    pub bottom: f64,
    pub plane: f64,
    pub peck: f64,
    /// Dwell at the bottom, s; NaN where none is given.
    dwell: f64,
    /// Height at which the series of holes began.
    pub initial: f64,
}

impl Hole {
    pub const fn new(drill: Drill, along: Option<usize>, word: i32, initial: f64) -> Self {
        Self { drill, along, word, bottom: f64::NAN, plane: f64::NAN, peck: f64::NAN, dwell: f64::NAN, initial }
    }
}

/// Heights of one hole, mm, and where it is.
struct Heights {
    third: usize,
    plane: f64,
    bottom: f64,
    clear: f64,
    word: i32,
}

impl Runner<'_> {
    /// A block under a drilling cycle.
    pub(crate) fn drill(&mut self, request: &Request) {
        let Some(mut hole) = self.state.hole else { return };
        let (first, second, third) = self.hole_axes(&hole);
        self.read_hole(request, &mut hole, third);
        self.state.hole = Some(hole);
        let repeats = request.get(b'L').or(request.get(b'K')).unwrap_or(1.0).round();
        let (plane, bottom) = self.heights(&hole);
        if let Some(what) = unfit(&hole, plane, bottom, repeats) {
            let hint = "a drilling cycle wants Z and R, with Z the lower, and with pecks Q";
            return self.refuse(finding::MISPLACED, self.block_start(), what, hint);
        }
        let mut target = self.state.position;
        let clear = if self.state.retracts_to_plane { plane } else { hole.initial.max(plane) };
        if self.program.dialect().flow != FlowStyle::Macro {
            // LinuxCNC does not go across below R: it goes up first, or within a series of holes slantwise.
            if hole.initial < plane {
                self.height(MoveKind::Rapid, target, third, plane, INHERITED);
                target[third] = plane;
            } else if target[third] <= plane {
                target[third] = clear;
            }
        }
        let heights = Heights { third, plane, bottom, clear, word: request.word(AXES[third]) };
        for _ in 0..repeats as usize {
            let mut words = [INHERITED; 3];
            for axis in [first, second] {
                let Some(value) = request.get(AXES[axis]) else { continue };
                let value = value * self.state.modal.axis_mm(axis);
                target[axis] = if self.state.modal.incremental { target[axis] + value } else { value };
                words[axis] = request.word(AXES[axis]);
            }
            if request.any(&POLAR) {
                self.polar_target(request, &mut target, &mut words);
            }
            self.emit(MoveKind::Rapid, target, words);
            self.one_hole(&hole, &heights, target);
            target[third] = self.state.position[third];
        }
    }

    /// First and second axis of the hole's place, and the one drilled along.
    fn hole_axes(&self, hole: &Hole) -> (usize, usize, usize) {
        match hole.along {
            Some(0) => (1, 2, 0),
            Some(_) => (0, 1, 2),
            None => self.state.modal.plane.axes(),
        }
    }

    /// What the block changes of the hole.
    fn read_hole(&mut self, request: &Request, hole: &mut Hole, third: usize) {
        let (mm, axis_mm) = (self.state.modal.mm(), self.state.modal.axis_mm(third));
        hole.plane = request.get(b'R').map_or(hole.plane, |r| r * mm);
        hole.dwell = self.dwell_of_p(request).unwrap_or(hole.dwell);
        hole.peck = request.get(b'Q').map_or(hole.peck, |q| q * mm);
        hole.bottom = request.get(AXES[third]).map_or(hole.bottom, |z| z * axis_mm);
        if self.program.dialect().rules.drills_from_start {
            hole.plane = if hole.plane.is_nan() { 0.0 } else { hole.plane };
            hole.drill = if hole.drill == Drill::Peck && hole.peck.is_nan() { Drill::Plain } else { hole.drill };
        }
        if let Some(depth) = self.dialect_increments().and_then(|letters| request.get(letters[third])) {
            let from = if self.state.modal.incremental { 0.0 } else { self.heights(hole).0 };
            hole.bottom = from + depth * axis_mm;
        }
        if matches!(hole.drill, Drill::Peck | Drill::Chip) && self.program.dialect().flow == FlowStyle::Macro {
            let what = format!("how far it goes back is the control's; taken as {PECK_CLEARANCE} mm");
            self.note_opaque(hole.word, &what);
        }
    }

    /// Heights of the plane R and of the hole's bottom, mm.
    fn heights(&self, hole: &Hole) -> (f64, f64) {
        let incremental = self.state.modal.incremental;
        let from_start = incremental || self.program.dialect().rules.drills_from_start;
        let plane = hole.plane + if from_start { hole.initial } else { 0.0 };
        (plane, hole.bottom + if incremental { plane } else { 0.0 })
    }

    fn one_hole(&mut self, hole: &Hole, heights: &Heights, at: [f64; 3]) {
        if self.state.position[heights.third] != heights.plane {
            self.height(MoveKind::Rapid, at, heights.third, heights.plane, INHERITED);
        }
        if matches!(hole.drill, Drill::Peck | Drill::Chip) {
            self.pecks(hole, heights, at);
        }
        let (down, out) = match hole.drill {
            Drill::Ream | Drill::Tap | Drill::Bore => (MoveKind::Line, MoveKind::Line),
            _ => (MoveKind::Line, MoveKind::Rapid),
        };
        self.height(down, at, heights.third, heights.bottom, heights.word);
        if !hole.dwell.is_nan() && self.dwells_at_bottom(hole) {
            self.path.dwells.push((self.path.len(), hole.dwell));
        }
        if matches!(hole.drill, Drill::Ream | Drill::Tap) && heights.clear != heights.plane {
            self.height(out, at, heights.third, heights.plane, INHERITED);
            return self.height(MoveKind::Rapid, at, heights.third, heights.clear, INHERITED);
        }
        self.height(out, at, heights.third, heights.clear, INHERITED);
    }

    /// Whether P of that cycle is a dwell: LinuxCNC's G82, G86 and G89; of others every one but G81.
    fn dwells_at_bottom(&self, hole: &Hole) -> bool {
        let word = usize::try_from(hole.word).ok().and_then(|word| self.program.words().get(word));
        let code = word.map_or(0.0, |word| word.value);
        match self.program.dialect().flow {
            FlowStyle::OWords => [82.0, 86.0, 89.0].contains(&code),
            _ => code != 81.0,
        }
    }

    /// All pecks but the last.
    fn pecks(&mut self, hole: &Hole, heights: &Heights, at: [f64; 3]) {
        let mut depth = heights.plane - hole.peck;
        while depth > heights.bottom {
            self.height(MoveKind::Line, at, heights.third, depth, INHERITED);
            if hole.drill == Drill::Peck {
                self.height(MoveKind::Rapid, at, heights.third, heights.plane, INHERITED);
            }
            self.height(MoveKind::Rapid, at, heights.third, depth + PECK_CLEARANCE, INHERITED);
            depth -= hole.peck;
        }
    }

    /// A move along the third axis alone.
    fn height(&mut self, kind: MoveKind, at: [f64; 3], third: usize, to: f64, word: i32) {
        let (mut end, mut words) = (at, [INHERITED; 3]);
        end[third] = to;
        words[third] = word;
        self.emit(kind, end, words);
    }
}

/// What keeps a hole from being drilled.
fn unfit(hole: &Hole, plane: f64, bottom: f64, repeats: f64) -> Option<String> {
    let pecks = matches!(hole.drill, Drill::Peck | Drill::Chip);
    let count = (plane - bottom) / hole.peck;
    if plane < bottom || plane.is_nan() || bottom.is_nan() {
        Some(format!("a drilling cycle from R at {plane:.4} mm to Z at {bottom:.4} mm"))
    } else if pecks && !(hole.peck > 0.0 && count * repeats.max(1.0) < MOST) {
        Some(format!("a drilling cycle of {:.4} mm by pecks of {:.4} mm", plane - bottom, hole.peck))
    } else if !(0.0..=MOST).contains(&repeats) {
        Some(format!("{repeats} repetitions of a drilling cycle"))
    } else {
        None
    }
}
