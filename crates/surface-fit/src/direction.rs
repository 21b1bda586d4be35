//! One direction of the grid: its basis at the points, and the factor of its normal matrix.

use std::fmt;

use curve_fit::{BasisRow, Side, SplineSpace, ORDER};

/// Why a fit was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// A point outside the interval, or no number.
    Place {
        /// Which point of the direction.
        index: usize,
        /// Where it is.
        at: f64,
    },
    /// Too few points near a coefficient to determine it.
    Points {
        /// Which coefficient of the direction.
        coefficient: usize,
    },
    /// As many values as the grid has points are needed.
    Shape {
        /// Points of the first direction.
        rows: usize,
        /// Points of the second direction.
        columns: usize,
        /// Values given.
        values: usize,
    },
    /// A value that is no finite number.
    Value {
        /// Which value, row by row.
        index: usize,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Place { index, at } => {
                write!(f, "point {index} at {at} lies outside the interval")
            }
            Self::Points { coefficient } => {
                write!(f, "no points near coefficient {coefficient} determine it")
            }
            Self::Shape {
                rows,
                columns,
                values,
            } => write!(
                f,
                "{values} values for a grid of {rows} by {columns} points"
            ),
            Self::Value { index } => write!(f, "value {index} is no finite number"),
        }
    }
}

impl std::error::Error for Refused {}

/// A pivot below this share of its diagonal entry is rounding: the cubic basis itself stays above 1e-4.
const SINGULAR: f64 = 1e-12;

/// The basis at the points of one direction, with `BᵀB = LDLᵀ`, banded.
///
/// The normal equations are safe here: the condition number of a B-spline basis depends on its degree alone, for
/// degree 3 it is below 30 wherever points and coefficients interlace, and where they do not the pivots say so.
#[derive(Clone, Debug)]
pub struct Direction {
    rows: Vec<BasisRow>,
    /// Reciprocal pivots.
    pivots: Vec<f64>,
    /// `lower[i][k]`: entry of L in row i + 1 + k, column i.
    lower: Vec<[f64; ORDER - 1]>,
}

impl Direction {
    /// The points may come in any order, within the space's interval.
    pub fn new(space: &SplineSpace, at: &[f64]) -> Result<Self, Refused> {
        let inside = |point: f64| (0.0..=space.length()).contains(&point);
        if let Some(index) = at.iter().position(|&point| !inside(point)) {
            let at = at.get(index).copied().unwrap_or(f64::NAN);
            return Err(Refused::Place { index, at });
        }
        let rows: Vec<BasisRow> = at
            .iter()
            .map(|&point| space.row(point, space.piece(point, Side::After)))
            .collect();
        let (pivots, lower) = factored(normal_matrix(&rows, space.dimension()))?;
        Ok(Self {
            rows,
            pivots,
            lower,
        })
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.rows.len()
    }

    /// Number of coefficients.
    pub fn unknowns(&self) -> usize {
        self.pivots.len()
    }

    /// The basis at each point.
    pub fn rows(&self) -> impl Iterator<Item = &BasisRow> {
        self.rows.iter()
    }

    /// `B⁺Z` for a matrix Z of so many columns, a row a point.
    pub(crate) fn reduced(&self, matrix: &[f64], columns: usize) -> Vec<f64> {
        let mut sums = vec![0.0; self.unknowns() * columns];
        if columns == 0 {
            return sums;
        }
        for (row, values) in self.rows.iter().zip(matrix.chunks_exact(columns)) {
            let targets = sums.chunks_exact_mut(columns).skip(row.first);
            for (target, &factor) in targets.zip(&row.values) {
                add(target, factor, values);
            }
        }
        self.solve(&mut sums, columns);
        sums
    }

    fn solve(&self, sums: &mut [f64], columns: usize) {
        for (i, below) in self.lower.iter().enumerate() {
            let (known, rest) = sums.split_at_mut((i + 1) * columns);
            let known = &known[i * columns..];
            for (target, &factor) in rest.chunks_exact_mut(columns).zip(below) {
                add(target, -factor, known);
            }
        }
        for (i, (below, pivot)) in self.lower.iter().zip(&self.pivots).enumerate().rev() {
            let (wanted, known) = sums.split_at_mut((i + 1) * columns);
            let wanted = &mut wanted[i * columns..];
            wanted.iter_mut().for_each(|entry| *entry *= pivot);
            for (known, &factor) in known.chunks_exact(columns).zip(below) {
                add(wanted, -factor, known);
            }
        }
    }
}

#[inline]
fn add(target: &mut [f64], factor: f64, values: &[f64]) {
    for (entry, value) in target.iter_mut().zip(values) {
        *entry += factor * value;
    }
}

/// `[i][k]`: entry in row i, column i + k.
fn normal_matrix(rows: &[BasisRow], unknowns: usize) -> Vec<[f64; ORDER]> {
    let mut band = vec![[0.0; ORDER]; unknowns];
    for row in rows {
        for (a, (entries, left)) in band.iter_mut().skip(row.first).zip(row.values).enumerate() {
            for (entry, right) in entries.iter_mut().zip(row.values.iter().skip(a)) {
                *entry += left * right;
            }
        }
    }
    band
}

type Factor = (Vec<f64>, Vec<[f64; ORDER - 1]>);

fn factored(mut band: Vec<[f64; ORDER]>) -> Result<Factor, Refused> {
    let (mut pivots, mut lower) = (Vec::new(), Vec::new());
    let largest: Vec<f64> = band.iter().map(|entries| entries[0]).collect();
    for (coefficient, diagonal) in largest.into_iter().enumerate() {
        let (done, rest) = band.split_at_mut(coefficient + 1);
        let entries = done[coefficient];
        if entries[0] <= SINGULAR * diagonal {
            return Err(Refused::Points { coefficient });
        }
        let reciprocal = 1.0 / entries[0];
        let below = [entries[1], entries[2], entries[3]].map(|entry| entry * reciprocal);
        for (k, (target, factor)) in rest.iter_mut().zip(below).enumerate() {
            for (entry, other) in target.iter_mut().zip(entries.iter().skip(k + 1)) {
                *entry -= factor * other;
            }
        }
        pivots.push(reciprocal);
        lower.push(below);
    }
    Ok((pivots, lower))
}
