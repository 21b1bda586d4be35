//! Moves in the plane in which compensation acts, and where the paths of a tool's centre along two neighbouring pieces
//! meet.

use crate::path::Arc;
use crate::shapes::arc::Point;

/// The path of the centre along one piece.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Piece {
    /// Along a straight line: a point of it and its unit direction.
    Line(Point, Point),
    /// Along a circle: centre, radius, and whether the tool is inside the contour's circle.
    Circle { centre: Point, radius: f64, inside: bool, clockwise: bool },
}

/// Where a path that turns towards the tool's side goes over from one piece to the next; `None` where they do not meet.
///
/// A line that turns into a circle with the tool inside leaves through it, one outside enters it, and the other way
/// round for a line after a circle: that tells the two crossings apart.
pub(crate) fn meeting(before: Piece, after: Piece) -> Option<Point> {
    match (before, after) {
        (Piece::Line(point, direction), Piece::Line(other, along)) => lines(point, direction, other, along),
        (Piece::Line(point, direction), Piece::Circle { centre, radius, inside, .. }) => {
            through(point, direction, centre, radius, inside)
        }
        (Piece::Circle { centre, radius, inside, .. }, Piece::Line(point, direction)) => {
            through(point, direction, centre, radius, !inside)
        }
        (Piece::Circle { centre, radius, inside, .. }, Piece::Circle { centre: other, radius: far, clockwise, .. }) => {
            circles(centre, radius, other, far, inside != clockwise)
        }
    }
}

fn lines(point: Point, direction: Point, other: Point, along: Point) -> Option<Point> {
    let sine = cross(direction, along);
    let share = cross(minus(other, point), along) / sine;
    (sine.abs() > 1e-12).then(|| plus(point, direction, share))
}

/// The first or the last of a line's crossings with a circle.
fn through(point: Point, direction: Point, centre: Point, radius: f64, last: bool) -> Option<Point> {
    let to_centre = minus(centre, point);
    let (along, across) = (dot(to_centre, direction), cross(direction, to_centre));
    let half = (radius * radius - across * across).sqrt();
    (!half.is_nan()).then(|| plus(point, direction, if last { along + half } else { along - half }))
}

/// The crossing of two circles that lies left, or right, of the way from one centre to the other.
fn circles(centre: Point, radius: f64, other: Point, far: f64, left: bool) -> Option<Point> {
    let way = minus(other, centre);
    let distance = way[0].hypot(way[1]);
    let along = (radius * radius + distance * distance - far * far) / (2.0 * distance);
    let across = (radius * radius - along * along).sqrt();
    if !(distance > 0.0 && across >= 0.0) {
        return None;
    }
    let unit = [way[0] / distance, way[1] / distance];
    let across = if left { across } else { -across };
    Some(plus(plus(centre, unit, along), [-unit[1], unit[0]], across))
}

pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// `point + share · direction`.
pub(crate) fn plus(point: Point, direction: Point, share: f64) -> Point {
    [point[0] + share * direction[0], point[1] + share * direction[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// A programmed move, its plane's coordinates taken out.
#[derive(Clone, Copy)]
pub(crate) struct Planar<'a> {
    pub index: usize,
    pub axes: (usize, usize),
    pub start: [f64; 3],
    pub end: [f64; 3],
    pub arc: Option<&'a Arc>,
}

impl Planar<'_> {
    pub fn point(&self, position: [f64; 3]) -> Point {
        [position[self.axes.0], position[self.axes.1]]
    }

    pub fn from(&self) -> Point {
        self.point(self.start)
    }

    pub fn to(&self) -> Point {
        self.point(self.end)
    }

    /// Centre and whether it goes clockwise.
    pub fn circle(&self) -> Option<(Point, bool)> {
        self.arc.map(|arc| (self.point(arc.centre), arc.sweep > 0.0))
    }

    /// Unit direction of travel at one of its points.
    pub fn direction(&self, at: Point) -> Point {
        match self.circle() {
            Some((centre, clockwise)) => {
                let arm = minus(at, centre);
                unit(if clockwise { [arm[1], -arm[0]] } else { [-arm[1], arm[0]] })
            }
            None => unit(minus(self.to(), self.from())),
        }
    }
}

pub(crate) fn unit(way: Point) -> Point {
    let length = way[0].hypot(way[1]);
    [way[0] / length, way[1] / length]
}
