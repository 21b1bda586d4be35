//! Compensation from one move to the next: around corners and into them.

use std::f64::consts::PI;

use crate::compensation::compensate::{Active, Compensator, NO_CORNER};
use crate::compensation::offset::{cross, dot, meeting, minus, unit, Piece, Planar};
use crate::finding;
use crate::path::MoveKind;
use crate::shapes::arc::{self, Point};

impl Compensator<'_> {
    /// A move under compensation after the first one.
    pub fn go_on(&mut self, planar: &Planar<'_>) {
        let Some(active) = &self.active else { return };
        let normal = minus(self.standing(planar), planar.from());
        let before = unit(if active.left() { [normal[1], -normal[0]] } else { [-normal[1], normal[0]] });
        let after = planar.direction(planar.from());
        let turn = cross(before, after).atan2(dot(before, after));
        let away = if active.left() { -turn } else { turn };
        let end = active.beside(planar.to(), planar.direction(planar.to()));
        let around = active.beside(planar.from(), after);
        let last = self.last_piece(active, planar, before);
        let next = match planar.circle() {
            Some((centre, clockwise)) => circle(active, centre, end, clockwise),
            None => Piece::Line(end, after),
        };
        let turns_back = away.abs() > PI - NO_CORNER;
        let inside = if turns_back { goes_over(last, next) } else { away < -NO_CORNER };
        self.check_arc(planar, next);
        if inside {
            self.corner_inside(planar, last, next);
        } else {
            let outside = turns_back || away > NO_CORNER;
            self.check_way(planar.index, outside);
            self.settle();
            if outside {
                self.corner_outside(planar, around);
            }
        }
        self.emit(planar, end, planar.circle());
    }

    /// The path of the centre before a corner.
    fn last_piece(&self, active: &Active, planar: &Planar<'_>, direction: Point) -> Piece {
        let standing = self.standing(planar);
        match self.out.arcs.iter().rev().find(|arc| arc.of_move <= active.open) {
            Some(arc) if arc.of_move == active.open => {
                circle(active, planar.point(arc.centre), standing, arc.sweep > 0.0)
            }
            _ => Piece::Line(standing, direction),
        }
    }

    fn check_arc(&mut self, planar: &Planar<'_>, next: Piece) {
        let (Some(active), Some((centre, _)), Piece::Circle { inside: true, .. }) =
            (&self.active, planar.circle(), next)
        else {
            return;
        };
        let arm = minus(planar.to(), centre);
        let (radius, tool) = (arm[0].hypot(arm[1]), active.cutter.radius);
        if radius <= tool {
            let message = format!("an arc of radius {radius:.4} mm is not larger than the tool's {tool:.4} mm");
            self.refuse(planar.index, finding::GOUGE, message, "use a smaller tool");
        }
    }

    /// Takes the end of the moves before to where the offset paths cross.
    fn corner_inside(&mut self, planar: &Planar<'_>, last: Piece, next: Piece) {
        match meeting(last, next) {
            Some(crossing) => {
                self.take_back(planar, crossing);
                self.check_way(planar.index, true);
            }
            None => self.refuse_corner(planar.index),
        }
        self.settle();
    }

    /// Moves the ends of the moves that are still open.
    fn take_back(&mut self, planar: &Planar<'_>, to: Point) {
        let (first, second) = planar.axes;
        let open = self.active.as_ref().map_or(0, |active| active.open);
        for index in open..self.out.len() {
            let (Some(start), Some(end)) = (self.out.start.get_mut(index), self.out.end.get_mut(index)) else { break };
            let from = planar.point(*start);
            (end[first], end[second]) = (to[0], to[1]);
            if index > open {
                (start[first], start[second]) = (to[0], to[1]);
            } else if let Some(arc) = self.out.arcs.iter_mut().rev().find(|arc| arc.of_move == index) {
                let found = arc::about(from, to, planar.point(arc.centre), arc.sweep > 0.0);
                arc.sweep = found.map_or(0.0, |found| found.sweep);
            }
        }
        (self.lead[first], self.lead[second]) = (to[0] - planar.start[first], to[1] - planar.start[second]);
    }

    /// Around a corner by an arc about it; a rapid move goes straight.
    fn corner_outside(&mut self, planar: &Planar<'_>, end: Point) {
        let rapid = self.path.kind.get(planar.index) == Some(&MoveKind::Rapid);
        let clockwise = self.active.as_ref().is_some_and(Active::left);
        self.append(planar, planar.start, end, (!rapid).then_some((planar.from(), clockwise)));
        self.settle();
    }
}

fn circle(active: &Active, centre: Point, through: Point, clockwise: bool) -> Piece {
    let arm = minus(through, centre);
    Piece::Circle { centre, radius: arm[0].hypot(arm[1]), inside: active.left() != clockwise, clockwise }
}

/// Where the contour turns back on itself next to an arc with the tool outside it, the path is not led around the point.
fn goes_over(last: Piece, next: Piece) -> bool {
    match (last, next) {
        (_, Piece::Circle { inside, .. }) | (Piece::Circle { inside, .. }, Piece::Line(..)) => !inside,
        (Piece::Line(..), Piece::Line(..)) => false,
    }
}
