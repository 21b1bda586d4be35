//! Motion: what moves a block asks for.

use std::f64::consts::TAU;

use crate::compensation::offset::minus;
use crate::controls::MachineIncrements;
use crate::dialect::{FlowStyle, G};
use crate::finding::{self, Unseen};
use crate::modes::modal::{Compensation, FeedMode, Motion};
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::run::{Runner, AXES};
use crate::shapes::arc::{self, Circle, Point};
use crate::shapes::curve::{POLAR_ANGLE, POLAR_RADIUS};

/// Offsets of the arc centre, in order of axis index.
pub(crate) const CENTRES: [u8; 3] = *b"IJK";

/// LinuxCNC makes a full turn of an arc that turns by less.
const LINUXCNC_FULL_TURN_RAD: f64 = 1e-6;

/// What half a chord may be longer than R for LinuxCNC: 0.00005 in.
const LINUXCNC_LONGER_MM: f64 = 0.00127;

/// Numbers of turns are whole to so much.
const WHOLE: f64 = 1e-4;

/// More turns of an arc than this are not followed.
const MOST_TURNS: f64 = 1e6;

/// No control of the others tells points apart that are nearer: their finest step is 0.1 µm.
const SAME_POINT_MM: f64 = 1e-6;

pub(crate) const POLAR: [u8; 2] = [POLAR_RADIUS, POLAR_ANGLE];

