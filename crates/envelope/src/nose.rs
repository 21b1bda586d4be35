//! The nose as a convex body: its support function h(φ) = R + w(φ).
//!
//! φ is the contact angle: that of the outward normal of the surface being cut, from +z towards +x. Where the nose cuts
//! a surface of normal n(φ), the surface lies h(φ) below the nose centre, so w is the radius error over the contact
//! angle. The point of contact is at −(h n + h′ n′) from the centre. The body is convex where h + h″ > 0.

use std::f64::consts::{PI, TAU};
use std::fmt;

use crate::ray::Point;

/// Halving alone comes down to rounding in half as many.
const MOST_STEPS: usize = 100;

/// A Newton step, rad, so small that its linear effect on the depth is right to the square of it: 1e-15 mm.
const NEARLY: f64 = 3e-8;

/// Why a nose is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoseError {
    /// A radius, angle or coefficient is not a finite number, or the radius or step is not positive.
    NotANumber,
    /// The body is not convex at this contact angle: it would not touch a surface of that normal.
    NotConvex {
        /// Contact angle, rad.
        angle: f64,
        /// h + h″ there, mm: the local radius of curvature.
        curvature_radius: f64,
    },
}

impl fmt::Display for NoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotANumber => write!(f, "a value of the nose is not a finite positive number"),
            Self::NotConvex { angle, curvature_radius } => write!(
                f,
                "the nose is hollow at a contact angle of {:.1} degrees: its local radius is {curvature_radius:.4} mm",
                angle.to_degrees()
            ),
        }
    }
}

/// A nose. w is a cubic a piece, Σ c[k]·(φ − begin)ᵏ, pieces of equal width from `first` on; constant beyond them.
#[derive(Clone, Debug)]
pub struct Nose {
    radius: f64,
    first: f64,
    step: f64,
    pieces: Vec<[f64; 4]>,
    roundest: f64,
}

/// A disc around the nose, seen along one ray: its centre lies `above` and `beside` against the nose centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Disc {
    pub radius: f64,
    pub above: f64,
    pub beside: f64,
}

/// Value and derivatives of the support function at one angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Support {
    pub h: f64,
    pub slope: f64,
    pub bend: f64,
}

impl Nose {
    /// A nose of that radius; no pieces: round. Refused when not convex.
    pub fn new(
        radius: f64,
        first: f64,
        step: f64,
        pieces: Vec<[f64; 4]>,
    ) -> Result<Self, NoseError> {
        let finite = pieces.iter().flatten().all(|value| value.is_finite());
        if !(radius.is_finite() && radius > 0.0 && first.is_finite() && step > 0.0 && finite) {
            return Err(NoseError::NotANumber);
        }
        let mut nose = Self {
            radius,
            first,
            step,
            pieces,
            roundest: radius,
        };
        nose.check_convex()?;
        nose.roundest = nose.largest_curvature_radius();
        Ok(nose)
    }

    /// Whether w is zero everywhere.
    pub fn is_round(&self) -> bool {
        self.pieces.is_empty()
    }

    /// A disc that holds the whole nose and touches it where a surface of this normal would.
    ///
    /// A convex body whose radius of curvature is nowhere above r lies within every disc of radius r that touches it
    /// from outside in (Blaschke).
    pub(crate) fn disc(&self, angle: f64) -> Disc {
        let support = self.support(angle);
        Disc {
            radius: self.roundest,
            above: support.h - self.roundest,
            beside: support.slope,
        }
    }

    pub(crate) fn support(&self, angle: f64) -> Support {
        let wrapped = wrapped(angle);
        let (Some(begin), Some(end)) = (self.pieces.first(), self.pieces.last()) else {
            return Support {
                h: self.radius,
                slope: 0.0,
                bend: 0.0,
            };
        };
        let at = (wrapped - self.first) / self.step;
        if at <= 0.0 {
            return Support {
                h: self.radius + begin[0],
                slope: 0.0,
                bend: 0.0,
            };
        }
        let index = at as usize;
        let Some(piece) = self.pieces.get(index) else {
            return Support {
                h: self.radius + cubic(end, self.step),
                slope: 0.0,
                bend: 0.0,
            };
        };
        let u = wrapped - self.first - index as f64 * self.step;
        Support {
            h: self.radius + cubic(piece, u),
            slope: piece[1] + u * (2.0 * piece[2] + 3.0 * u * piece[3]),
            bend: 2.0 * piece[2] + 6.0 * u * piece[3],
        }
    }

    /// Where the contact with a surface of this normal lies, from the nose centre.
    pub(crate) fn contact(&self, normal: Point) -> Point {
        if self.is_round() {
            return [-self.radius * normal[0], -self.radius * normal[1]];
        }
        let support = self.support(normal[0].atan2(normal[1]));
        let [x, z] = normal;
        [
            -(support.h * x + support.slope * z),
            -(support.h * z - support.slope * x),
        ]
    }

