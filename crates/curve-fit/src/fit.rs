//! The constrained least-squares fit.

use crate::ends::{Elimination, EndConditions};
use crate::error::FitError;
use crate::space::{SplineSpace, ORDER};
use crate::triangle::Triangle;

/// A diagonal entry of the factor this much smaller than its column means that the points do not determine the unknown.
const SMALLEST_PIVOT: f64 = 1e-8;

/// A fitted spline and what its uncertainty follows from.
///
/// With observations of variance `σ²/weight` and prescribed numbers of covariance F, the coefficients have covariance
/// `σ² C + S F Sᵀ`.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Coefficients of the clamped basis.
    pub coefficients: Vec<f64>,
    /// C within its band: `[i][k]` stands for coefficients i and i + k. That is all a value or slope at one point needs.
    pub covariance_band: Vec<[f64; ORDER]>,
    /// S: change of coefficient i with prescribed number m (start value, start slope, end value, end slope; those given).
    pub sensitivity: Vec<[f64; 4]>,
    /// How many columns of `sensitivity` are in use.
    pub conditions: usize,
    /// Diagonal of the hat matrix: change of the fitted value at a point with the observation there. The error of a
    /// prediction from the other points is residual / (1 − leverage).
    pub leverages: Vec<f64>,
}

/// Minimizes `Σ wᵢ (Σⱼ cⱼ Bⱼ(xᵢ) − yᵢ)²` over the splines of `space` that meet `ends` exactly.
///
/// `points` ascend within the interval; `weights` may be empty for equal weights.
pub fn fit(
    space: &SplineSpace,
    points: &[f64],
    values: &[f64],
    weights: &[f64],
    ends: &EndConditions,
) -> Result<Fit, FitError> {
    check(space, points, values, weights)?;
    let elimination = Elimination::new(space, ends)?;
    let rows = Rows::new(space, points);
    let mut system = System::new(&elimination);
    for (i, row) in rows.0.iter().enumerate() {
        system.include(row, weights.get(i).copied().unwrap_or(1.0), values[i]);
    }
    system.check_rank(space)?;
    let unknowns = system.triangle.solve();
    let covariance_band = system.covariance_band();
    let leverages = rows.leverages(&covariance_band, weights);
    Ok(Fit {
        coefficients: elimination.coefficients(&unknowns),
        covariance_band,
        sensitivity: system.sensitivity(),
        conditions: elimination.prescribed.len(),
        leverages,
    })
}

fn check(
    space: &SplineSpace,
    points: &[f64],
    values: &[f64],
    weights: &[f64],
) -> Result<(), FitError> {
    let weights_fit = weights.is_empty() || weights.len() == points.len();
    if values.len() != points.len() || !weights_fit {
        let other = if weights_fit {
            values.len()
        } else {
            weights.len()
        };
        return Err(FitError::Shape {
            points: points.len(),
            other,
        });
    }
    let mut last = f64::NEG_INFINITY;
    for (index, (&point, &value)) in points.iter().zip(values).enumerate() {
        if !(point.is_finite() && value.is_finite()) {
            return Err(FitError::NotFinite { index });
        }
        if !(0.0..=space.length()).contains(&point) {
            return Err(FitError::Outside { index, point });
        }
        if point < last {
            return Err(FitError::Unordered { index, point });
        }
        last = point;
    }
    match weights
        .iter()
        .position(|weight| !(weight.is_finite() && *weight > 0.0))
    {
        Some(index) => Err(FitError::Weight {
            index,
            weight: weights[index],
        }),
        None => Ok(()),
    }
}

/// One row of the design matrix without its slopes.
#[derive(Clone, Copy)]
struct Row {
    first: usize,
    values: [f64; ORDER],
}

struct Rows(Vec<Row>);

impl Rows {
    fn new(space: &SplineSpace, points: &[f64]) -> Self {
        let mut index = space.degree();
        let mut piece = space.on_piece(index);
        let rows = points.iter().map(|&point| {
            let next = space.advance(index, point);
            if next != index {
                index = next;
                piece = space.on_piece(index);
            }
            Row {
                first: piece.first,
                values: piece.values(point),
            }
        });
        Self(rows.collect())
    }

