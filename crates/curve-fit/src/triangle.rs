//! A banded triangular factor, grown row by row.

use crate::space::{MAX_DEGREE, ORDER};

/// `AᵀWA = RᵀDR` with R unit upper triangular and `MAX_DEGREE` entries right of its diagonal.
///
/// Rows of A come in order of their first column and are rotated in by Gentleman's square-root-free Givens rotations
/// (W. M. Gentleman, J. Inst. Maths Applics 12, 1973): the accuracy of an orthogonal factorization of A, one division a
/// rotation, at most `ORDER` rotations a row.
#[derive(Clone, Debug)]
pub(crate) struct Triangle(Vec<FactorRow>);

#[derive(Clone, Copy, Debug, Default)]
struct FactorRow {
    diagonal: f64,
    right: [f64; MAX_DEGREE],
    rotated: f64,
}

impl Triangle {
    pub(crate) fn new(unknowns: usize) -> Self {
        Self(vec![FactorRow::default(); unknowns])
    }

    /// Rotates in the row with entries from column `first` on, its weight and its right-hand side.
    #[inline]
    pub(crate) fn include(
        &mut self,
        first: usize,
        mut row: [f64; ORDER],
        mut weight: f64,
        mut value: f64,
    ) {
        for factor in self.0.iter_mut().skip(first).take(ORDER) {
            let [lead, rest @ ..] = row;
            let weighted = weight * lead;
            let after = factor.diagonal + weighted * lead;
            if after > 0.0 {
                let reciprocal = 1.0 / after;
                let (cosine, sine) = (factor.diagonal * reciprocal, weighted * reciprocal);
                for (k, entry) in rest.into_iter().enumerate() {
                    row[k] = entry - lead * factor.right[k];
                    factor.right[k] = cosine * factor.right[k] + sine * entry;
                }
                let old = factor.rotated;
                factor.rotated = cosine * old + sine * value;
                value -= lead * old;
                factor.diagonal = after;
                weight *= cosine;
            } else {
                row[..MAX_DEGREE].copy_from_slice(&rest);
            }
            row[MAX_DEGREE] = 0.0;
        }
    }

    /// Squared diagonal entry of the factor.
    pub(crate) fn diagonal(&self, row: usize) -> f64 {
        self.0[row].diagonal
    }

    /// Unknowns that minimize the weighted sum of squares.
    pub(crate) fn solve(&self) -> Vec<f64> {
        let mut unknowns: Vec<f64> = self.0.iter().map(|row| row.rotated).collect();
        let mut right_of = [0.0; MAX_DEGREE];
        for (row, unknown) in self.0.iter().zip(&mut unknowns).rev() {
            *unknown -= dot(&row.right, &right_of);
            right_of = [*unknown, right_of[0], right_of[1]];
        }
        unknowns
    }

    /// `AᵀWA X = B` for four right-hand sides at once, in place.
    pub(crate) fn solve_normal(&self, b: &mut [[f64; 4]]) {
        for (i, row) in self.0.iter().enumerate() {
            let known = b[i];
            for (r, below) in row.right.iter().zip(b.iter_mut().skip(i + 1)) {
                subtract(below, *r, &known);
            }
        }
        for (i, row) in self.0.iter().enumerate().rev() {
            let mut found = b[i].map(|entry| entry / row.diagonal);
            for (r, known) in row.right.iter().zip(b.iter().skip(i + 1)) {
                subtract(&mut found, *r, known);
            }
            b[i] = found;
        }
    }

    /// The entries of `(AᵀWA)⁻¹` within the band: `[i][k]` stands for row i, column i + k.
    ///
    /// `C = D⁻¹R⁻ᵀ + (I − R) C`, from the last row up (Takahashi's recursion): the full inverse is never formed.
    pub(crate) fn inverse_band(&self) -> Vec<[f64; ORDER]> {
        let mut band = vec![[0.0; ORDER]; self.0.len()];
        // The rows below the one in work, zero beyond the last.
        let mut below = [[0.0; ORDER]; MAX_DEGREE];
        for (row, entries) in self.0.iter().zip(&mut band).rev() {
            let [a, b, c] = below;
            let beside = [
                -dot(&row.right, &[a[0], a[1], a[2]]),
                -dot(&row.right, &[a[1], b[0], b[1]]),
                -dot(&row.right, &[a[2], b[1], c[0]]),
            ];
            let own = 1.0 / row.diagonal - dot(&row.right, &beside);
            *entries = [own, beside[0], beside[1], beside[2]];
            below = [*entries, a, b];
        }
        band
    }
}

#[inline]
fn dot(a: &[f64; MAX_DEGREE], b: &[f64; MAX_DEGREE]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn subtract(from: &mut [f64; 4], factor: f64, terms: &[f64; 4]) {
    for (entry, term) in from.iter_mut().zip(terms) {
        *entry -= factor * term;
    }
}
