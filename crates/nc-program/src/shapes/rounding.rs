//! Corners between two moves, rounded or chamfered: their geometry, in the coordinates of a plane.

use std::f64::consts::TAU;

use crate::compensation::offset::{cross, dot, meeting, minus, plus, Piece};
use crate::shapes::arc::{self, Point};

/// Turns below this (rad) are no corner, and shares of a move beyond its ends by no more are at them.
const NOTHING: f64 = 1e-9;

/// What stands in place of a corner, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Corner {
    /// An arc of that radius.
    Round(f64),
    /// A chamfer that begins and ends that far from the corner.
    Leg(f64),
    /// A chamfer of that length.
    Face(f64),
}

/// A move in its plane: straight, or about a centre by an angle that is positive clockwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub from: Point,
    pub to: Point,
    pub turn: Option<(Point, f64)>,
}

/// What is cut in place of a corner, and the share of the moves before and after it at which it begins and ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub way: Way,
    pub leaves: f64,
    pub enters: f64,
}

impl Way {
    fn direction(&self, at: Point) -> Point {
        let along = match self.turn {
            Some((centre, sweep)) => {
                let arm = minus(at, centre);
                [sweep.signum() * arm[1], -sweep.signum() * arm[0]]
            }
            None => minus(self.to, self.from),
        };
        let length = along[0].hypot(along[1]);
        along.map(|part| part / length)
    }

    /// The path of a circle's centre that touches it on its left or right; `None` where the circle is too large.
    fn beside(&self, radius: f64, left: bool) -> Option<Piece> {
        let Some((centre, sweep)) = self.turn else {
            let direction = self.direction(self.to);
            let across = if left { radius } else { -radius };
            return Some(Piece::Line(plus(self.to, [-direction[1], direction[0]], across), direction));
        };
        let clockwise = sweep > 0.0;
        let inside = left != clockwise;
        let arm = minus(self.to, centre);
        let own = arm[0].hypot(arm[1]);
        let far = if inside { own - radius } else { own + radius };
        (far > 0.0).then_some(Piece::Circle { centre, radius: far, inside, clockwise })
    }

    /// Its point nearest to another.
    fn nearest(&self, to: Point) -> Point {
        match self.turn {
            Some((centre, _)) => {
                let (arm, way) = (minus(self.to, centre), minus(to, centre));
                plus(centre, way, arm[0].hypot(arm[1]) / way[0].hypot(way[1]))
            }
            None => {
                let direction = self.direction(self.to);
                plus(self.from, direction, dot(minus(to, self.from), direction))
            }
        }
    }

    /// At which share of it one of its points lies.
    fn share(&self, at: Point) -> f64 {
        match self.turn {
            Some((centre, sweep)) => {
                let turned = arc::about(self.from, at, centre, sweep > 0.0).map_or(f64::NAN, |circle| circle.sweep);
                let turned = if turned.abs() > TAU - NOTHING { 0.0 } else { turned };
                turned / sweep
            }
            None => {
                let way = minus(self.to, self.from);
                dot(minus(at, self.from), way) / dot(way, way)
            }
        }
    }
}

/// What is cut between two moves that meet; `None` where they go on without a corner, else why it cannot be cut.
///
/// A rounding touches both moves: its centre is where the paths meet of a circle that rolls along each on the side to
/// which the corner turns. A chamfer of length l has legs l / (2 cos(turn / 2)).
pub(crate) fn cut(corner: Corner, before: &Way, after: &Way) -> Result<Option<Cut>, String> {
    let (arriving, leaving) = (before.direction(before.to), after.direction(after.from));
    let turn = cross(arriving, leaving).atan2(dot(arriving, leaving));
    let (size, what) = match corner {
        Corner::Round(radius) => (radius, "a rounding"),
        Corner::Leg(leg) => (leg, "a chamfer"),
        Corner::Face(length) => (length, "a chamfer"),
    };
    if turn.is_nan() || size.is_nan() || size <= 0.0 {
        return Err(format!("{what} of {size:.4} mm beside a move that leads nowhere"));
    }
    if turn.abs() < NOTHING {
        return Ok(None);
    }
    let way = match corner {
        Corner::Round(radius) => rounded(radius, before, after, turn > 0.0),
        Corner::Leg(_) | Corner::Face(_) if before.turn.or(after.turn).is_some() => {
            return Err("a chamfer between a line and an arc is not worked out".into());
        }
        Corner::Leg(leg) => Some(chamfer(leg, before, arriving, leaving)),
        Corner::Face(length) => Some(chamfer(length / (2.0 * (turn / 2.0).cos()), before, arriving, leaving)),
    };
    let found = way.map(|way| Cut { way, leaves: before.share(way.from), enters: after.share(way.to) });
    let within = |share: f64| (-NOTHING..=1.0 + NOTHING).contains(&share);
    let fits = found.filter(|cut| within(cut.leaves) && within(cut.enters));
    fits.map(Some).ok_or_else(|| format!("{what} of {size:.4} mm does not fit between the moves beside it"))
}

