//! A banded triangular factor, grown row by row.

use crate::space::{MAX_DEGREE, ORDER};

/// `AᵀWA = RᵀDR` with R unit upper triangular and `MAX_DEGREE` entries right of its diagonal.
///
/// Rows of A come in order of their first column and are rotated in by Gentleman's square-root-free Givens rotations
/// (W. M. Gentleman, J. Inst. Maths Applics 12, 1973): the accuracy of an orthogonal factorization of A, one division a
/// rotation, at most `ORDER` rotations a row.
#[derive(Clone, Debug)]
pub(crate) struct Triangle {
    diagonal: Vec<f64>,
    right: Vec<[f64; MAX_DEGREE]>,
    rotated: Vec<f64>,
}

impl Triangle {
    pub(crate) fn new(unknowns: usize) -> Self {
        Self {
            diagonal: vec![0.0; unknowns],
            right: vec![[0.0; MAX_DEGREE]; unknowns],
            rotated: vec![0.0; unknowns],
        }
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
        let rows = self
            .diagonal
            .iter_mut()
            .zip(&mut self.right)
            .zip(&mut self.rotated);
        for ((diagonal, right), rotated) in rows.skip(first) {
            let [lead, rest @ ..] = row;
            let before = *diagonal;
            if lead != 0.0 {
                let weighted = weight * lead;
                let after = before + weighted * lead;
                let reciprocal = 1.0 / after;
                let (cosine, sine) = (before * reciprocal, weighted * reciprocal);
                *diagonal = after;
                weight *= cosine;
                let mut next = [0.0; ORDER];
                for k in 0..MAX_DEGREE {
                    next[k] = rest[k] - lead * right[k];
                    right[k] = cosine * right[k] + sine * rest[k];
                }
                let old = *rotated;
                *rotated = cosine * old + sine * value;
                value -= lead * old;
                row = next;
            } else {
                row = [rest[0], rest[1], rest[2], 0.0];
            }
            if weight == 0.0 || row == [0.0; ORDER] {
                return;
            }
        }
    }

    /// Squared diagonal entry of the factor.
    pub(crate) fn diagonal(&self, row: usize) -> f64 {
        self.diagonal[row]
    }

    /// Unknowns that minimize the weighted sum of squares.
    pub(crate) fn solve(&self) -> Vec<f64> {
        let mut unknowns = self.rotated.clone();
        self.back_substitute(&mut unknowns);
        unknowns
    }

    /// `AᵀWA x = b`, in place.
    pub(crate) fn solve_normal(&self, b: &mut [f64]) {
        for i in 0..b.len() {
            let known = b[i];
            for (k, r) in self.right[i].iter().enumerate() {
                if let Some(entry) = b.get_mut(i + 1 + k) {
                    *entry -= r * known;
                }
            }
        }
        for (entry, d) in b.iter_mut().zip(&self.diagonal) {
            *entry /= d;
        }
        self.back_substitute(b);
    }

    fn back_substitute(&self, x: &mut [f64]) {
        for i in (0..x.len()).rev() {
            let mut sum = x[i];
            for (r, known) in self.right[i].iter().zip(x.iter().skip(i + 1)) {
                sum -= r * known;
            }
            x[i] = sum;
        }
    }

    /// The entries of `(AᵀWA)⁻¹` within the band: `[i][k]` stands for row i, column i + k.
    ///
    /// `C = D⁻¹R⁻ᵀ + (I − R) C`, from the last row up (Takahashi's recursion): the full inverse is never formed.
    pub(crate) fn inverse_band(&self) -> Vec<[f64; ORDER]> {
        let n = self.diagonal.len();
        let mut band = vec![[0.0; ORDER]; n];
        for i in (0..n).rev() {
            let width = MAX_DEGREE.min(n - 1 - i);
            let mut row = [0.0; ORDER];
            for j in (0..=width).rev() {
                let mut sum = if j == 0 { 1.0 / self.diagonal[i] } else { 0.0 };
                for k in 1..=width {
                    let known = if k <= j {
                        band[i + k][j - k]
                    } else if j == 0 {
                        row[k]
                    } else {
                        band[i + j][k - j]
                    };
                    sum -= self.right[i][k - 1] * known;
                }
                row[j] = sum;
            }
            band[i] = row;
        }
        band
    }
}
