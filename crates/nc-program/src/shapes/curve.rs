//! Arcs and lines given in other ways: tangent to the move before, through a point, by an angle, about a pole.

use std::f64::consts::TAU;

use crate::compensation::offset::{meeting, Piece};
use crate::dialect::FlowStyle;
use crate::finding;
use crate::modes::modal::{Motion, Plane};
use crate::modes::request::Request;
use crate::motion::{CENTRES, POLAR};
use crate::path::{MoveKind, INHERITED};
use crate::run::{Runner, AXES};
use crate::shapes::arc::{self, Circle, Point};

/// Addresses of a pole's radius and angle, of an arc's angle, of a line's, and of the point that an arc goes through.
pub(crate) const POLAR_RADIUS: u8 = b'p';
pub(crate) const POLAR_ANGLE: u8 = b'q';
const ARC_ANGLE: u8 = b'a';
const THROUGH: [u8; 3] = *b"ijk";
/// End and centre of an arc by its angle contradict each other beyond this: where a Sinumerik refuses an arc, mm.
const CONTRADICTS_MM: f64 = 0.01;

/// Where a pole is counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoleFrom {
    /// The position.
    Position,
    /// The program's zero.
    Zero,
    /// The pole before.
    Pole,
    /// Each coordinate as the modes say; the position where none is given.
    Coordinates,
}

