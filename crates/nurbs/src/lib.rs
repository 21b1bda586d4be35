//! The closest points of a B-spline patch, rational or not, for many points at once.
//!
//! The patch is cut into Bézier pieces, small enough to be nearly flat (`pieces`). Boxes around ever more of them
//! (`boxes`) lead from a point to the few pieces that can be nearest to it; Newton's method (`descent`) goes on from there.
//! A piece's control points bound it, so that no nearer piece is overlooked. Nothing here panics.

mod bezier;
mod boxes;
mod descent;
mod direction;
mod patch;

pub use patch::{Foot, Patch, Refused};

/// A point or a vector: (x, y, z).
pub type Point3 = [f64; 3];

pub(crate) fn minus(a: Point3, b: Point3) -> Point3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Point3, b: Point3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
