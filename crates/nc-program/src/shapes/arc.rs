//! Circles through the start and end of a move, in the coordinates of its plane (first, second axis).

use std::f64::consts::TAU;

/// Point of a plane, mm.
pub type Point = [f64; 2];

/// A centre and the angle turned about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Centre.
    pub centre: Point,
    /// Angle, positive clockwise; never zero.
    pub sweep: f64,
}

/// Turned angles below this are a full turn: start and end are one point.
const SAME_DIRECTION: f64 = 1e-12;

/// The arc about a given centre. `None` when the start is the centre.
pub fn about(start: Point, end: Point, centre: Point, clockwise: bool) -> Option<Circle> {
    let from = [start[0] - centre[0], start[1] - centre[1]];
    let to = [end[0] - centre[0], end[1] - centre[1]];
    if !(from[0].hypot(from[1]) > 0.0 && to[0].hypot(to[1]) > 0.0) {
        return None;
    }
    let cross = from[0] * to[1] - from[1] * to[0];
    let counterclockwise = cross.atan2(from[0] * to[0] + from[1] * to[1]);
    let turned = (if clockwise { -counterclockwise } else { counterclockwise }).rem_euclid(TAU);
    let turned = if turned < SAME_DIRECTION { TAU } else { turned };
    Some(Circle { centre, sweep: if clockwise { turned } else { -turned } })
}

/// The arc of a given radius: at most half a turn, for a negative radius at least half a turn.
///
/// A chord longer than the diameter by up to `slack` makes it a half turn about the chord's middle. `None` when the
/// chord is longer still, or has no length.
pub fn with_radius(start: Point, end: Point, radius: f64, clockwise: bool, slack: f64) -> Option<Circle> {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let half = chord[0].hypot(chord[1]) / 2.0;
    if !(half > 0.0 && half <= radius.abs() + slack) {
        return None;
    }
    // The square root would make a tenth of a micrometre out of the last bit of a half turn's chord.
    let half_turn = half > radius.abs() * (1.0 - 1e-12);
    let height = if half_turn { 0.0 } else { (radius * radius - half * half).sqrt() };
    let right = if clockwise == (radius > 0.0) { height } else { -height };
    let centre = [
        (start[0] + end[0]) / 2.0 + right * chord[1] / (2.0 * half),
        (start[1] + end[1]) / 2.0 - right * chord[0] / (2.0 * half),
    ];
    about(start, end, centre, clockwise)
}

/// The centre of the circle through three points, and twice the area of their triangle, positive where they turn left.
pub fn through(a: Point, b: Point, c: Point) -> (Point, f64) {
    let (b, c) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let (area, bb, cc) = (b[0] * c[1] - b[1] * c[0], b[0] * b[0] + b[1] * b[1], c[0] * c[0] + c[1] * c[1]);
    ([a[0] + (c[1] * bb - b[1] * cc) / (2.0 * area), a[1] + (b[0] * cc - c[0] * bb) / (2.0 * area)], area)
}

#[cfg(test)]
mod tests {
    use super::{about, with_radius};
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    #[test]
    fn quarter_turns_both_ways() {
        let (top, right) = ([0.0, 1.0], [1.0, 0.0]);
        assert!((about(top, right, [0.0, 0.0], true).unwrap().sweep - FRAC_PI_2).abs() < 1e-15);
        assert!((about(right, top, [0.0, 0.0], false).unwrap().sweep + FRAC_PI_2).abs() < 1e-15);
        assert!((about(top, right, [0.0, 0.0], false).unwrap().sweep + 1.5 * PI).abs() < 1e-15);
        assert_eq!(about(top, top, [0.0, 0.0], true).unwrap().sweep, TAU);
    }

    #[test]
    fn arcs_that_cannot_exist() {
        assert_eq!(about([1.0, 1.0], [2.0, 1.0], [1.0, 1.0], true), None);
        assert_eq!(with_radius([0.0, 0.0], [3.0, 0.0], 1.0, true, 1e-3), None);
        assert_eq!(with_radius([1.0, 0.0], [1.0, 0.0], 1.0, true, 1e-3), None);
        assert_eq!(with_radius([f64::NAN, 0.0], [1.0, 0.0], 1.0, true, 1e-3), None);
    }

    proptest! {
        /// A circle of known centre, radius and sweep is found again from its ends and radius.
        #[test]
        fn radius_form_finds_the_circle(
            centre in prop::array::uniform2(-100.0..100.0f64),
            radius in 0.1..200.0f64,
            from in 0.0..TAU,
            sweep in prop_oneof![0.05..3.0f64, 3.3..6.2f64],
            clockwise: bool,
        ) {
            let point = |angle: f64| [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()];
            let to = if clockwise { from - sweep } else { from + sweep };
            let signed = if sweep > PI { -radius } else { radius };
            let found = with_radius(point(from), point(to), signed, clockwise, 0.0).unwrap();
            prop_assert!((found.sweep.abs() - sweep).abs() < 1e-9);
            prop_assert_eq!(found.sweep > 0.0, clockwise);
            prop_assert!((found.centre[0] - centre[0]).abs() < 1e-9 * radius.max(1.0) * 10.0);
            prop_assert!((found.centre[1] - centre[1]).abs() < 1e-9 * radius.max(1.0) * 10.0);
        }
    }
}