impl Runner<'_> {
    /// Moves to the block's coordinates by the motion in force.
    pub(crate) fn motion(&mut self, request: &Request, in_machine: bool) {
        if self.wait_with_line(request) {
            return;
        }
        if !(self.names_axis(request)
            || is_arc(self.state.modal.motion) && request.any(&CENTRES)
            || begins_spline(request))
        {
            return self.warn_no_target(request);
        }
        self.warn_named_twice(request);
        match self.state.modal.motion {
            Motion::Drill if !in_machine => return self.drill(request),
            Motion::Pass if !in_machine => return self.pass(request),
            Motion::Spline(spline) => return self.spline(request, spline),
            _ => {}
        }
        if in_machine && !self.obeys_machine(request) {
            return;
        }
        if self.state.modal.motion == Motion::None {
            self.first_motion(request);
        }
        let (mut end, mut words) = self.target(request, in_machine);
        self.angled_target(request, &mut end, &mut words);
        self.check_inverse_time(request);
        let kind = match self.state.modal.motion {
            _ if in_machine && self.program.dialect().rules.machine_moves_rapid => MoveKind::Rapid,
            Motion::Drill | Motion::Pass if in_machine => MoveKind::Rapid,
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
                return self.note_unseen(word, Unseen::Moves, "the moves of the cycle in force are not in the path");
            }
            Motion::Drill | Motion::Pass | Motion::Spline(_) => return,
            Motion::None => return self.warn_no_motion(request),
        };
        if kind == MoveKind::Thread {
            self.lead_mm = self.lead(request);
        }
        self.state.switched &= !self.moves_in_plane(request);
        self.emit(kind, end, words);
        let of_arcs: &[u8] = if kind == MoveKind::Thread { b"R" } else { b"RIJK" };
        let own_way = request.codes().iter().any(|(code, _)| matches!(code, G::Approach | G::Leave(_)));
        if let Some(letter) = of_arcs.iter().find(|letter| !own_way && request.get(**letter).is_some()) {
            let word = request.word(*letter);
            if self.program.dialect().flow == FlowStyle::None
                && request.codes().iter().any(|(code, _)| matches!(code, G::Compensation(_)))
            {
                return self.note_opaque(word, "how the tool comes to the contour is not in the path");
            }
            let message = format!("{} on a straight move has no meaning", self.word_text(word));
            let hint =
                "a block may have lost its G02 or G03; a corner as older lathes have it is written with ,R or ,C";
            self.warn(finding::MISPLACED, self.word_start(word), message, hint);
        }
    }

    /// Whether a move to a place of the machine is obeyed: not under increments, where the control stops or ignores it.
    fn obeys_machine(&mut self, request: &Request) -> bool {
        let refuses = self.program.dialect().rules.machine_increments == MachineIncrements::Refused;
        if !(refuses && self.state.modal.incremental) {
            return true;
        }
        let coded = request.codes().iter().find(|(code, _)| *code == G::MachineCoordinates);
        let word = coded.map_or(INHERITED, |(_, word)| *word as i32);
        let message = format!("\"{}\" under increments: the control stops, or does not obey it", self.word_text(word));
        self.refuse(finding::MISPLACED, self.word_start(word), message, "write G90 before it");
        false
    }

    /// A cut by an inverse time without one of its own.
    fn check_inverse_time(&mut self, request: &Request) {
        let cuts = matches!(self.state.modal.motion, Motion::Line | Motion::Clockwise | Motion::Counterclockwise);
        let each =
            self.program.dialect().rules.inverse_time_each_cut && self.state.modal.feed_mode == FeedMode::InverseTime;
        if cuts && each && !request.any(b"F") {
            let message = "a cut under G93 without its F: the control stops".into();
            self.refuse(finding::FEED, self.block_start(), message, "write F in every cut: 1 over its minutes");
        }
    }

    /// Compensation that would begin or end on an arc, where the control takes a straight move only.
    fn check_entry(&mut self) {
        let rules = self.program.dialect().rules;
        let off = self.state.modal.compensation == Compensation::Off;
        if std::mem::take(&mut self.state.switched) && (if off { rules.straight_exit } else { rules.straight_entry }) {
            let does = if off { "ends" } else { "begins" };
            let message = format!("compensation {does} on an arc: the control stops");
            self.refuse(
                finding::ENTRY,
                self.block_start(),
                message,
                "begin and end it on a straight move in the plane",
            );
        }
    }

    /// Whether the block names an axis of the plane.
    pub(crate) fn moves_in_plane(&self, request: &Request) -> bool {
        let (first, second, _) = self.state.modal.plane.axes();
        let increments = self.dialect_increments().unwrap_or_default();
        request.any(&[AXES[first], AXES[second], increments[first], increments[second]]) || request.any(&POLAR)
    }

    /// A position and an increment of one axis.
    fn warn_named_twice(&mut self, request: &Request) {
        for (position, increment) in AXES.into_iter().zip(self.dialect_increments().unwrap_or_default()) {
            if request.get(position).is_some() && request.get(increment).is_some() {
                let (one, other) = (request.word(position), request.word(increment));
                let (first, last) = (one.min(other), one.max(other));
                let (first_text, last_text) = (self.word_text(first), self.word_text(last));
                let message = format!("\"{last_text}\" after \"{first_text}\" in one block: the last counts");
                self.warn(finding::DUPLICATE, self.word_start(last), message, "write one of the two");
            }
        }
    }

    /// Lead of a thread, mm: beside the axis, but where it is written as the feed.
    fn lead(&mut self, request: &Request) -> f64 {
        let beside = CENTRES.iter().find_map(|letter| request.get(*letter));
        if beside.is_none() && self.program.dialect().flow != FlowStyle::Macro {
            let hint = "write K, or I of a face thread: F is no lead there";
            self.refuse(finding::MISPLACED, self.block_start(), "a thread without its lead".into(), hint);
        }
        beside.map_or(f64::NAN, |lead| lead * self.state.modal.mm())
    }

    /// End of the move that the block asks for, and the words that set it.
    pub(crate) fn target(&mut self, request: &Request, in_machine: bool) -> ([f64; 3], [i32; 3]) {
        let (mut end, mut words) = (self.state.position, [INHERITED; 3]);
        let by_increments = self.program.dialect().rules.machine_increments == MachineIncrements::Increments;
        let in_machine = in_machine && !(by_increments && self.state.modal.incremental);
        let mut places = [None; 3];
        for axis in 0..3 {
            let letter = self.dialect_increments().map_or(0, |letters| letters[axis]);
            // Of a position and an increment the last one counts.
            let position = request.get(AXES[axis]).filter(|_| request.word(AXES[axis]) > request.word(letter));
            let Some(value) = position else {
                if let Some(value) = request.get(letter) {
                    end[axis] += value * self.state.modal.axis_mm(axis);
                    words[axis] = request.word(letter);
                }
                continue;
            };
            let increment = request.reference(AXES[axis]).unwrap_or(self.state.modal.incremental);
            let modal = &self.state.modal;
            let value = value * if increment { modal.increment_mm(axis) } else { modal.axis_mm(axis) };
            places[axis] = Some(value).filter(|_| in_machine);
            end[axis] = if increment { self.state.position[axis] + value + self.skipped_shift(axis) } else { value };
            words[axis] = request.word(AXES[axis]);
        }
        if in_machine {
            end = self.on_machine(places, self.machine_origin());
        }
        self.check_polar(request, in_machine);
        if request.any(&POLAR) {
            self.polar_target(request, &mut end, &mut words);
        }
        self.settle_shift(words);
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

    fn arc(&mut self, request: &Request, end: [f64; 3], words: [i32; 3]) {
        self.check_entry();
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

    /// P: the number of turns begun, where the dialect has it. TURN: the number of full turns besides. Refuses what is no
    /// number of turns.
    pub(crate) fn further_turns(&mut self, request: &Request) -> f64 {
        let (letter, least) = if self.program.dialect().turns { (b'P', 1.0) } else { (b't', 0.0) };
        let Some(turns) = request.get(letter).filter(|turns| !turns.is_nan()) else { return 0.0 };
        let (whole, word) = (turns.round(), request.word(letter));
        let at = self.word_start(word);
        if (turns - whole).abs() > WHOLE || whole < least {
            let message = format!("{}: {turns} is no number of turns", self.word_text(word));
            self.refuse(finding::ARC, at, message, "write a whole number of turns, from 1 on");
        } else if whole > MOST_TURNS {
            let message = format!("{}: {turns} turns are more than {MOST_TURNS}", self.word_text(word));
            self.refuse(finding::LIMIT, at, message, "write the turns in a loop");
        } else {
            return TAU * (whole - least);
        }
        0.0
    }

    /// The circle of an arc block, and its R in mm (NaN without one). I, J, K are radius values.
    fn circle(&self, request: &Request, end: [f64; 3]) -> Result<(Circle, f64), String> {
        let (first, second, _) = self.state.modal.plane.axes();
        let clockwise = self.state.modal.motion == Motion::Clockwise;
        let (from, to) = ([self.state.position[first], self.state.position[second]], [end[first], end[second]]);
        let mm = self.state.modal.mm();
        if let Some(radius) = request.get(self.program.dialect().rules.radius_letter).map(|radius| radius * mm) {
            let circle = arc::with_radius(from, to, radius, clockwise, self.longer_mm());
            let chord = (to[0] - from[0]).hypot(to[1] - from[1]);
            let why = || format!("an arc of radius {radius:.5} mm over a chord of {chord:.5} mm cannot exist");
            return circle.map(|circle| (circle, radius.abs())).ok_or_else(|| why_none([radius, chord], why()));
        }
        let given = [request.get(CENTRES[first]), request.get(CENTRES[second])];
        let about_pole = request.any(&POLAR) && self.program.dialect().flow != FlowStyle::Macro; // there by R
        if given == [None, None] && (about_pole || self.program.dialect().about_pole) {
            let pole = [self.state.pole[first], self.state.pole[second]];
            let why = || format!("an arc whose pole ({:.5}, {:.5}) mm is its start or end", pole[0], pole[1]);
            return self.about(from, to, pole, clockwise).ok_or_else(|| why_none(minus(pole, to), why()));
        }
        if given == [None, None] {
            return Err(format!("G0{} without R or the centre's coordinates", if clockwise { 2 } else { 3 }));
        }
        if self.program.dialect().rules.centre_whole && self.state.modal.centre_absolute && given.contains(&None) {
            return Err("an absolute centre with one of its two words: the control stops".to_owned());
        }
        let centre = [0, 1].map(|at| self.centre_coordinate(request, [first, second][at], from[at]));
        let why = || format!("an arc whose centre ({:.5}, {:.5}) mm is its start or end", centre[0], centre[1]);
        self.about(from, to, centre, clockwise).ok_or_else(|| why_none(minus(centre, to), why()))
    }

    /// The circle about a given centre, without an R: a full turn where the end lies on the start but for what computing
    /// them left.
    fn about(&self, from: Point, to: Point, centre: Point, clockwise: bool) -> Option<(Circle, f64)> {
        let mut circle = arc::about(from, to, centre, clockwise)?;
        let least = match self.program.dialect().flow {
            FlowStyle::OWords => LINUXCNC_FULL_TURN_RAD,
            _ => SAME_POINT_MM / (from[0] - centre[0]).hypot(from[1] - centre[1]),
        };
        if circle.sweep.abs() < least {
            circle.sweep = TAU.copysign(circle.sweep);
        }
        Some((circle, f64::NAN))
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

    /// What half a chord may be longer than R: ten steps of the control, of LinuxCNC a bound of its own.
    fn longer_mm(&self) -> f64 {
        let dialect = self.program.dialect();
        let (inch, millimetre) = dialect.resolution;
        match dialect.flow {
            FlowStyle::OWords => LINUXCNC_LONGER_MM,
            _ if self.state.modal.inch => 10.0 * inch * 25.4,
            _ => 10.0 * millimetre,
        }
    }
}

/// Why there is no circle: what was computed from a parameter without a value makes none either.
fn why_none(computed: [f64; 2], why: String) -> String {
    if computed.iter().all(|value| value.is_finite()) {
        why
    } else {
        "an arc whose start, end, radius or centre is not known".to_owned()
    }
}

/// Whether a spline begins here, be it without a point.
fn begins_spline(request: &Request) -> bool {
    request.codes().iter().any(|(code, _)| matches!(code, G::Motion(Motion::Spline(_))))
}

fn is_arc(motion: Motion) -> bool {
    matches!(motion, Motion::Clockwise | Motion::Counterclockwise)
}
