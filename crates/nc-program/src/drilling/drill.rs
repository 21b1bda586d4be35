//! Drilling cycles taken apart: to the hole, to the plane R, down, and out again.

use crate::dialect::FlowStyle;
use crate::drilling::hole::{Drilled, Hole};
use crate::finding::{self, Severity};
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
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
    /// Milled around the place, by passes of the control's own.
    Mill,
    /// Milled by coordinates of its own.
    Face,
    /// Milled along contours of labels.
    Contour,
}

/// Heights of one hole, mm.
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
        if self.scales_depth(third) {
            let message = "a drilling cycle whose depth is scaled: controls differ in what of it they scale".to_owned();
            return self.refuse(finding::MISPLACED, self.block_start(), message, "end the scaling before it, by G50");
        }
        self.read_hole(request, &mut hole, third);
        let of_k = request.get(b'K').filter(|_| !self.program.dialect().rules.pecks_by_k);
        let repeats = request.get(b'L').or(of_k).unwrap_or(1.0).round();
        if repeats > 0.0 {
            self.note_pecks(&mut hole);
        }
        self.state.hole = Some(hole);
        let (plane, bottom) = self.heights(&hole);
        if let Some(what) = unfit(&hole, plane, bottom, repeats) {
            let hint = "a drilling cycle wants Z and R, with Z the lower, and with pecks Q";
            return self.refuse(finding::MISPLACED, self.block_start(), what, hint);
        }
        let (begins, mut target) = (self.path.len(), self.state.position);
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
        let heights = Heights { third, plane, bottom, clear, word: self.depth_word(request, third) };
        for repeat in 0..repeats as usize {
            let (end, mut words) = self.target(request, false);
            (target[first], target[second], words[third]) = (end[first], end[second], INHERITED);
            let place = self.path.len();
            self.emit(MoveKind::Rapid, target, words);
            let bottom = self.one_hole(&hole, &heights, target);
            self.path.drilled.push(Drilled {
                first: if repeat == 0 { begins } else { place },
                place,
                bottom,
                end: self.path.len(),
                third,
                plane_word: request.word(b'R'),
                depth_word: heights.word,
                plane,
                initial: hole.initial,
                plane_from_initial: self.plane_from_initial(),
                ends_at_plane: self.state.retracts_to_plane,
                series: hole.series,
                repeat,
                said: None,
                milled: None,
            });
            target[third] = self.state.position[third];
        }
    }

    /// The word of the depth: of a position and an increment the last one counts.
    fn depth_word(&self, request: &Request, third: usize) -> i32 {
        let increment = self.dialect_increments().map_or(INHERITED, |letters| request.word(letters[third]));
        request.word(AXES[third]).max(increment)
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
        let from = if self.keeps_places() && self.plane_from_initial() { hole.initial } else { 0.0 };
        hole.plane = request.get(b'R').map_or(hole.plane, |r| from + r * mm);
        hole.dwell = self.dwell_of_p(request).unwrap_or(hole.dwell);
        self.read_pecks(request, hole);
        let rules = self.program.dialect().rules;
        if hole.plane.is_nan() && (rules.drills_from_start || rules.drills_without_plane) {
            hole.plane = hole.initial;
        }
        if rules.drills_from_start {
            hole.drill = if hole.drill == Drill::Peck && hole.peck.is_nan() { Drill::Plain } else { hole.drill };
        }
        let from = if self.keeps_places() && self.state.modal.incremental { hole.plane } else { 0.0 };
        hole.bottom = request.get(AXES[third]).map_or(hole.bottom, |z| from + z * axis_mm);
        let increment = self.dialect_increments().map_or(0, |letters| letters[third]);
        if let Some(depth) = request.get(increment).filter(|_| request.word(increment) > request.word(AXES[third])) {
            hole.bottom = hole.plane + depth * axis_mm;
        }
    }

    /// The depth of the pecks, mm: infinite, with a note, where the control makes them by I, J and K, or a parameter that is
    /// not given decides what Q counts.
    fn read_pecks(&mut self, request: &Request, hole: &mut Hole) {
        let rules = self.program.dialect().rules;
        let pecks = matches!(hole.drill, Drill::Peck | Drill::Chip);
        let hint = "the holes are where the program says";
        if pecks && rules.pecks_by_k && request.any(b"IJK") {
            let message = "pecks by I, J and K are the control's: they are not in the path".to_owned();
            self.report(Severity::Note, finding::OPAQUE, self.block_start(), message, hint);
            hole.peck = f64::INFINITY;
            return;
        }
        let Some(depth) = request.get(b'Q') else { return };
        let counts = rules.point.filter(|_| pecks && request.pointless.has(b'Q') && depth != 0.0);
        let unit = match counts.map(|parameter| (parameter, self.parameter(parameter))) {
            Some((parameter, None)) => {
                let (word, name) = (request.word(b'Q'), parameter.name);
                let message = format!(
                    "{} has no decimal point: what it counts is the machine's parameter {name}, the pecks are not in the path",
                    self.word_text(word)
                );
                self.report(Severity::Note, finding::OPAQUE, self.word_start(word), message, hint);
                f64::INFINITY
            }
            Some((_, Some(0.0))) => self.step_of(request),
            _ => 1.0,
        };
        hole.peck = depth * unit * self.state.modal.mm();
    }

    /// Notes, once a cycle, that how far its pecks go back is not known.
    fn note_pecks(&mut self, hole: &mut Hole) {
        let pecks = matches!(hole.drill, Drill::Peck | Drill::Chip) && hole.peck.is_finite();
        if pecks && !hole.noted && self.program.dialect().flow == FlowStyle::Macro {
            hole.noted = true;
            let what = format!("how far this cycle's pecks go back is the control's; taken as {PECK_CLEARANCE} mm");
            let hint = "the holes are where the program says";
            self.report(Severity::Note, finding::OPAQUE, self.block_start(), what, hint);
        }
    }

    /// Whether R and Z stay at the heights that they named when they were given; LinuxCNC reads them anew in every block.
    fn keeps_places(&self) -> bool {
        self.program.dialect().flow != FlowStyle::OWords
    }

    /// Heights of the plane R and of the hole's bottom, mm.
    fn heights(&self, hole: &Hole) -> (f64, f64) {
        if self.keeps_places() {
            return (hole.plane, hole.bottom);
        }
        let plane = hole.plane + if self.plane_from_initial() { hole.initial } else { 0.0 };
        (plane, hole.bottom + if self.state.modal.incremental { plane } else { 0.0 })
    }

    /// Whether an R counts from the height at which the series began.
    fn plane_from_initial(&self) -> bool {
        self.state.modal.incremental || self.program.dialect().rules.drills_from_start
    }

    /// From the place of the hole on; gives the index of the move to its bottom.
    fn one_hole(&mut self, hole: &Hole, heights: &Heights, at: [f64; 3]) -> usize {
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
        let to_bottom = self.path.len();
        self.height(down, at, heights.third, heights.bottom, heights.word);
        if !hole.dwell.is_nan() && hole.dwells {
            self.path.dwells.push((self.path.len(), hole.dwell));
        }
        if matches!(hole.drill, Drill::Ream | Drill::Tap) && heights.clear != heights.plane {
            self.height(out, at, heights.third, heights.plane, INHERITED);
            self.height(MoveKind::Rapid, at, heights.third, heights.clear, INHERITED);
        } else {
            self.height(out, at, heights.third, heights.clear, INHERITED);
        }
        to_bottom
    }

    /// Whether P of the cycle that this word calls is a dwell: LinuxCNC's G82, G86 and G89; of others every one but G81.
    pub(crate) fn dwells_at_bottom(&self, word: i32) -> bool {
        let code = self.program.word(word).map_or(0.0, |word| word.value);
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
    pub(crate) fn height(&mut self, kind: MoveKind, at: [f64; 3], third: usize, to: f64, word: i32) {
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
    if hole.plane.is_nan() || hole.bottom.is_nan() {
        Some("a drilling cycle without R or without Z".to_owned())
    } else if pecks && hole.peck.is_nan() {
        Some("a drilling cycle by pecks without Q".to_owned())
    } else if plane < bottom || plane.is_nan() || bottom.is_nan() {
        Some(format!("a drilling cycle from R at {plane:.4} mm to Z at {bottom:.4} mm"))
    } else if pecks && !(hole.peck > 0.0 && count * repeats.max(1.0) < MOST) {
        Some(format!("a drilling cycle of {:.4} mm by pecks of {:.4} mm", plane - bottom, hole.peck))
    } else if !(0.0..=MOST).contains(&repeats) {
        Some(format!("{repeats} repetitions of a drilling cycle"))
    } else {
        None
    }
}
