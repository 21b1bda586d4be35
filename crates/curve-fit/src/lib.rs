//! Least-squares splines with end conditions that are met exactly.
//!
//! The space is the clamped B-spline basis of degree 0 to 3 on `[0, length]` (`space`). In it the value and the slope
//! at an end belong to the two outermost coefficients alone, so that end conditions are eliminated without rounding
//! (`ends`), and the remaining problem is banded: a sequence of square-root-free Givens rotations (`triangle`), one row
//! a point. `fit` puts the three together and returns what the curve's uncertainty needs besides its coefficients.
//! Nothing here panics: every input is either fitted or refused with a `FitError`.

mod ends;
mod error;
mod fit;
mod space;
mod triangle;

pub use ends::EndConditions;
pub use error::FitError;
pub use fit::{fit, Fit};
pub use space::{BasisRow, Piece, Side, SplineSpace, MAX_DEGREE, ORDER};
