//! The weight matrix times a few vectors, the matrix never formed.

use crate::pairs::spread;
use crate::points::{finite, Points, Refused};
use crate::weight::{Exponent, Weight, WithWeight};

/// Rows worked off together.
const TILE: usize = 64;

/// What `product` gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Product {
    /// Σⱼ cᵢⱼ for each point.
    pub row_sums: Vec<f64>,
    /// C V, row by row.
    pub products: Vec<f64>,
}

/// `C V` with c = d^-k and zeros on the diagonal, for V of so many columns, row by row.
pub fn product(
    points: &Points,
    vectors: &[f64],
    columns: usize,
    exponent: Exponent,
) -> Result<Product, Refused> {
    if vectors.len() != points.len() * columns {
        return Err(Refused::Lengths {
            points: points.len() * columns,
            found: vectors.len(),
        });
    }
    finite(vectors.iter().copied())?;
    Ok(exponent.choose(Rows {
        points,
        vectors,
        columns,
    }))
}

#[derive(Clone, Copy)]
struct Rows<'a> {
    points: &'a Points,
    vectors: &'a [f64],
    columns: usize,
}

impl WithWeight for Rows<'_> {
    type Output = Product;

    fn call<W: Weight>(self, weight: W) -> Product {
        let starts: Vec<usize> = (0..self.points.len()).step_by(TILE).collect();
        let tiles = spread(&starts, |&start| {
            pulp::Arch::new().dispatch(Tile {
                of: self,
                start,
                weight,
            })
        });
        let mut all = Product::default();
        for part in tiles {
            all.row_sums.extend(part.row_sums);
            all.products.extend(part.products);
        }
        all
    }
}

struct Tile<'a, W> {
    of: Rows<'a>,
    start: usize,
    weight: W,
}

impl<W: Weight> pulp::NullaryFnOnce for Tile<'_, W> {
    type Output = Product;

    #[inline(always)]
    fn call(self) -> Product {
        let (points, columns) = (self.of.points, self.of.columns);
        let rows = self.start..(self.start + TILE).min(points.len());
        let mut part = Product {
            row_sums: Vec::with_capacity(rows.len()),
            products: vec![0.0; rows.len() * columns],
        };
        let mut weights = vec![0.0; points.len()];
        for (k, i) in rows.enumerate() {
            let (x, y, z) = (points.x[i], points.y[i], points.z[i]);
            let others = points.x.iter().zip(&points.y).zip(&points.z);
            for (weight, ((px, py), pz)) in weights.iter_mut().zip(others) {
                let (dx, dy, dz) = (x - px, y - py, z - pz);
                *weight = self.weight.of(dx * dx + dy * dy + dz * dz);
            }
            part.row_sums.push(weights.iter().sum());
            if columns == 0 {
                continue;
            }
            let sums = &mut part.products[k * columns..(k + 1) * columns];
            for (weight, vector) in weights.iter().zip(self.of.vectors.chunks_exact(columns)) {
                for (sum, entry) in sums.iter_mut().zip(vector) {
                    *sum += weight * entry;
                }
            }
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pairs::pair_sums;

    #[test]
    fn agrees_with_the_pair_sums() {
        let rows: Vec<[f64; 3]> = (0..200)
            .map(|k| [f64::from(k % 20), f64::from(k / 20), f64::from(k % 7) * 0.1])
            .collect();
        let values: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.37).sin()).collect();
        let points = Points::new(&rows).unwrap();
        let sums = pair_sums(&points, &values, Exponent::Two).unwrap();
        let found = product(&points, &values, 1, Exponent::Two).unwrap();
        let quadratic: f64 = found.products.iter().zip(&values).map(|(a, b)| a * b).sum();
        assert!((quadratic / sums.products - 1.0).abs() < 1e-12);
        assert!((found.row_sums.iter().sum::<f64>() / sums.weights - 1.0).abs() < 1e-12);
        assert!(product(&points, &values, 2, Exponent::Two).is_err());
    }
}
