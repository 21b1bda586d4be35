//! A machine model's error at a point, fast enough for a servo period: no allocation, no panic, no standard library.
//!
//! For machines whose three linear axes move while rotary ones stand still. Every carrier of errors (an axis, a spindle)
//! is a [`Body`]: six errors as piecewise polynomials of one axis' position, and an arm from its frame to the tool point.
//!
//! E = Σ over bodies (d + r × arm) + Σ over axes slope · q, with d the three displacements, r the three rotations,
//! arm = arm₀ + (those axes' positions that lie between the body and the tool point). First order in the errors.
//!
//! One code for one point and for as many as a vector register holds: generic over [`pulp::Simd`].

#![no_std]

mod body;
mod lanes;

use pulp::{Arch, Scalar, Simd, WithSimd};

pub use body::{add_local, Arm, Body, ModelError, Six, COMPONENTS};
use lanes::{columns, write};

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

    /// E = actual − commanded at machine position `q`; `travel` is how each axis came there: +1 forward, −1 return, 0
    /// not known, which gives the mean of both.
    #[must_use]
    pub fn error(&self, q: Vector, travel: Vector) -> Vector {
        self.at(Scalar::new(), &q, &travel)
    }

    /// E at many positions, three numbers each, into `out`, which is as long.
    ///
    /// `travel` holds that of each axis at each position; where it has ended travel is not known.
    pub fn errors(&self, positions: &[f64], travel: &[f64], out: &mut [f64]) {
        Arch::new().dispatch(Batch {
            model: *self,
            positions,
            travel,
            out,
        });
    }

    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, q: &[S::f64s; 3], travel: &[S::f64s; 3]) -> [S::f64s; 3] {
        let mut error = [simd.splat_f64s(0.0); 3];
        for (position, slope) in q.iter().zip(&self.slope) {
            for (sum, part) in error.iter_mut().zip(slope) {
                *sum = simd.mul_add_e_f64s(*position, simd.splat_f64s(*part), *sum);
            }
        }
        for body in self.bodies {
            body.add_error(simd, q, travel, &mut error);
        }
        error
    }
}

/// Points worked off with the widest registers that the processor has.
struct Batch<'a> {
    model: Model<'a>,
    positions: &'a [f64],
    travel: &'a [f64],
    out: &'a mut [f64],
}

impl WithSimd for Batch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let size = 3 * S::F64_LANES;
        let mut travel = self.travel.chunks(size);
        for (points, out) in self.positions.chunks(size).zip(self.out.chunks_mut(size)) {
            let travel = columns(simd, travel.next().unwrap_or(&[]));
            write(
                simd,
                self.model.at(simd, &columns(simd, points), &travel),
                out,
            );
        }
    }
}

#[cfg(test)]
mod tests;
