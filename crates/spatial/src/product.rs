//! The weight matrix times a few vectors, the matrix never formed.

use threads::spread;

use crate::block::Block;
use crate::lanes::Lanes;
use crate::points::{finite, Points, Refused};
use crate::weight::{Decay, Job, Weight};

/// Rows worked off together, and points with which, so that these stay in the cache.
const ROWS: usize = 64;
const OTHERS: usize = 1024;

/// `C V` with zeros on C's diagonal, for V of so many columns, row by row.
pub fn product(
    points: &Points,
    vectors: &[f64],
    columns: usize,
    decay: Decay,
) -> Result<Vec<f64>, Refused> {
    points.matches(vectors.len(), columns)?;
    finite(vectors.iter().copied(), columns)?;
    let rows: Vec<usize> = (0..points.len()).collect();
    Ok(rows_of_product(points, vectors, columns, decay, &rows))
}

fn rows_of_product(
    points: &Points,
    vectors: &[f64],
    columns: usize,
    decay: Decay,
    rows: &[usize],
) -> Vec<f64> {
    let indices: Vec<usize> = (0..points.len()).collect();
    let blocks: Vec<Block> = indices
        .chunks(OTHERS)
        .map(|some| Block::of(points, vectors, columns, some))
        .collect();
    let jobs: Vec<&[usize]> = rows.chunks(ROWS).collect();
    let own = decay.at_none();
    let tiles = spread(&jobs, |&some| {
        let places: Vec<[f64; 3]> = some.iter().map(|&row| points.at(row)).collect();
        let mut sums = vec![0.0; some.len() * columns];
        for block in &blocks {
            add(decay, block, &places, columns, &mut sums);
        }
        for (row, sums) in some.iter().zip(sums.chunks_exact_mut(columns.max(1))) {
            take_away(sums, own, &vectors[row * columns..]);
        }
        sums
    });
    tiles.concat()
}

/// Takes away what a point's own value was counted with; its rounding stays.
pub(crate) fn take_away(sums: &mut [f64], own: f64, values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum -= own * value;
    }
}

/// Adds to the sums (places × columns) what all points of a block weigh at the places.
pub(crate) fn add(
    decay: Decay,
    block: &Block,
    places: &[[f64; 3]],
    columns: usize,
    sums: &mut [f64],
) {
    decay.run(Add {
        block,
        places,
        columns,
        sums,
    });
}

struct Add<'a> {
    block: &'a Block,
    places: &'a [[f64; 3]],
    columns: usize,
    sums: &'a mut [f64],
}

impl Job for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes, W: Weight>(mut self, lanes: L, weight: W) {
        let mut first = 0;
        while first < self.columns {
            first += match self.columns - first {
                1 => self.group::<1, L, W>(lanes, weight, first),
                2 | 3 => self.group::<2, L, W>(lanes, weight, first),
                4..8 => self.group::<4, L, W>(lanes, weight, first),
                _ => self.group::<8, L, W>(lanes, weight, first),
            };
        }
    }
}

impl Add<'_> {
    /// Works M columns off.
    #[inline(always)]
    fn group<const M: usize, L: Lanes, W: Weight>(
        &mut self,
        lanes: L,
        weight: W,
        first: usize,
    ) -> usize {
        for (here, sums) in self
            .places
            .iter()
            .zip(self.sums.chunks_exact_mut(self.columns))
        {
            self.block
                .weigh::<M, L, W>(lanes, weight, *here, first, &mut sums[first..first + M]);
        }
        M
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::tests::sheet;
    use crate::pairs::pair_sums;

    #[test]
    fn what_fills_up_the_vectors_weighs_nothing_however_slowly_weights_fall() {
        let (rows, values) = sheet(21); // three lanes more than two whole vectors
        let points = Points::new(&rows).unwrap();
        for exponent in [0.01, 0.05, 0.5] {
            let sums = pair_sums(&points, &values, Decay::new(exponent, 0.0).unwrap()).unwrap();
            let mut weights = 0.0;
            for (i, a) in rows.iter().enumerate() {
                for (j, b) in rows.iter().enumerate() {
                    let d: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
                    weights += if i == j { 0.0 } else { d.powf(-exponent) };
                }
            }
            assert!((sums.weights / weights - 1.0).abs() < 1e-12, "{exponent}");
        }
    }

    #[test]
    fn refusals_name_the_point_and_the_row() {
        let points = Points::new(&[[0.0; 3], [1.0, 0.0, 0.0]]).unwrap();
        let decay = Decay::new(3.0, 0.0).unwrap();
        let odd = [1.0, 2.0, 3.0, f64::NAN];
        assert_eq!(
            product(&points, &odd, 2, decay),
            Err(Refused::Value { index: 1 })
        );
    }

    #[test]
    fn agrees_with_the_pair_sums_whatever_the_number_of_columns() {
        let (rows, values) = sheet(1100);
        let points = Points::new(&rows).unwrap();
        for (columns, nearest) in [(1, 0.0), (2, 0.9), (7, 0.9), (13, 0.0)] {
            let decay = Decay::new(2.0, nearest).unwrap();
            let wanted = pair_sums(&points, &values, decay).unwrap();
            let vectors: Vec<f64> = values
                .iter()
                .flat_map(|value| (0..columns).map(move |k| value * (k + 1) as f64))
                .collect();
            let found = product(&points, &vectors, columns, decay).unwrap();
            for (k, factor) in (0..columns).map(|k| (k, (k + 1) as f64)) {
                let column = found.iter().skip(k).step_by(columns);
                let quadratic: f64 = column.zip(&values).map(|(a, b)| a * b).sum();
                assert!((quadratic / (factor * wanted.products) - 1.0).abs() < 1e-11);
            }
        }
        let decay = Decay::new(2.0, 0.0).unwrap();
        assert!(product(&points, &values, 2, decay).is_err());
    }
}
