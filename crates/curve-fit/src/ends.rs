//! End conditions and their exact elimination.

use crate::error::FitError;
use crate::space::SplineSpace;
use std::ops::Range;

/// Value and slope prescribed at either end; `None` leaves it free.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EndConditions {
    /// Value at 0.
    pub start_value: Option<f64>,
    /// Slope at 0.
    pub start_slope: Option<f64>,
    /// Value at the end.
    pub end_value: Option<f64>,
    /// Slope at the end.
    pub end_slope: Option<f64>,
}

impl EndConditions {
    /// The prescribed numbers, in the order start value, start slope, end value, end slope.
    pub fn prescribed(&self) -> Vec<f64> {
        [
            self.start_value,
            self.start_slope,
            self.end_value,
            self.end_slope,
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

/// How the coefficients follow from the free unknowns and the prescribed numbers:
/// `c_i = u[free[i]] + Σ_m shift[i][m] f_m`.
#[derive(Clone, Debug)]
pub(crate) struct Elimination {
    pub(crate) free: Vec<Option<usize>>,
    pub(crate) unknowns: usize,
    pub(crate) shift: Vec<[f64; 4]>,
    pub(crate) prescribed: Vec<f64>,
    /// First coefficients of the rows that no elimination touches, and by how much they are ahead of their unknowns.
    pub(crate) plain: Range<usize>,
    pub(crate) before: usize,
}

impl Elimination {
    pub(crate) fn new(space: &SplineSpace, ends: &EndConditions) -> Result<Self, FitError> {
        let n = space.dimension();
        let needed =
            reach(ends.start_value, ends.start_slope) + reach(ends.end_value, ends.end_slope);
        let sloped = ends.start_slope.is_some() || ends.end_slope.is_some();
        if needed > n || (sloped && space.degree() == 0) {
            return Err(FitError::TooManyConditions {
                needed,
                coefficients: n,
            });
        }
        let prescribed = ends.prescribed();
        if let Some(index) = prescribed.iter().position(|value| !value.is_finite()) {
            return Err(FitError::NotFinite { index });
        }
        let mut found = Self {
            free: vec![Some(0); n],
            unknowns: 0,
            shift: vec![[0.0; 4]; n],
            prescribed,
            plain: 0..0,
            before: 0,
        };
        let mut column = 0;
        let start = End {
            outer: 0,
            inner: 1,
            step: space.start_step(),
        };
        found.eliminate(
            &start,
            ends.start_value.is_some(),
            ends.start_slope.is_some(),
            &mut column,
        );
        let end = End {
            outer: n - 1,
            inner: n.saturating_sub(2),
            step: -space.end_step(),
        };
        found.eliminate(
            &end,
            ends.end_value.is_some(),
            ends.end_slope.is_some(),
            &mut column,
        );
        found.number(ends);
        let start = reach(ends.start_value, ends.start_slope);
        let end = reach(ends.end_value, ends.end_slope);
        found.plain = start..(n - end).saturating_sub(space.degree());
        found.before = found
            .free
            .get(start)
            .copied()
            .flatten()
            .map_or(0, |unknown| start - unknown);
        Ok(found)
    }

    /// Outer coefficient = value; inner coefficient = outer + step · slope.
    fn eliminate(&mut self, end: &End, value: bool, slope: bool, column: &mut usize) {
        if value {
            self.free[end.outer] = None;
            self.shift[end.outer][*column] = 1.0;
            if slope {
                self.free[end.inner] = None;
                self.shift[end.inner][*column] = 1.0;
            }
            *column += 1;
        }
        if slope {
            self.shift[end.inner][*column] = end.step;
            *column += 1;
        }
    }

    /// Numbers the unknowns; where only the slope is prescribed, two coefficients share one.
    fn number(&mut self, ends: &EndConditions) {
        let n = self.free.len();
        let start_tied = ends.start_slope.is_some() && ends.start_value.is_none();
        let end_tied = ends.end_slope.is_some() && ends.end_value.is_none();
        for (i, free) in self.free.iter_mut().enumerate() {
            if free.is_none() {
                continue;
            }
            if (start_tied && i == 1) || (end_tied && i + 1 == n) {
                *free = self.unknowns.checked_sub(1);
            } else {
                *free = Some(self.unknowns);
                self.unknowns += 1;
            }
        }
    }

    /// Coefficients from the unknowns.
    pub(crate) fn coefficients(&self, unknowns: &[f64]) -> Vec<f64> {
        self.free
            .iter()
            .zip(&self.shift)
            .map(|(free, shift)| {
                let prescribed: f64 = shift.iter().zip(&self.prescribed).map(|(a, b)| a * b).sum();
                prescribed + free.map_or(0.0, |u| unknowns[u])
            })
            .collect()
    }
}

struct End {
    outer: usize,
    inner: usize,
    step: f64,
}

/// How many coefficients the conditions at one end take part in.
fn reach(value: Option<f64>, slope: Option<f64>) -> usize {
    match (value, slope) {
        (_, Some(_)) => 2,
        (Some(_), None) => 1,
        (None, None) => 0,
    }
}