fn rounded(radius: f64, before: &Way, after: &Way, left: bool) -> Option<Way> {
    let centre = meeting(before.beside(radius, left)?, after.beside(radius, left)?)?;
    let (from, to) = (before.nearest(centre), after.nearest(centre));
    let circle = arc::about(from, to, centre, !left)?;
    Some(Way { from, to, turn: Some((centre, circle.sweep)) })
}

fn chamfer(leg: f64, before: &Way, arriving: Point, leaving: Point) -> Way {
    Way { from: plus(before.to, arriving, -leg), to: plus(before.to, leaving, leg), turn: None }
}

#[cfg(test)]
mod tests {
    use super::{cut, Corner, Way};
    use proptest::prelude::*;
    use std::f64::consts::{PI, SQRT_2};

    const fn line(from: [f64; 2], to: [f64; 2]) -> Way {
        Way { from, to, turn: None }
    }

    fn close(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9
    }

    /// A square corner at (10, 0): legs of 2 either way; a face of 2 has legs of √2.
    #[test]
    fn a_leg_is_no_face() {
        let (before, after) = (line([0.0, 0.0], [10.0, 0.0]), line([10.0, 0.0], [10.0, 10.0]));
        let found = cut(Corner::Leg(2.0), &before, &after).unwrap().unwrap().way;
        assert!(close(found.from, [8.0, 0.0]) && close(found.to, [10.0, 2.0]));
        let found = cut(Corner::Face(2.0), &before, &after).unwrap().unwrap().way;
        assert!(close(found.from, [10.0 - SQRT_2, 0.0]) && close(found.to, [10.0, SQRT_2]));
    }

    /// A line along y = 0 that runs into the arc about (10, 5) of radius 5 from its lowest point would go on without a
    /// corner; one from (15, 5), the arc going clockwise down from there, has its rounding of radius 1 outside the arc.
    #[test]
    fn roundings_beside_arcs_touch_both() {
        let before = line([30.0, 5.0], [15.0, 5.0]);
        let after = Way { from: [15.0, 5.0], to: [10.0, 0.0], turn: Some(([10.0, 5.0], PI / 2.0)) };
        let found = cut(Corner::Round(1.0), &before, &after).unwrap().unwrap().way;
        // Centre at y = 4, 6 from (10, 5): x = 10 + √35.
        let centre = [10.0 + 35f64.sqrt(), 4.0];
        assert!(close(found.turn.unwrap().0, centre) && found.turn.unwrap().1 < 0.0);
        assert!(close(found.from, [centre[0], 5.0]));
        assert!(close(found.to, [10.0 + 35f64.sqrt() * 5.0 / 6.0, 5.0 - 5.0 / 6.0]));
    }

    #[test]
    fn what_does_not_fit() {
        let (before, after) = (line([0.0, 0.0], [10.0, 0.0]), line([10.0, 0.0], [10.0, 1.0]));
        for corner in
            [Corner::Round(1.1), Corner::Leg(1.1), Corner::Face(1.5), Corner::Leg(-1.0), Corner::Round(f64::NAN)]
        {
            assert!(cut(corner, &before, &after).is_err());
        }
        assert!(cut(Corner::Round(1.0), &before, &after).unwrap().is_some());
        assert!(cut(Corner::Round(1.0), &before, &line([10.0, 0.0], [11.0, 0.0])).unwrap().is_none());
        assert!(cut(Corner::Round(1.0), &before, &line([10.0, 0.0], [0.0, 0.0])).is_err());
    }

    proptest! {
        /// Between two lines that turn by t a rounding of radius R leaves R tan(|t| / 2) before the corner, which is
        /// where its circle touches: both ends are R from its centre, square to the lines.
        #[test]
        fn a_rounding_leaves_and_meets_tangentially(turn in -3.0..3.0f64, radius in 0.01..1.0f64) {
            prop_assume!(turn.abs() > 1e-3);
            let (before, after) = (line([-50.0, 0.0], [0.0, 0.0]), line([0.0, 0.0], [50.0 * turn.cos(), 50.0 * turn.sin()]));
            let found = cut(Corner::Round(radius), &before, &after).unwrap().unwrap();
            let leg = radius * (turn.abs() / 2.0).tan();
            prop_assert!((found.leaves * 50.0 - 50.0 + leg).abs() < 1e-9);
            prop_assert!((found.enters * 50.0 - leg).abs() < 1e-9);
            let (centre, sweep) = found.way.turn.unwrap();
            prop_assert!((sweep + turn).abs() < 1e-6);
            prop_assert!(close(centre, [-leg, radius.copysign(turn)]));
        }
    }
}