    /// How far below its centre the nose meets a ray at direction angle `angle` that passes `over` beside the centre.
    ///
    /// `turn` is by how much the normal at the point met is turned against the ray: a guess comes in, for a ray that
    /// passes a little further on the last one's, and what was found goes out. The point met moves across as the normal
    /// turns and never comes back, because the nose is convex: Newton steps that leave the bracket, as they may near a
    /// graze, halve it instead.
    pub(crate) fn depth(&self, angle: f64, over: f64, turn: &mut f64) -> Option<f64> {
        if self.is_round() {
            let square = self.radius * self.radius - over * over;
            return (square > 0.0).then(|| square.sqrt());
        }
        let (mut low, mut high) = (-0.5 * PI, 0.5 * PI);
        if over <= -self.support(angle + low).h || over >= self.support(angle + high).h {
            return None;
        }
        *turn = turn.clamp(low, high);
        let mut depth = 0.0;
        for _ in 0..MOST_STEPS {
            let support = self.support(angle + *turn);
            let (sine, cosine) = turn.sin_cos();
            let curvature_radius = support.h + support.bend;
            let miss = support.h * sine + support.slope * cosine - over;
            let newton = -miss / (curvature_radius * cosine);
            depth = support.h * cosine - support.slope * sine;
            if newton.abs() < NEARLY {
                return Some(depth - curvature_radius * sine * newton);
            }
            if miss > 0.0 {
                high = *turn;
            } else {
                low = *turn;
            }
            let next = *turn + newton;
            *turn = if next > low && next < high {
                next
            } else {
                0.5 * (low + high)
            };
        }
        Some(depth)
    }

    fn check_convex(&self) -> Result<(), NoseError> {
        for k in 0..self.pieces.len() {
            for share in [1e-9, 0.25, 0.5, 0.75, 1.0 - 1e-9] {
                let angle = self.first + (k as f64 + share) * self.step;
                let support = self.support(angle);
                let curvature_radius = support.h + support.bend;
                if curvature_radius <= 0.0 {
                    return Err(NoseError::NotConvex {
                        angle,
                        curvature_radius,
                    });
                }
            }
        }
        Ok(())
    }

    /// An upper bound of h + h″: in every piece the sum of its terms' sizes.
    fn largest_curvature_radius(&self) -> f64 {
        let h = self.step;
        let most = |[a, b, c, d]: &[f64; 4]| {
            a + 2.0 * c + h * ((b + 6.0 * d).abs() + h * (c.abs() + h * d.abs()))
        };
        let last = self.pieces.last().map_or(0.0, |piece| cubic(piece, h));
        let first = self.pieces.first().map_or(0.0, |piece| piece[0]);
        let ends = last.max(first);
        self.radius + self.pieces.iter().map(most).fold(ends, f64::max)
    }
}

/// The angle between −π and π. Rays and turns of at most a quarter are half a turn off at most: the division is rare.
fn wrapped(angle: f64) -> f64 {
    if angle.abs() <= PI {
        return angle;
    }
    let near = angle - TAU.copysign(angle);
    if near.abs() <= PI {
        return near;
    }
    (angle + PI).rem_euclid(TAU) - PI
}

fn cubic(piece: &[f64; 4], u: f64) -> f64 {
    piece[0] + u * (piece[1] + u * (piece[2] + u * piece[3]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displaced_circle_is_a_nose_whose_support_has_a_sine() {
        // h = R + a sin φ is the circle moved by −a along x: an oracle without Newton. Cubics of 0.2° follow the sine to 1e-13.
        let (radius, moved, step, first) = (0.8, 0.02, 0.2_f64.to_radians(), -1.0);
        let pieces = (0..600)
            .map(|k| {
                let at = first + k as f64 * step;
                let (sine, cosine) = at.sin_cos();
                [
                    moved * sine,
                    moved * cosine,
                    -moved * sine / 2.0,
                    -moved * cosine / 6.0,
                ]
            })
            .collect();
        let nose = Nose::new(radius, first, step, pieces).expect("convex");
        for k in 0..100 {
            let (angle, over) = (0.1 + 0.004 * k as f64, -0.3 + 0.006 * k as f64);
            let (sine, cosine) = angle.sin_cos();
            // The moved centre, from the nose centre, in the ray's frame.
            let (along, across) = (-moved * sine, -moved * cosine);
            let expected = (radius * radius - (over + across) * (over + across)).sqrt() - along;
            let found = nose.depth(angle, over, &mut 0.0).expect("hit");
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
    }

    #[test]
    fn a_hollow_nose_is_refused() {
        let refused = Nose::new(0.8, 0.0, 0.1, vec![[0.0, 0.0, -0.5, 0.0]]);
        assert!(matches!(refused, Err(NoseError::NotConvex { .. })));
    }
}