impl Runner<'_> {
    /// Sets the pole to the block's coordinates; in Klartext the two that are named are the plane of moves about it.
    pub(crate) fn set_pole(&mut self, request: &Request, from: PoleFrom) {
        let (target, words) = self.target(request, false);
        let pole = [0, 1, 2].map(|axis| {
            let given = request.get(AXES[axis]).unwrap_or(0.0) * self.state.modal.axis_mm(axis);
            match from {
                PoleFrom::Coordinates => target[axis],
                PoleFrom::Zero => given,
                PoleFrom::Position => self.state.position[axis] + given,
                PoleFrom::Pole => self.state.pole[axis] + given,
            }
        });
        self.state.pole = pole;
        self.state.polar_said = [f64::NAN; 2];
        if from == PoleFrom::Coordinates {
            self.state.pole_plane = match [0, 1, 2].map(|axis| words[axis] >= 0) {
                [true, true, false] => Plane::Xy,
                [false, true, true] => Plane::Yz,
                [true, false, true] => Plane::Zx,
                _ => self.state.pole_plane,
            };
        }
    }

    /// The plane in which a block moves: that of the pole about it in Klartext, whose cycles, radii and tools keep the
    /// plane across the tool's axis.
    pub(crate) fn plane_of(&self, request: &Request) -> Plane {
        let arc = matches!(self.state.modal.motion, Motion::Clockwise | Motion::Counterclockwise);
        let about = request.any(&POLAR) || arc && !request.any(&[self.program.dialect().rules.radius_letter]);
        if self.program.dialect().about_pole && about {
            self.state.pole_plane
        } else {
            self.state.modal.plane
        }
    }

    /// Reports polar coordinates that are not followed: radii under increments, but of LinuxCNC; of G16 also blocks that are
    /// not between its code and its end as they are written, other planes, and arcs by their centre.
    pub(crate) fn check_polar(&mut self, request: &Request, in_machine: bool) {
        let (modal, polar, flow) = (&self.state.modal, request.any(&POLAR), self.program.dialect().flow);
        let by_mode = flow == FlowStyle::Macro;
        if flow == FlowStyle::OWords && polar && modal.plane != Plane::Xy {
            let message = "polar coordinates in another plane than G17".to_owned();
            return self.refuse(finding::MISPLACED, self.block_start(), message, "write the end by its coordinates");
        }
        let counts_on = by_mode || flow == FlowStyle::Structured && request.reference(POLAR_RADIUS).is_none();
        let from_tool = modal.incremental && counts_on && request.any(&[POLAR_RADIUS]);
        let about = matches!(modal.motion, Motion::Clockwise | Motion::Counterclockwise) && request.any(b"IJ");
        let wrong = by_mode && polar && (!self.state.polar || modal.plane != Plane::Xy || about);
        let named = by_mode && request.any(b"XY") && self.state.polar && !in_machine;
        if wrong || named || from_tool {
            let words = [b'X', b'Y', POLAR_RADIUS, POLAR_ANGLE].map(|letter| request.word(letter));
            self.unfollowed(words.into_iter().max().unwrap_or(INHERITED));
        }
    }

    /// The end of a move given by radius and angle about the pole; what is not given stays as it is. A Sinumerik keeps what
    /// was said until the pole or the plane is another; an arc about the pole has its radius from there, too. Others measure
    /// it, except where the tool still stands where it was said: a radius below zero lies on the other side of the pole.
    /// LinuxCNC 2.9 measures it in each block.
    pub(crate) fn polar_target(&mut self, request: &Request, end: &mut [f64; 3], words: &mut [i32; 3]) {
        let (first, second, _) = self.state.modal.plane.axes();
        let from = [
            self.state.position[first] - self.state.pole[first],
            self.state.position[second] - self.state.pole[second],
        ];
        let flow = self.program.dialect().flow;
        let [radius, angle] = self.state.polar_said;
        let off = (from[0] - radius * angle.cos()).hypot(from[1] - radius * angle.sin());
        let increments = self.state.modal.incremental && flow != FlowStyle::Labels;
        let counts_on = |letter| match request.any(&[letter]) {
            true => request.reference(letter).unwrap_or(increments),
            false => true,
        };
        let arc = matches!(self.state.modal.motion, Motion::Clockwise | Motion::Counterclockwise);
        let keeps = flow == FlowStyle::Structured && !arc;
        if keeps && (radius.is_nan() && counts_on(POLAR_RADIUS) || angle.is_nan() && counts_on(POLAR_ANGLE)) {
            let message =
                "a polar move needs a radius or an angle from before, but the pole or the plane is another since";
            let word = request.word(POLAR_RADIUS).max(request.word(POLAR_ANGLE));
            let hint = "write AP and RP, not as increments, in the first move about a pole";
            self.refuse(finding::MISPLACED, self.word_start(word), message.into(), hint);
        }
        let [radius, angle] = match flow != FlowStyle::OWords && (off < 1e-6 || keeps && !off.is_nan()) {
            true => [radius, angle],
            false => [from[0].hypot(from[1]), from[1].atan2(from[0])],
        };
        let value = |letter: u8, now: f64, unit: f64| match request.get(letter).map(|value| value * unit) {
            Some(value) if request.reference(letter).unwrap_or(increments) => now + value,
            Some(value) => value,
            None => now,
        };
        let radius = value(POLAR_RADIUS, radius, self.state.modal.mm());
        let angle = value(POLAR_ANGLE, angle, 1f64.to_radians());
        self.state.polar_said = [radius, angle];
        end[first] = self.state.pole[first] + radius * angle.cos();
        end[second] = self.state.pole[second] + radius * angle.sin();
        let word = request.word(POLAR_RADIUS).max(request.word(POLAR_ANGLE));
        (words[first], words[second]) = (word, word);
    }

    /// The turn of an arc about the pole by an increment of its angle, which may be more than a full one. In Klartext it has
    /// to go the way of DR; of others one against the arc's way says no more than where that ends.
    pub(crate) fn polar_turn(&mut self, request: &Request, circle: Circle) -> Option<f64> {
        let turn = request.get(POLAR_ANGLE).filter(|_| request.reference(POLAR_ANGLE) == Some(true))?;
        if turn * circle.sweep > 0.0 {
            if self.program.dialect().about_pole {
                let word = request.word(POLAR_ANGLE);
                let message =
                    format!("{} goes against the arc's DR: the control may go another way", self.word_text(word));
                self.refuse(finding::ARC, self.word_start(word), message, "write IPA and DR with one sign");
            }
            return None;
        }
        (turn != 0.0 && turn.abs() < 1e8).then(|| turn.abs().to_radians().copysign(circle.sweep))
    }

    /// Direction in which the move before arrives, in the plane; `None` without one.
    fn arriving(&self) -> Option<Point> {
        let (first, second, _) = self.state.modal.plane.axes();
        let last = self.path.len().checked_sub(1)?;
        let (start, end) = (self.path.start.get(last)?, self.path.end.get(last)?);
        let along = match self.last_arc()? {
            Some(arc) => {
                let arm = [end[first] - arc.centre[first], end[second] - arc.centre[second]];
                let sign = arc.sweep.signum();
                [sign * arm[1], -sign * arm[0]]
            }
            None => [end[first] - start[first], end[second] - start[second]],
        };
        let length = along[0].hypot(along[1]);
        (length > 0.0).then(|| along.map(|part| part / length))
    }

    /// An arc that leaves as the move before arrives.
    pub(crate) fn tangent_arc(&mut self, end: [f64; 3], words: [i32; 3]) {
        if self.follows_way() {
            let message =
                "a tangent arc after a way to or from the contour (APPR, DEP), whose direction is not known".into();
            self.warn(finding::OPAQUE, self.block_start(), message, "write it as an arc with its centre or radius");
            return self.emit(MoveKind::Line, end, words);
        }
        let Some(along) = self.arriving() else {
            return self.refuse_arc("a tangent arc without a move before it".into(), end, words);
        };
        let (from, to) = self.in_plane(end);
        let chord = [to[0] - from[0], to[1] - from[1]];
        let left = along[0] * chord[1] - along[1] * chord[0];
        let squared = chord[0] * chord[0] + chord[1] * chord[1];
        if left.abs() <= 1e-9 * squared.sqrt() {
            return self.emit(MoveKind::Line, end, words);
        }
        let radius = squared / (2.0 * left);
        let centre = [from[0] - radius * along[1], from[1] + radius * along[0]];
        match arc::about(from, to, centre, left < 0.0) {
            Some(circle) => self.emit_arc(circle, circle.sweep, f64::NAN, end, words),
            None => self.refuse_arc("a tangent arc that ends where it starts".into(), end, words),
        }
    }

    /// An arc through a point on its way.
    pub(crate) fn arc_through(&mut self, request: &Request, end: [f64; 3], words: [i32; 3]) {
        let (first, second, third) = self.state.modal.plane.axes();
        let middle = [0, 1, 2].map(|axis| {
            let Some(value) = request.get(THROUGH[axis]) else { return self.state.position[axis] };
            let increment = request.reference(THROUGH[axis]).unwrap_or(self.state.modal.incremental);
            let value = value * self.state.modal.axis_mm(axis);
            if increment {
                self.state.position[axis] + value
            } else {
                value
            }
        });
        let (from, to) = self.in_plane(end);
        let flat = [middle[third], end[third]].iter().all(|at| (at - self.state.position[third]).abs() < 1e-9);
        let circle = circle_through(from, [middle[first], middle[second]], to).filter(|_| flat);
        match circle {
            Some(circle) => self.emit_arc(circle, circle.sweep, f64::NAN, end, words),
            None => {
                self.refuse_arc("an arc through a point that is not in the plane, or on the line".into(), end, words)
            }
        }
    }

    /// The arc of `AR`: with an end in the plane its circle, or with a centre its end there too; full turns of TURN besides.
    pub(crate) fn arc_by_angle(&mut self, request: &Request, end: [f64; 3], words: [i32; 3]) -> bool {
        if self.program.dialect().line_angle.contains(&ARC_ANGLE) {
            return false;
        }
        let Some(angle) = request.get(ARC_ANGLE).map(f64::to_radians) else { return false };
        let clockwise = self.state.modal.motion == Motion::Clockwise;
        let end = self.end_of_angle(request, end, angle);
        let (from, to) = self.in_plane(end);
        let half = (to[0] - from[0]).hypot(to[1] - from[1]) / 2.0;
        if !(angle > 0.0 && angle < TAU && half > 0.0) {
            let why = format!("an arc of {:.5} degrees to where it ends cannot exist", angle.to_degrees());
            self.refuse_arc(why, end, words);
            return true;
        }
        let radius = half / (angle / 2.0).sin();
        let signed = if angle > TAU / 2.0 { -radius } else { radius };
        match arc::with_radius(from, to, signed, clockwise, 1e-9) {
            Some(circle) => {
                let further = self.further_turns(request).copysign(circle.sweep);
                self.emit_arc(circle, circle.sweep + further, f64::NAN, end, words);
            }
            None => self.refuse_arc("an arc that cannot exist".into(), end, words),
        }
        true
    }

    /// The end of an arc by its angle: that of its words, or by its centre. Refuses the two where they contradict each other.
    fn end_of_angle(&mut self, request: &Request, end: [f64; 3], angle: f64) -> [f64; 3] {
        let (first, second, _) = self.state.modal.plane.axes();
        let turned = self.turned(request, end, angle);
        if !self.moves_in_plane(request) {
            return turned;
        }
        let off = (turned[first] - end[first]).hypot(turned[second] - end[second]);
        if request.any(&[CENTRES[first], CENTRES[second]]) && off > CONTRADICTS_MM {
            let message = format!("an arc by its angle whose centre would have it end {off:.5} mm beside its end");
            self.refuse(finding::ARC, self.block_start(), message, "write AR beside the end or beside the centre");
        }
        end
    }

    /// The end of an arc that has a centre and an angle; along the plane's third axis as given.
    fn turned(&self, request: &Request, end: [f64; 3], angle: f64) -> [f64; 3] {
        let clockwise = self.state.modal.motion == Motion::Clockwise;
        let (first, second, _) = self.state.modal.plane.axes();
        let centre = [first, second].map(|axis| self.centre_coordinate(request, axis, self.state.position[axis]));
        let arm = [self.state.position[first] - centre[0], self.state.position[second] - centre[1]];
        let (sin, cos) = if clockwise { (-angle).sin_cos() } else { angle.sin_cos() };
        let mut end = end;
        end[first] = centre[0] + cos * arm[0] - sin * arm[1];
        end[second] = centre[1] + sin * arm[0] + cos * arm[1];
        end
    }

    /// The end of a line given by its angle with the plane's first axis: where it reaches the one coordinate given, or
    /// meets the line that waits.
    pub(crate) fn angled_target(&mut self, request: &Request, end: &mut [f64; 3], words: &mut [i32; 3]) {
        let Some(letter) = self.angle_letter(request) else { return self.drop_line() };
        let angle = request.get(letter).map_or(f64::NAN, f64::to_radians);
        let (first, second, _) = self.state.modal.plane.axes();
        let (from, to) = self.in_plane(*end);
        let (across, other) = match (words[first] >= 0, words[second] >= 0) {
            (true, false) => ([0.0, 1.0], second),
            (false, true) => ([1.0, 0.0], first),
            _ if self.end_line(angle, *end) => return,
            _ => return self.warn_angle(request.word(letter), "an angle beside both coordinates of the end"),
        };
        self.drop_line();
        let along = Piece::Line(from, [angle.cos(), angle.sin()]);
        let Some(point) = meeting(along, Piece::Line(to, across)) else {
            return self.warn_angle(request.word(letter), "a line that never gets there");
        };
        (end[first], end[second], words[other]) = (point[0], point[1], request.word(letter));
    }

    fn warn_angle(&mut self, word: i32, what: &str) {
        let hint = "write both coordinates and no angle; the path goes on as if the angle were not there";
        let message = format!("{}: {what}", self.block_text());
        self.warn(finding::OPAQUE, self.word_start(word), message, hint);
    }

    fn block_text(&self) -> String {
        let block = self.program.blocks().get(self.block).map(|block| block.start as usize..block.end as usize);
        finding::excerpt(block.and_then(|span| self.program.source().get(span)).unwrap_or(&[]))
    }

    fn in_plane(&self, end: [f64; 3]) -> (Point, Point) {
        let (first, second, _) = self.state.modal.plane.axes();
        ([self.state.position[first], self.state.position[second]], [end[first], end[second]])
    }
}

/// The circle through three points, turning so that the second is on the way.
fn circle_through(from: Point, middle: Point, to: Point) -> Option<Circle> {
    let square = |point: Point| (point[0] - from[0]).powi(2) + (point[1] - from[1]).powi(2);
    let (centre, area) = arc::through(from, middle, to);
    let flat = 2.0 * area.abs() <= 1e-12 * square(middle).max(square(to));
    arc::about(from, to, centre, area < 0.0).filter(|_| !flat)
}
