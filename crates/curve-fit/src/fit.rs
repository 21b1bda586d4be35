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
    /// Value less spline at each point.
    pub residuals: Vec<f64>,
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
    let coefficients = elimination.coefficients(&unknowns);
    Ok(Fit {
        residuals: rows.residuals(&coefficients, values),
        coefficients,
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

    fn residuals(&self, coefficients: &[f64], values: &[f64]) -> Vec<f64> {
        let residual = |(row, value): (&Row, &f64)| {
            let near = coefficients[row.first..].iter().zip(row.values);
            value - near.map(|(c, b)| c * b).sum::<f64>()
        };
        self.0.iter().zip(values).map(residual).collect()
    }

    /// `hᵢ = wᵢ bᵢᵀ C bᵢ`.
    fn leverages(&self, band: &[[f64; ORDER]], weights: &[f64]) -> Vec<f64> {
        let leverage = |(i, row): (usize, &Row)| {
            let weight = weights.get(i).copied().unwrap_or(1.0);
            weight * quadratic_form(&band[row.first..], &row.values)
        };
        self.0.iter().enumerate().map(leverage).collect()
    }
}

/// `bᵀ C b` with the band of a symmetric C from b's first entry on.
#[inline]
fn quadratic_form(band: &[[f64; ORDER]], b: &[f64; ORDER]) -> f64 {
    let mut sum = 0.0;
    for (a, entries) in band.iter().take(ORDER).enumerate() {
        let mut beside = 0.0;
        for k in 1..ORDER - a {
            beside += entries[k] * b[a + k];
        }
        sum += b[a] * (entries[0] * b[a] + 2.0 * beside);
    }
    sum
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
    /// `−AᵀW(A shift)`: how the prescribed numbers pull at the unknowns.
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
        if self.elimination.plain.contains(&row.first) {
            let first = row.first - self.elimination.before;
            self.rotate_in(first, row.values, weight, value);
        } else {
            self.include_near_an_end(row, weight, value);
        }
    }

    #[inline]
    fn rotate_in(&mut self, first: usize, entries: [f64; ORDER], weight: f64, value: f64) {
        for (column, entry) in self.column.iter_mut().skip(first).zip(entries) {
            *column += weight * entry * entry;
        }
        self.triangle.include(first, entries, weight, value);
    }

    /// A row some of whose coefficients are prescribed, or tied to their neighbour.
    fn include_near_an_end(&mut self, row: &Row, weight: f64, value: f64) {
        let mut first = None;
        let mut entries = [0.0; ORDER];
        let mut shift = [0.0; 4];
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
            add_scaled(&mut shift, b, by);
        }
        let Some(first) = first else { return };
        for (pull, entry) in self.pull.iter_mut().skip(first).zip(entries) {
            add_scaled(pull, -weight * entry, &shift);
        }
        let known: f64 = shift
            .iter()
            .zip(&self.elimination.prescribed)
            .map(|(a, b)| a * b)
            .sum();
        self.rotate_in(first, entries, weight, value - known);
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
        if self.elimination.prescribed.is_empty() {
            return sensitivity;
        }
        let mut response = self.pull.clone();
        self.triangle.solve_normal(&mut response);
        for (row, free) in sensitivity.iter_mut().zip(&self.elimination.free) {
            if let Some(unknown) = *free {
                add_scaled(row, 1.0, &response[unknown]);
            }
        }
        sensitivity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH: f64 = 4.0;

    fn cubic(s: f64) -> f64 {
        1.0 - 2.0 * s + 0.5 * s * s - 0.25 * s * s * s
    }

    fn points(n: usize) -> Vec<f64> {
        (0..n)
            .map(|i| LENGTH * (i as f64 + 0.5) / n as f64)
            .collect()
    }

    fn value(space: &SplineSpace, fitted: &Fit, point: f64) -> f64 {
        let row = space.row(point, space.piece(point, crate::Side::After));
        let near = fitted.coefficients.iter().skip(row.first);
        near.zip(row.values).map(|(c, b)| c * b).sum()
    }

    #[test]
    fn a_cubic_is_reproduced_under_any_of_its_own_end_conditions() {
        let space = SplineSpace::new(&[1.0, 1.5, 3.0], LENGTH, 3).unwrap();
        let s = points(12);
        let y: Vec<f64> = s.iter().map(|&s| cubic(s)).collect();
        for mask in 0..16 {
            let given = |bit: usize, number: f64| (mask >> bit & 1 == 1).then_some(number);
            let ends = EndConditions {
                start_value: given(0, 1.0),
                start_slope: given(1, -2.0),
                end_value: given(2, cubic(LENGTH)),
                end_slope: given(3, -2.0 + LENGTH - 0.75 * LENGTH * LENGTH),
            };
            let fitted = fit(&space, &s, &y, &[], &ends).unwrap();
            for step in 0..=40 {
                let at = LENGTH * f64::from(step) / 40.0;
                assert!(
                    (value(&space, &fitted, at) - cubic(at)).abs() < 1e-13,
                    "mask {mask} at {at}"
                );
            }
            let unknowns = fitted.coefficients.len() - fitted.conditions;
            assert!((fitted.leverages.iter().sum::<f64>() - unknowns as f64).abs() < 1e-12);
        }
    }

    #[test]
    fn weights_count_like_repeated_points() {
        let space = SplineSpace::new(&[2.0], LENGTH, 3).unwrap();
        let y: Vec<f64> = (0..8).map(|i| f64::from(i * i % 5)).collect();
        let weights = [1.0, 2.0, 1.0, 1.0, 3.0, 1.0, 1.0, 1.0];
        let weighted = fit(&space, &points(8), &y, &weights, &EndConditions::default()).unwrap();
        let repeat = |values: &[f64]| -> Vec<f64> {
            values
                .iter()
                .zip(weights)
                .flat_map(|(v, w)| vec![*v; w as usize])
                .collect()
        };
        let repeated = fit(
            &space,
            &repeat(&points(8)),
            &repeat(&y),
            &[],
            &EndConditions::default(),
        )
        .unwrap();
        for (a, b) in weighted.coefficients.iter().zip(&repeated.coefficients) {
            assert!((a - b).abs() < 1e-12);
        }
    }

    /// The fit is linear: what is reported of it must be what a second fit with one number changed by 1 gives.
    #[test]
    fn residuals_leverages_covariance_and_sensitivity_are_those_of_second_fits() {
        let space = SplineSpace::new(&[1.0, 1.5, 3.0], LENGTH, 3).unwrap();
        let s = points(12);
        let y: Vec<f64> = (0..12).map(|i| f64::from(i * i % 7)).collect();
        let weights: Vec<f64> = (0..12).map(|i| 0.5 + f64::from(i * 5 % 3)).collect();
        for mask in 0..16 {
            let ends_with = |numbers: [f64; 4]| {
                let given = |bit: usize| (mask >> bit & 1 == 1).then_some(numbers[bit]);
                EndConditions {
                    start_value: given(0),
                    start_slope: given(1),
                    end_value: given(2),
                    end_slope: given(3),
                }
            };
            let numbers = [0.3, -0.2, 1.5, 0.7];
            let ends = ends_with(numbers);
            let base = fit(&space, &s, &y, &weights, &ends).unwrap();
            let n = base.coefficients.len();
            let change = |other: &Fit| -> Vec<f64> {
                let pairs = other.coefficients.iter().zip(&base.coefficients);
                pairs.map(|(a, b)| a - b).collect()
            };
            let mut covariance = vec![[0.0; ORDER]; n];
            for i in 0..s.len() {
                let mut nudged = y.clone();
                nudged[i] += 1.0;
                let other = fit(&space, &s, &nudged, &weights, &ends).unwrap();
                let fitted = value(&space, &base, s[i]);
                assert!((base.residuals[i] - (y[i] - fitted)).abs() < 1e-12);
                let moved = value(&space, &other, s[i]) - fitted;
                assert!((base.leverages[i] - moved).abs() < 1e-12, "mask {mask}");
                let by = change(&other);
                for (row, entries) in covariance.iter_mut().enumerate() {
                    for (k, entry) in entries.iter_mut().enumerate() {
                        *entry += by[row] * by.get(row + k).unwrap_or(&0.0) / weights[i];
                    }
                }
            }
            for (found, expected) in base.covariance_band.iter().zip(&covariance) {
                for (a, b) in found.iter().zip(expected) {
                    assert!((a - b).abs() < 1e-11, "mask {mask}: {a} {b}");
                }
            }
            let given: Vec<usize> = (0..4).filter(|bit| mask >> bit & 1 == 1).collect();
            assert_eq!(base.conditions, given.len());
            for (column, &bit) in given.iter().enumerate() {
                let mut nudged = numbers;
                nudged[bit] += 1.0;
                let other = fit(&space, &s, &y, &weights, &ends_with(nudged)).unwrap();
                for (row, by) in base.sensitivity.iter().zip(change(&other)) {
                    assert!((row[column] - by).abs() < 1e-11, "mask {mask}");
                }
            }
        }
    }

    #[test]
    fn a_prescribed_slope_is_that_of_the_spline_whatever_its_degree() {
        let (s, y) = (points(9), [0.0, 3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0]);
        for degree in 1..=3 {
            let space = SplineSpace::new(&[1.0, 2.5], LENGTH, degree).unwrap();
            for given in [None, Some(0.5)] {
                let ends = EndConditions {
                    start_value: given,
                    start_slope: Some(-0.75),
                    end_value: given,
                    end_slope: Some(1.25),
                };
                let fitted = fit(&space, &s, &y, &[], &ends).unwrap();
                for (at, slope) in [(0.0, -0.75), (LENGTH, 1.25)] {
                    let row = space.row(at, space.piece(at, crate::Side::After));
                    let near = fitted.coefficients.iter().skip(row.first);
                    let found: f64 = near.zip(row.slopes).map(|(c, b)| c * b).sum();
                    assert!((found - slope).abs() < 1e-12, "degree {degree}: {found}");
                    let there = given.map_or(0.0, |v| value(&space, &fitted, at) - v);
                    assert!(there.abs() < 1e-12);
                }
            }
        }
    }

    /// Relative to the points' own weight: two points of a line 1 nm apart on 4 mm do not determine it, 1 µm do.
    #[test]
    fn what_the_points_determine_does_not_depend_on_the_size_of_their_weights() {
        let line = SplineSpace::new(&[], LENGTH, 1).unwrap();
        for weight in [1e-20, 1.0, 1e20] {
            let by = |apart: f64| {
                let weights = [weight; 2];
                let points = [2.0, 2.0 + apart];
                fit(
                    &line,
                    &points,
                    &[0.0; 2],
                    &weights,
                    &EndConditions::default(),
                )
            };
            assert!(by(1e-3).is_ok());
            assert_eq!(by(1e-9).unwrap_err().kind(), "undetermined");
        }
    }

    #[test]
    fn no_points_are_needed_when_the_ends_say_all() {
        let space = SplineSpace::new(&[], LENGTH, 3).unwrap();
        let ends = EndConditions {
            start_value: Some(0.0),
            start_slope: Some(1.0),
            end_value: Some(4.0),
            end_slope: Some(1.0),
        };
        let fitted = fit(&space, &[], &[], &[], &ends).unwrap();
        assert!((value(&space, &fitted, 1.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_cannot_be_fitted_is_refused_with_its_kind() {
        let space = SplineSpace::new(&[2.0], LENGTH, 3).unwrap();
        let free = EndConditions::default();
        let kind = |points: &[f64], values: &[f64], weights: &[f64], ends: &EndConditions| {
            fit(&space, points, values, weights, ends)
                .unwrap_err()
                .kind()
        };
        assert_eq!(kind(&[1.0], &[], &[], &free), "shape");
        assert_eq!(kind(&[1.0], &[f64::NAN], &[], &free), "not-finite");
        assert_eq!(kind(&[5.0], &[0.0], &[], &free), "outside");
        assert_eq!(kind(&[2.0, 1.0], &[0.0, 0.0], &[], &free), "unordered");
        assert_eq!(kind(&[1.0], &[0.0], &[-1.0], &free), "weight");
        assert_eq!(kind(&[1.0], &[0.0], &[0.0], &free), "weight");
        assert_eq!(
            kind(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6], &[0.0; 6], &[], &free),
            "undetermined"
        );
        let line = SplineSpace::new(&[], LENGTH, 1).unwrap();
        let slopes = EndConditions {
            start_slope: Some(0.0),
            end_slope: Some(0.0),
            ..free
        };
        assert_eq!(
            fit(&line, &[1.0], &[0.0], &[], &slopes).unwrap_err().kind(),
            "too-many-conditions"
        );
        let steps = SplineSpace::new(&[2.0], LENGTH, 0).unwrap();
        let slope = EndConditions {
            end_slope: Some(0.0),
            ..free
        };
        assert_eq!(
            fit(&steps, &[1.0, 3.0], &[0.0; 2], &[], &slope)
                .unwrap_err()
                .kind(),
            "too-many-conditions"
        );
    }
}
