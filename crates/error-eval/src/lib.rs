//! A machine model's error at a point, fast enough for a servo period: no allocation, no panic, no standard library.
//!
//! For machines whose three linear axes move while rotary ones stand still. Every carrier of errors (an axis, a spindle)
//! is a [`Body`]: six errors as piecewise polynomials of one axis' position, and an arm from its frame to the tool point.
//!
//! E = Σ over bodies (d + r × arm) + Σ over axes slope · q, with d the three displacements, r the three rotations,
//! arm = arm₀ + (those axes' positions that lie between the body and the tool point). First order in the errors.

#![no_std]

mod body;

pub use body::{Body, ModelError, Way, COMPONENTS};

/// Position or error: X, Y, Z in mm.
pub type Vector = [f64; 3];

/// A compiled model. It borrows its numbers, so that a controller may keep them where it likes.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    bodies: &'a [Body<'a>],
    slope: [Vector; 3],
}

impl<'a> Model<'a> {
    /// A model of checked bodies; `slope[axis]` is what squareness adds to E a millimetre of that axis.
    pub const fn new(bodies: &'a [Body<'a>], slope: [Vector; 3]) -> Self {
        Self { bodies, slope }
    }

    /// E = actual − commanded at machine position `q`, each axis having come the way `way` says.
    #[must_use]
    pub fn error(&self, q: Vector, way: [Way; 3]) -> Vector {
        let mut error = [0.0; 3];
        for (position, slope) in q.iter().zip(&self.slope) {
            for (sum, part) in error.iter_mut().zip(slope) {
                *sum += position * part;
            }
        }
        for body in self.bodies {
            let part = body.error(q, way);
            for (sum, part) in error.iter_mut().zip(part) {
                *sum += part;
            }
        }
        error
    }

    /// E at many positions, three numbers each, into `out`; what is beyond the shortest is left out.
    ///
    /// `ways` holds the sign of travel of each axis at each position; without it travel is not known.
    pub fn errors(&self, positions: &[f64], ways: Option<&[f64]>, out: &mut [f64]) {
        let points = positions.chunks_exact(3).map(vector);
        let results = out.chunks_exact_mut(3);
        match ways {
            None => {
                for (q, error) in points.zip(results) {
                    error.copy_from_slice(&self.error(q, [Way::Unknown; 3]));
                }
            }
            Some(ways) => {
                let ways = ways.chunks_exact(3).map(vector);
                for ((q, way), error) in points.zip(ways).zip(results) {
                    error.copy_from_slice(&self.error(q, way.map(Way::of_sign)));
                }
            }
        }
    }
}

#[inline]
fn vector(row: &[f64]) -> Vector {
    match *row {
        [x, y, z] => [x, y, z],
        _ => [0.0; 3],
    }
}

#[cfg(test)]
mod tests;
