//! Points as columns, and what cannot be worked with.

use std::fmt;

/// Points in space, a column a coordinate.
#[derive(Clone, Debug)]
pub struct Points {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) z: Vec<f64>,
}

/// Why a sum was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// A coordinate or value that is no finite number.
    Value {
        /// Which point.
        index: usize,
    },
    /// Columns of unequal length.
    Lengths {
        /// Length expected.
        points: usize,
        /// Length found.
        found: usize,
    },
    /// An exponent that is not positive.
    Exponent {
        /// The exponent.
        exponent: f64,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value { index } => {
                write!(f, "point {index} has a value that is no finite number")
            }
            Self::Lengths { points, found } => write!(f, "{found} values for {points} points"),
            Self::Exponent { exponent } => write!(f, "the exponent {exponent} is not positive"),
        }
    }
}

impl std::error::Error for Refused {}

impl Points {
    /// From rows of x, y, z.
    pub fn new(rows: &[[f64; 3]]) -> Result<Self, Refused> {
        finite(rows.iter().map(|row| row.iter().sum()))?;
        let column = |axis: usize| rows.iter().map(|row| row[axis]).collect();
        Ok(Self {
            x: column(0),
            y: column(1),
            z: column(2),
        })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }
}

/// Refuses values that are no finite numbers.
pub(crate) fn finite(values: impl Iterator<Item = f64>) -> Result<(), Refused> {
    match values.enumerate().find(|(_, value)| !value.is_finite()) {
        Some((index, _)) => Err(Refused::Value { index }),
        None => Ok(()),
    }
}
