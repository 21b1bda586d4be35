//! Motion: what moves a block asks for.

use crate::arc::{self, Circle};
use crate::curve::{POLAR_ANGLE, POLAR_RADIUS};
use crate::cycle::Turning;
use crate::dialect::G;
use crate::finding;
use crate::modal::{Motion, Plane};
use crate::path::{Arc, MoveKind, INHERITED};
use crate::request::Request;
use crate::run::{Runner, AXES};

/// Offsets of the arc centre, in order of axis index.
const CENTRES: [u8; 3] = *b"IJK";
const POLAR: [u8; 2] = [POLAR_RADIUS, POLAR_ANGLE];

impl Runner<'_> {
    /// Moves to the block's coordinates by the motion in force.
    pub(crate) fn motion(&mut self, request: &Request, in_machine: bool) {
        if !(self.names_axis(request) || is_arc(self.state.modal.motion) && request.any(&CENTRES)) {
            return self.warn_no_target(request);
        }
        if self.state.modal.motion == Motion::Drill {
            return self.drill(request);
        }
        let (mut end, mut words) = self.target(request, in_machine);
        self.angled_target(request, &mut end, &mut words);
        let kind = match self.state.modal.motion {
            Motion::Rapid => MoveKind::Rapid,
            Motion::Line if request.any(b"m") => MoveKind::Probe,
            Motion::Line => MoveKind::Line,
            Motion::Probe => MoveKind::Probe,
            Motion::Thread => MoveKind::Thread,
            Motion::Clockwise | Motion::Counterclockwise => return self.arc(request, end, words),
            Motion::Tangent => return self.tangent_arc(end, words),
            Motion::Through => return self.arc_through(request, end, words),
            Motion::Opaque => {
                let word = AXES.iter().map(|letter| request.word(*letter)).find(|word| *word >= 0).unwrap_or(INHERITED);
                return self.note_opaque(word, "the moves of the cycle in force are not in the path");
            }
            Motion::Drill => return,
            Motion::None => return self.warn_no_motion(request),
        };
        self.emit(kind, end, words);
        if request.any(b"R") {
            let word = request.word(b'R');
            let message = format!("{} on a straight move has no meaning", self.word_text(word));
            let hint = "a block may have lost its G02 or G03";
            self.warn(finding::MISPLACED, self.word_start(word), message, hint);
        }
    }

    /// End of the move that the block asks for, and the words that set it.
    pub(crate) fn target(&self, request: &Request, in_machine: bool) -> ([f64; 3], [i32; 3]) {
        let (mut end, mut words) = (self.state.position, [INHERITED; 3]);
        for axis in 0..3 {
            let Some(value) = request.get(AXES[axis]) else {
                let letter = self.dialect_increments().map_or(0, |letters| letters[axis]);
                if let Some(value) = request.get(letter) {
                    end[axis] += value * self.state.modal.axis_mm(axis);
                    words[axis] = request.word(letter);
                }
                continue;
            };
            let increment = request.reference(AXES[axis]).unwrap_or(self.state.modal.incremental);
            let radius = increment && self.state.modal.radius_increments;
            let value = value * if radius { self.state.modal.mm() } else { self.state.modal.axis_mm(axis) };
            end[axis] = if in_machine {
                value - self.state.frame.total()[axis]
            } else if increment {
                self.state.position[axis] + value
            } else {
                value
            };
            words[axis] = request.word(AXES[axis]);
        }
        if request.any(&POLAR) {
            self.polar_target(request, &mut end, &mut words);
        }
        (end, words)
    }

    /// Letters of increments, where the dialect has them.
    pub(crate) fn dialect_increments(&self) -> Option<[u8; 3]> {
        self.program.dialect().increments
    }

    /// Whether the block names an axis, by position or by increment.
    pub(crate) fn names_axis(&self, request: &Request) -> bool {
        request.any(&AXES)
            || request.any(&POLAR)
            || self.dialect_increments().is_some_and(|letters| request.any(&letters))
    }

    fn warn_no_target(&mut self, request: &Request) {
        let arc = |code: G| matches!(code, G::Motion(motion) if is_arc(motion));
        let Some((_, word)) = request.codes().iter().find(|(code, _)| arc(*code)) else { return };
        let word = *word as i32;
        let message = format!("{} without coordinates: nothing moves", self.word_text(word));
        let hint = "its coordinates may have slipped into the comment of the line before";
        self.warn(finding::MISPLACED, self.word_start(word), message, hint);
    }

    fn warn_no_motion(&mut self, request: &Request) {
        let word = AXES.iter().map(|letter| request.word(*letter)).find(|word| *word >= 0).unwrap_or(INHERITED);
        let message = format!("\"{}\" without a motion code in force: nothing moves", self.word_text(word));
        self.warn(finding::MISPLACED, self.word_start(word), message, "write G00 or G01 before it");
    }

    pub(crate) fn emit(&mut self, kind: MoveKind, end: [f64; 3], words: [i32; 3]) {
        if !self.state.unit_is_known {
            self.warn_unit(words);
        }
        if !self.state.diameter_is_known && self.state.modal.plane == Plane::Zx && words[0] >= 0 {
            self.warn_diameter(words[0]);
        }
        let state = self.path.state_index(&self.state.modal);
        self.path.kind.push(kind);
        self.path.start.push(self.state.position);
        self.path.end.push(end);
        self.path.words.push(words);
        self.path.block.push(self.block as i32);
        self.path.state.push(state);
        self.state.position = end;
    }

    fn warn_unit(&mut self, words: [i32; 3]) {
        self.state.unit_is_known = true;
        let unit = if self.state.modal.inch { "inch" } else { "millimetre" };
        let message = format!(
            "the program does not say its unit before its first move; read as {unit} (1 = {} mm)",
            self.state.modal.mm()
        );
        let at = self.word_start(words.into_iter().find(|word| *word >= 0).unwrap_or(INHERITED));
        self.warn(finding::UNIT, at, message, "write G20 or G21 (G70 or G71) first, or name the unit");
    }

    fn warn_diameter(&mut self, word: i32) {
        self.state.diameter_is_known = true;
        let message = format!(
            "the program does not say whether X is a diameter, which hangs on machine data; {} is read as a radius",
            self.word_text(word)
        );
        self.warn(finding::DIAMETER, self.word_start(word), message, "write DIAMON or DIAMOF at the start");
    }

    fn arc(&mut self, request: &Request, end: [f64; 3], words: [i32; 3]) {
        if self.arc_by_angle(request, end, words) {
            return;
        }
        let (circle, radius) = match self.circle(request, end) {
            Ok(found) => found,
            Err(why) => return self.refuse_arc(why, end, words),
        };
        let further = self.further_turns(request).copysign(circle.sweep);
        let sweep = self.polar_turn(request, circle).unwrap_or(circle.sweep + further);
        self.emit_arc(circle, sweep, radius, end, words);
    }

    /// An arc that cannot be: straight to its end.
    pub(crate) fn refuse_arc(&mut self, why: String, end: [f64; 3], words: [i32; 3]) {
        let hint = "check the end point and R, or I, J, K; the path goes straight to the end";
        self.refuse(finding::ARC, self.block_start(), why, hint);
        self.emit(MoveKind::Line, end, words);
    }

    pub(crate) fn emit_arc(&mut self, circle: Circle, sweep: f64, radius: f64, end: [f64; 3], words: [i32; 3]) {
        let (first, second, _) = self.state.modal.plane.axes();
        let mut centre = self.state.position;
        centre[first] = circle.centre[0];
        centre[second] = circle.centre[1];
        self.path.arcs.push(Arc { of_move: self.path.len(), centre, sweep, radius });
        self.emit(MoveKind::Arc, end, words);
    }

    /// P: the number of turns begun, where the dialect has it. TURN: the number of full turns besides.
    fn further_turns(&self, request: &Request) -> f64 {
        let turns = request.get(b'P').map_or(1.0, f64::round);
        let further = request.get(b't').map_or(0.0, f64::round);
        if self.program.dialect().turns && (1.0..=1e6).contains(&turns) {
            std::f64::consts::TAU * (turns - 1.0)
        } else if (1.0..=1e6).contains(&further) {
            std::f64::consts::TAU * further
        } else {
            0.0
        }
    }

    /// The circle of an arc block, and its R in mm (NaN without one). I, J, K are radius values.
    fn circle(&self, request: &Request, end: [f64; 3]) -> Result<(Circle, f64), String> {
        let (first, second, _) = self.state.modal.plane.axes();
        let clockwise = self.state.modal.motion == Motion::Clockwise;
        let (from, to) = ([self.state.position[first], self.state.position[second]], [end[first], end[second]]);
        let mm = self.state.modal.mm();
        if let Some(radius) = request.get(b'R').map(|radius| radius * mm) {
            let circle = arc::with_radius(from, to, radius, clockwise, self.resolution_mm() * 10.0);
            let chord = (to[0] - from[0]).hypot(to[1] - from[1]);
            let why = || format!("an arc of radius {radius:.5} mm over a chord of {chord:.5} mm cannot exist");
            return circle.map(|circle| (circle, radius.abs())).ok_or_else(why);
        }
        let given = [request.get(CENTRES[first]), request.get(CENTRES[second])];
        if given == [None, None] && (request.any(&POLAR) || self.program.dialect().about_pole) {
            let pole = [self.state.pole[first], self.state.pole[second]];
            let why = || format!("an arc whose pole ({:.5}, {:.5}) mm is its start or end", pole[0], pole[1]);
            return arc::about(from, to, pole, clockwise).map(|circle| (circle, f64::NAN)).ok_or_else(why);
        }
        if given == [None, None] {
            return Err(format!("G0{} without R or the centre's coordinates", if clockwise { 2 } else { 3 }));
        }
        let centre = [0, 1].map(|at| self.centre_coordinate(request, [first, second][at], from[at]));
        let why = || format!("an arc whose centre ({:.5}, {:.5}) mm is its start or end", centre[0], centre[1]);
        arc::about(from, to, centre, clockwise).map(|circle| (circle, f64::NAN)).ok_or_else(why)
    }

    /// A coordinate of the centre; `I=AC()` is a diameter where X is.
    pub(crate) fn centre_coordinate(&self, request: &Request, axis: usize, from: f64) -> f64 {
        let letter = CENTRES[axis];
        let value = request.get(letter).unwrap_or(0.0);
        match request.reference(letter) {
            Some(false) => value * self.state.modal.axis_mm(axis),
            None if self.state.modal.centre_absolute => value * self.state.modal.mm(),
            _ => from + value * self.state.modal.mm(),
        }
    }

    fn resolution_mm(&self) -> f64 {
        let (inch, millimetre) = self.program.dialect().resolution;
        if self.state.modal.inch {
            inch * 25.4
        } else {
            millimetre
        }
    }

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
    }

    /// The same of the axes named; without one nothing moves.
    pub(crate) fn home_named(&mut self, request: &Request, number: usize) {
        if self.names_axis(request) {
            return self.home(request, number);
        }
        let message = "a return to the reference point without an axis: nothing moves".into();
        self.warn(finding::MISPLACED, self.block_start(), message, "name the axes: G28 U0 W0, or G91 G28 Z0");
    }

    /// A longitudinal turning cycle, taken apart.
    pub(crate) fn turning_cycle(&mut self, request: &Request) {
        let (end, _) = self.target(request, false);
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
        for (at_feed, [x, z]) in steps {
            let kind = if at_feed { MoveKind::Line } else { MoveKind::Rapid };
            self.emit(kind, [x, self.state.position[1], z], [INHERITED; 3]);
        }
    }
}

fn is_arc(motion: Motion) -> bool {
    matches!(motion, Motion::Clockwise | Motion::Counterclockwise)
}
