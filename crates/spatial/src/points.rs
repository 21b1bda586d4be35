//! Points, and what cannot be worked with.

use std::fmt;

/// Points in space.
#[derive(Clone, Debug)]
pub struct Points {
    rows: Vec<[f64; 3]>,
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
    /// A least distance that is negative.
    Nearest {
        /// The distance.
        nearest: f64,
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
            Self::Nearest { nearest } => write!(f, "the least distance {nearest} is negative"),
        }
    }
}

impl std::error::Error for Refused {}

impl Points {
    /// From rows of x, y, z.
    pub fn new(rows: &[[f64; 3]]) -> Result<Self, Refused> {
        finite(rows.iter().map(|row| row.iter().sum()), 1)?;
        Ok(Self {
            rows: rows.to_vec(),
        })
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The points, one after the other.
    pub(crate) fn rows(&self) -> impl Iterator<Item = [f64; 3]> + Clone + '_ {
        self.rows.iter().copied()
    }

    /// One of them.
    pub(crate) fn at(&self, index: usize) -> [f64; 3] {
        self.rows[index]
    }

    /// Refuses so many values where `columns` a point are wanted.
    pub(crate) fn matches(&self, found: usize, columns: usize) -> Result<(), Refused> {
        let points = self.len() * columns;
        if found == points {
            Ok(())
        } else {
            Err(Refused::Lengths { points, found })
        }
    }
}

/// Refuses values, so many a point, that are no finite numbers.
pub(crate) fn finite(values: impl Iterator<Item = f64>, columns: usize) -> Result<(), Refused> {
    match values.enumerate().find(|(_, value)| !value.is_finite()) {
        Some((at, _)) => Err(Refused::Value {
            index: at / columns.max(1),
        }),
        None => Ok(()),
    }
}
