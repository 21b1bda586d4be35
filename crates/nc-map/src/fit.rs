//! What points on a displaced move lie on: a line, a circle.

use std::f64::consts::TAU;

use nc_program::Plane;

use crate::field::Vector;

/// Intervals between the points at which one turn of an arc is looked at.
pub(crate) const ARC_PROBES: usize = 8;

/// Largest distance of the points from those that share the way from the first to the last evenly.
pub(crate) fn chord_error(points: &[Vector]) -> f64 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return 0.0;
    };
    let count = (points.len() - 1) as f64;
    let off = |(index, point): (usize, &Vector)| {
        let share = index as f64 / count;
        let difference = [0, 1, 2].map(|axis| point[axis] - first[axis] - share * (last[axis] - first[axis]));
        (difference[0].powi(2) + difference[1].powi(2) + difference[2].powi(2)).sqrt()
    };
    points.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Centre of the helix through the points; `None` where it misses one by more than the tolerance.
pub(crate) fn circle(points: &[Vector], plane: Plane, tolerance_mm: f64) -> Option<Vector> {
    let (first, second, third) = plane.axes();
    let flat = |point: &Vector| [point[first], point[second]];
    let (start, end) = (points.first()?, points.last()?);
    // On a full circle first and last point coincide: two others of its first turn determine it.
    let closed = distance(flat(start), flat(end)) < 0.1 * distance(flat(start), flat(points.get(ARC_PROBES / 2)?));
    let chosen = if closed || points.len() > ARC_PROBES + 1 { [3, 5] } else { [ARC_PROBES / 2, ARC_PROBES] };
    let centre = through(flat(start), flat(points.get(chosen[0])?), flat(points.get(chosen[1])?))?;
    let radius = distance(flat(start), centre);
    let angle = |point: &Vector| (point[second] - centre[1]).atan2(point[first] - centre[0]);
    let (mut turned, mut before, mut last) = (Vec::new(), angle(start), 0.0);
    for point in points {
        last += (angle(point) - before + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        before = angle(point);
        turned.push(last);
    }
    for (point, angle) in points.iter().zip(&turned) {
        let across = point[third] - start[third] - angle / last * (end[third] - start[third]);
        let off = (distance(flat(point), centre) - radius).hypot(across);
        if off.is_nan() || off > tolerance_mm {
            return None;
        }
    }
    let mut whole = *start;
    (whole[first], whole[second]) = (centre[0], centre[1]);
    Some(whole)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Centre of the circle through three points of a plane.
fn through(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<[f64; 2]> {
    let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let twice = 2.0 * (bx * cy - by * cx);
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let centre = [a[0] + (cy * b2 - by * c2) / twice, a[1] + (bx * c2 - cx * b2) / twice];
    centre.iter().all(|value| value.is_finite()).then_some(centre)
}
