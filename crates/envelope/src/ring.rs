//! The edge of a bull-nose or flat end cutter on a segment of its way, its axis kept: where a ray enters it.
//!
//! The cutter's end is a disc of the ring's radius with a ball of the corner's radius around each of its points, and its
//! sweep along a segment is convex: the points within a corner radius of the swept disc. On a ray the distance from that
//! is a convex function, and Newton's method from outside comes to its first place without ever stepping over it.

use crate::mill::{dot, minus, Point3};

/// Steps along a ray at most; each more than halves what is left unless the ray only grazes the cutter.
const STEPS: usize = 80;
const HALVINGS: usize = 60;
/// mm: nearer than this is there.
const THERE: f64 = 1e-12;

/// A cutter's end: the radius of the circle on which the corner's centre runs, the corner's, and the axis.
#[derive(Clone, Copy, Debug)]
pub struct End {
    pub(crate) ring: f64,
    pub(crate) corner: f64,
    axis: Point3,
}

impl End {
    /// The axis is a unit vector out of the material.
    pub fn new(ring: f64, corner: f64, axis: Point3) -> Self {
        Self { ring, corner, axis }
    }

    /// Farthest that the end reaches from the ring's centre.
    pub(crate) fn reach(&self) -> f64 {
        self.ring + self.corner
    }

    /// Where a ray from the origin first meets the end on its way from `from` on, between `low` and `high`; infinite
    /// where it does not.
    pub(crate) fn entry(
        &self,
        from: Point3,
        segment: Point3,
        direction: Point3,
        [low, high]: [f64; 2],
    ) -> f64 {
        let (start, end) = (
            dot(from, direction),
            dot(from, direction) + dot(segment, direction),
        );
        if start.max(end) <= low {
            return f64::INFINITY;
        }
        let mut t = low;
        for _ in 0..STEPS {
            let away = self.away(direction.map(|part| t * part), from, segment);
            let distance = dot(away, away).sqrt();
            let left = distance - self.corner;
            if left <= THERE {
                return t;
            }
            let slope = dot(away, direction) / distance;
            t -= left / slope;
            if slope >= 0.0 || t >= high {
                return f64::INFINITY;
            }
        }
        t
    }

    /// The vector to a point from the nearest place of the disc on its way.
    fn away(&self, point: Point3, from: Point3, segment: Point3) -> Point3 {
        let at = |share: f64| {
            let centre = [0, 1, 2].map(|k| from[k] + share * segment[k]);
            self.beyond_disc(minus(point, centre))
        };
        // The squared distance is convex in the share, and this is its slope but for −2.
        let ahead = |share: f64| dot(at(share), segment);
        if ahead(0.0) <= 0.0 {
            return at(0.0);
        }
        if ahead(1.0) >= 0.0 {
            return at(1.0);
        }
        at(zero(ahead))
    }

    /// The vector to a point, given from the disc's centre, from the nearest place of the disc.
    fn beyond_disc(&self, point: Point3) -> Point3 {
        let height = dot(point, self.axis);
        let aside = [0, 1, 2].map(|k| point[k] - height * self.axis[k]);
        let radius = dot(aside, aside).sqrt();
        let beyond = if radius > self.ring {
            1.0 - self.ring / radius
        } else {
            0.0
        };
        [0, 1, 2].map(|k| height * self.axis[k] + beyond * aside[k])
    }
}

/// Where a falling function is zero between 0 and 1 (regula falsi, halving what it gets stuck at).
fn zero(falling: impl Fn(f64) -> f64) -> f64 {
    let ([mut a, mut b], [mut above, mut below]) = ([0.0, 1.0], [falling(0.0), falling(1.0)]);
    for _ in 0..HALVINGS {
        let middle = (a * below - b * above) / (below - above);
        let value = falling(middle);
        if value == 0.0 || b - a < 1e-15 {
            return middle;
        }
        if value > 0.0 {
            (a, above, below) = (middle, value, 0.5 * below);
        } else {
            (b, below, above) = (middle, value, 0.5 * above);
        }
    }
    0.5 * (a + b)
}