    /// `hᵢ = wᵢ bᵢᵀ C bᵢ`.
    fn leverages(&self, band: &[[f64; ORDER]], weights: &[f64]) -> Vec<f64> {
        let leverage = |(i, row): (usize, &Row)| {
            let mut sum = 0.0;
            for (a, entries) in band.iter().skip(row.first).take(ORDER).enumerate() {
                let upper: f64 = entries
                    .iter()
                    .zip(&row.values[a..])
                    .map(|(c, b)| c * b)
                    .sum();
                sum += row.values[a] * (2.0 * upper - entries[0] * row.values[a]);
            }
            sum * weights.get(i).copied().unwrap_or(1.0)
        };
        self.0.iter().enumerate().map(leverage).collect()
    }
}

#[inline]
fn add_scaled(sum: &mut [f64; 4], factor: f64, terms: &[f64; 4]) {
    for (entry, term) in sum.iter_mut().zip(terms) {
        *entry += factor * term;
    }
}

/// The banded system of the free unknowns.
struct System<'a> {
    elimination: &'a Elimination,
    triangle: Triangle,
    /// `AᵀW(A shift)`: how the prescribed numbers pull at the unknowns.
    pull: Vec<[f64; 4]>,
    /// Squared length of each column.
    column: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(elimination: &'a Elimination) -> Self {
        let n = elimination.unknowns;
        Self {
            elimination,
            triangle: Triangle::new(n),
            pull: vec![[0.0; 4]; n],
            column: vec![0.0; n],
        }
    }

    #[inline]
    fn include(&mut self, row: &Row, weight: f64, value: f64) {
        let mut first = None;
        let mut entries = [0.0; ORDER];
        let mut shift = [0.0; 4];
        let mut shifted = false;
        let near = self
            .elimination
            .free
            .iter()
            .zip(&self.elimination.shift)
            .skip(row.first);
        for ((free, by), b) in near.zip(row.values) {
            if let Some(unknown) = *free {
                let first = *first.get_or_insert(unknown);
                entries[unknown - first] += b;
            }
            if *by != [0.0; 4] {
                shifted = true;
                add_scaled(&mut shift, b, by);
            }
        }
        let Some(first) = first else { return };
        for (k, entry) in entries.iter().enumerate().take(self.column.len() - first) {
            self.column[first + k] += weight * entry * entry;
        }
        let mut rest = value;
        if shifted {
            rest -= shift
                .iter()
                .zip(&self.elimination.prescribed)
                .map(|(a, b)| a * b)
                .sum::<f64>();
            for (k, entry) in entries.iter().enumerate().take(self.column.len() - first) {
                add_scaled(&mut self.pull[first + k], weight * entry, &shift);
            }
        }
        self.triangle.include(first, entries, weight, rest);
    }

    fn check_rank(&self, space: &SplineSpace) -> Result<(), FitError> {
        let limit = SMALLEST_PIVOT * SMALLEST_PIVOT;
        for (unknown, &column) in self.column.iter().enumerate() {
            let pivot = self.triangle.diagonal(unknown);
            if pivot.is_nan() || pivot <= limit * column {
                let free = &self.elimination.free;
                let coefficient = free.iter().position(|f| *f == Some(unknown)).unwrap_or(0);
                let (from, to) = space.support(coefficient);
                return Err(FitError::Undetermined {
                    coefficient,
                    from,
                    to,
                });
            }
        }
        Ok(())
    }

    /// The band of the unknowns' inverse, spread over the coefficients.
    fn covariance_band(&self) -> Vec<[f64; ORDER]> {
        let inverse = self.triangle.inverse_band();
        let free = &self.elimination.free;
        let entry = |i: usize, k: usize| match (free[i], free.get(i + k).copied().flatten()) {
            (Some(a), Some(b)) => inverse[a][b - a],
            _ => 0.0,
        };
        let row = |i: usize| std::array::from_fn(|k| entry(i, k));
        (0..free.len()).map(row).collect()
    }

    /// `S = shift − (AᵀWA)⁻¹ AᵀW(A shift)` on the free unknowns.
    fn sensitivity(&self) -> Vec<[f64; 4]> {
        let mut sensitivity = self.elimination.shift.clone();
        for m in 0..self.elimination.prescribed.len() {
            let mut response: Vec<f64> = self.pull.iter().map(|pull| -pull[m]).collect();
            self.triangle.solve_normal(&mut response);
            for (row, free) in sensitivity.iter_mut().zip(&self.elimination.free) {
                if let Some(unknown) = *free {
                    row[m] += response[unknown];
                }
            }
        }
        sensitivity
    }
}
