//! The contour of a roughing cycle in pieces, each of which only goes down or only comes up.

use std::f64::consts::FRAC_PI_2;

use crate::compensation::offset::minus;
use crate::shapes::arc::Point;
use crate::shapes::drawn::{planar, Contour, Cut};
use crate::turning::rough::{Piece, SAME};

/// Directions less than this apart are one, rad.
const SAME_DIRECTION: f64 = 1e-9;

/// The coordinates of a cycle: along its cuts and how deep, from where it starts.
pub(crate) struct Own {
    axes: (usize, usize),
    origin: Point,
    pub signs: Point,
}

impl Own {
    /// It is cut towards the contour's end, and deep is where the contour first goes.
    pub fn of(contour: &Contour, start: [f64; 3], axes: (usize, usize)) -> Self {
        let origin = planar(start, axes);
        let way = pieces(contour, axes, |point| minus(point, origin));
        let first = way.first().map(|piece| piece.from);
        let mut points = first.into_iter().chain(way.iter().map(|piece| piece.to));
        let along = way.last().map_or(1.0, |piece| piece.to[0]);
        let deep = points.find(|point| point[1].abs() > SAME).map_or(1.0, |point| point[1]);
        Self { axes, origin, signs: [along.signum(), deep.signum()] }
    }

    /// Those that say themselves where they begin and which way they go.
    pub fn new(axes: (usize, usize), origin: Point, signs: Point) -> Self {
        Self { axes, origin, signs }
    }

    /// The position of a point, with the third coordinate of another one.
    pub fn outside_of_origin(&self, point: Point, other: [f64; 3]) -> [f64; 3] {
        let mut position = other;
        (position[self.axes.0], position[self.axes.1]) = (self.origin[0], self.origin[1]);
        self.outside(point, position)
    }

    pub fn inside(&self, point: Point) -> Point {
        [0, 1].map(|axis| self.signs[axis] * (point[axis] - self.origin[axis]))
    }

    pub fn outside(&self, point: Point, start: [f64; 3]) -> [f64; 3] {
        let mut position = start;
        position[self.axes.0] += self.signs[0] * point[0];
        position[self.axes.1] += self.signs[1] * point[1];
        position
    }
}

/// The contour's cuts in the coordinates that `own` makes of those of two axes.
pub(crate) fn pieces(contour: &Contour, axes: (usize, usize), own: impl Fn(Point) -> Point) -> Vec<Piece> {
    let mut from = contour.start;
    let mut pieces = Vec::new();
    for cut in &contour.cuts {
        let centre = cut.arc.map(|arc| own(planar(arc.centre, axes)));
        for point in stops(from, cut) {
            let begins = pieces.last().map_or_else(|| own(planar(contour.start, axes)), |last: &Piece| last.to);
            pieces.push(Piece { from: begins, to: own(planar(point, axes)), centre });
        }
        from = cut.end;
    }
    pieces
}

/// Where an arc in the plane of Z and X passes a quarter of its circle, and where a cut ends.
fn stops(from: [f64; 3], cut: &Cut) -> Vec<[f64; 3]> {
    let Some(arc) = cut.arc else { return vec![cut.end] };
    let (start, centre) = (planar(from, (2, 0)), planar(arc.centre, (2, 0)));
    let out = minus(start, centre);
    let (radius, angle) = (out[0].hypot(out[1]), out[1].atan2(out[0]));
    let way = -arc.sweep.signum(); // angles count from Z to X, a sweep the other way round
    let first = ((way * angle + SAME_DIRECTION) / FRAC_PI_2).floor() + 1.0;
    let turned = |quarter: f64| quarter * FRAC_PI_2 - way * angle;
    let passed = (0..4).map(|count| first + f64::from(count));
    let passed = passed.take_while(|quarter| turned(*quarter) < arc.sweep.abs() - SAME_DIRECTION);
    let place = |quarter: f64| {
        let (z, x) = [(1.0, 0.0), (0.0, way), (-1.0, 0.0), (0.0, -way)][quarter.rem_euclid(4.0) as usize % 4];
        [centre[1] + radius * x, cut.end[1], centre[0] + radius * z]
    };
    passed.map(place).chain([cut.end]).collect()
}

#[cfg(test)]
mod tests {
    use super::stops;
    use crate::path::Arc;
    use crate::shapes::drawn::Cut;

    /// About z = 10, x = 20 with radius 5, from the highest x to the highest z and on.
    fn ends(sweep: f64, end: [f64; 3]) -> Vec<[f64; 3]> {
        let arc = Arc { of_move: 0, centre: [20.0, 0.0, 10.0], sweep, radius: f64::NAN };
        stops([25.0, 0.0, 10.0], &Cut { end, arc: Some(arc) })
    }

    #[test]
    fn arcs_stop_at_each_quarter_of_their_circle() {
        let quarter = std::f64::consts::FRAC_PI_2;
        assert_eq!(ends(quarter, [20.0, 0.0, 15.0]), [[20.0, 0.0, 15.0]]);
        assert_eq!(ends(2.0 * quarter, [15.0, 0.0, 10.0]), [[20.0, 0.0, 15.0], [15.0, 0.0, 10.0]]);
        assert_eq!(ends(-2.0 * quarter, [15.0, 0.0, 10.0]), [[20.0, 0.0, 5.0], [15.0, 0.0, 10.0]]);
        assert_eq!(ends(1.5 * quarter, [16.0, 0.0, 13.0]).len(), 2);
    }
}
