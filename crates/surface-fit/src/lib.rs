//! Least-squares tensor-product splines on a grid of points, and what they need at points anywhere (`scattered`).
//!
//! On a grid the design matrix is the Kronecker product of those of the two directions, so the solution is
//! `C = Bu⁺ Z Bv⁺ᵀ`: one banded problem with many right-hand sides a direction (`direction`), and never a matrix of the
//! whole. The bases are those of `curve-fit`. Nothing here panics: every input is either fitted or refused.

mod direction;
mod scattered;

pub use direction::{Direction, Refused};
pub use scattered::Scattered;

/// Coefficients (rows: first direction) that fit `values`, row by row, in the least-squares sense.
pub fn fit_grid(u: &Direction, v: &Direction, values: &[f64]) -> Result<Vec<f64>, Refused> {
    if values.len() != u.points() * v.points() {
        return Err(Refused::Shape {
            rows: u.points(),
            columns: v.points(),
            values: values.len(),
        });
    }
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        return Err(Refused::Value { index });
    }
    let across = u.reduced(values, v.points());
    let turned = transposed(&across, u.unknowns(), v.points());
    let fitted = v.reduced(&turned, u.unknowns());
    Ok(transposed(&fitted, v.unknowns(), u.unknowns()))
}

/// The matrix with rows and columns exchanged, tile by tile.
fn transposed(matrix: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    const TILE: usize = 16;
    let mut turned = vec![0.0; matrix.len()];
    for top in (0..rows).step_by(TILE) {
        for left in (0..columns).step_by(TILE) {
            for row in top..(top + TILE).min(rows) {
                for column in left..(left + TILE).min(columns) {
                    turned[column * rows + row] = matrix[row * columns + column];
                }
            }
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use curve_fit::SplineSpace;

    fn direction(points: usize, unknowns: usize) -> Direction {
        let pieces = unknowns - 3;
        let knots: Vec<f64> = (1..pieces).map(|k| k as f64 / pieces as f64).collect();
        let at: Vec<f64> = (0..points)
            .map(|k| k as f64 / (points - 1) as f64)
            .collect();
        Direction::new(&SplineSpace::new(&knots, 1.0, 3).unwrap(), &at).unwrap()
    }

    #[test]
    fn a_cubic_is_met_exactly() {
        let (u, v) = (direction(25, 9), direction(31, 12));
        let f = |a: f64, b: f64| 3.0 - a * a * a + 2.0 * a * b * b - b * b * b;
        let values: Vec<f64> = (0..25)
            .flat_map(|i| (0..31).map(move |j| f(f64::from(i) / 24.0, f64::from(j) / 30.0)))
            .collect();
        let coefficients = fit_grid(&u, &v, &values).unwrap();
        for (i, row) in u.rows().enumerate() {
            for (j, column) in v.rows().enumerate() {
                let mut sum = 0.0;
                for (a, x) in row.values.iter().enumerate() {
                    for (b, y) in column.values.iter().enumerate() {
                        sum += x * y * coefficients[(row.first + a) * 12 + column.first + b];
                    }
                }
                assert!((sum - values[i * 31 + j]).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let space = SplineSpace::new(&[0.2, 0.4, 0.6, 0.8], 1.0, 3).unwrap();
        let clustered: Vec<f64> = (0..20).map(|k| f64::from(k) * 0.02).collect();
        assert!(matches!(
            Direction::new(&space, &clustered),
            Err(Refused::Points { .. })
        ));
        assert!(matches!(
            Direction::new(&space, &[0.5, f64::NAN]),
            Err(Refused::Place { index: 1, .. })
        ));
        let (u, v) = (direction(8, 5), direction(8, 5));
        assert!(matches!(
            fit_grid(&u, &v, &[0.0; 63]),
            Err(Refused::Shape { .. })
        ));
        assert_eq!(
            fit_grid(&u, &v, &[f64::INFINITY; 64]),
            Err(Refused::Value { index: 0 })
        );
    }
}
