//! Why a fit is refused.

use std::fmt;

/// A refusal, with the numbers that say where: indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // the fields are what the message of each variant prints
pub enum FitError {
    /// The degree is above what the kernel holds.
    Degree { degree: usize },
    /// The interval has no length, or it is not a finite number.
    Length { length: f64 },
    /// An interior knot lies outside the open interval, before its predecessor, or is repeated more often than the
    /// degree allows.
    Knot { index: usize, knot: f64 },
    /// Arrays that must have one entry a point differ in length.
    Shape { points: usize, other: usize },
    /// A point, value, weight or end condition is not a finite number.
    NotFinite { index: usize },
    /// A point lies outside the interval.
    Outside { index: usize, point: f64 },
    /// A point lies before its predecessor.
    Unordered { index: usize, point: f64 },
    /// A weight is not positive.
    Weight { index: usize, weight: f64 },
    /// The end conditions need more coefficients than the space has.
    TooManyConditions { needed: usize, coefficients: usize },
    /// The points do not determine a coefficient: too few of them where it acts.
    Undetermined {
        coefficient: usize,
        from: f64,
        to: f64,
    },
}

impl FitError {
    /// A short name, stable across versions.
    pub fn kind(&self) -> &'static str {
        match self {
            FitError::Degree { .. } => "degree",
            FitError::Length { .. } => "length",
            FitError::Knot { .. } => "knot",
            FitError::Shape { .. } => "shape",
            FitError::NotFinite { .. } => "not-finite",
            FitError::Outside { .. } => "outside",
            FitError::Unordered { .. } => "unordered",
            FitError::Weight { .. } => "weight",
            FitError::TooManyConditions { .. } => "too-many-conditions",
            FitError::Undetermined { .. } => "undetermined",
        }
    }
}

impl FitError {
    /// From where to where along the curve points are missing.
    pub fn missing(&self) -> Option<(f64, f64)> {
        match *self {
            FitError::Undetermined { from, to, .. } => Some((from, to)),
            _ => None,
        }
    }
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            FitError::Degree { degree } => write!(f, "degree {degree} is above 3"),
            FitError::Length { length } => write!(f, "the curve's length {length} is not a positive number"),
            FitError::Knot { index, knot } => write!(
                f,
                "interior knot {index} at {knot} is outside the curve, out of order or repeated too often"
            ),
            FitError::Shape { points, other } => {
                write!(f, "{points} points, but {other} values or weights")
            }
            FitError::NotFinite { index } => write!(f, "entry {index} is not a finite number"),
            FitError::Outside { index, point } => write!(f, "point {index} at {point} lies outside the curve"),
            FitError::Unordered { index, point } => write!(f, "point {index} at {point} lies before its predecessor"),
            FitError::Weight { index, weight } => write!(f, "weight {index} is {weight}, not positive"),
            FitError::TooManyConditions { needed, coefficients } => write!(
                f,
                "the end conditions need {needed} coefficients, the curve has {coefficients}"
            ),
            FitError::Undetermined { coefficient, from, to } => write!(
                f,
                "too few points between {from} and {to} to determine coefficient {coefficient}"
            ),
        }
    }
}

impl std::error::Error for FitError {}
