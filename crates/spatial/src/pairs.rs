//! Sums over all pairs of one value a point.

use threads::spread;

use crate::block::{squared, Block};
use crate::lanes::{Eight, Lanes, LANES};
use crate::points::{finite, Points, Refused};
use crate::weight::{Decay, Job, Weight};

/// Vectors of a tile at most: its columns stay in the first cache. Few points have smaller tiles, so that every core gets some.
const TILE: usize = 64;
const LEAST_TILE: usize = 16;

/// Sums over all ordered pairs i ≠ j with weights c.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairSums {
    /// Σ c.
    pub weights: f64,
    /// Σ c zᵢ zⱼ.
    pub products: f64,
}

/// The sums, every unordered pair worked off once. Memory grows with the number of points, not of pairs.
pub fn pair_sums(points: &Points, values: &[f64], decay: Decay) -> Result<PairSums, Refused> {
    points.matches(values.len(), 1)?;
    finite(values.iter().copied(), 1)?;
    let block = Block::new(points.rows(), 1, |row, _| values[row]);
    let tile = (block.place[0].len() / 8).clamp(LEAST_TILE, TILE);
    let tiles = block.place[0].len().div_ceil(tile);
    let jobs: Vec<(usize, usize)> = (0..tiles)
        .flat_map(|a| (a..tiles).map(move |b| (a, b)))
        .collect();
    let sums = spread(&jobs, |&(a, b)| {
        decay.run(Tile {
            block: &block,
            points: points.len(),
            first: a * tile,
            second: b * tile,
            size: tile,
        })
    });
    let half = |part: fn(&PairSums) -> f64| 2.0 * sums.iter().map(part).sum::<f64>();
    Ok(PairSums {
        weights: half(|sums| sums.weights),
        products: half(|sums| sums.products),
    })
}

/// Pairs of a point from vector `first` on and one from vector `second` on; of one tile alone, each pair once.
struct Tile<'a> {
    block: &'a Block,
    points: usize,
    first: usize,
    second: usize,
    size: usize,
}

impl Job for Tile<'_> {
    type Output = PairSums;

    #[inline(always)]
    fn run<L: Lanes, W: Weight>(self, lanes: L, weight: W) -> PairSums {
        let [x, y, z] = &self.block.place;
        let values = &self.block.values[0];
        let end = (self.second + self.size).min(x.len());
        let mut weights = lanes.splat(0.0);
        let mut products = lanes.splat(0.0);
        for i in self.first * LANES..((self.first + self.size) * LANES).min(self.points) {
            let (chunk, lane) = (i / LANES, i % LANES);
            let here = [
                lanes.splat(x[chunk][lane]),
                lanes.splat(y[chunk][lane]),
                lanes.splat(z[chunk][lane]),
            ];
            let mut row = lanes.splat(0.0);
            let mut start = self.second;
            if self.first == self.second {
                let after = later(&x[chunk], lane);
                let c = weight.of(lanes, squared(lanes, here, [&after, &y[chunk], &z[chunk]]));
                weights = lanes.add(weights, c);
                row = lanes.multiply(c, lanes.load(&values[chunk]));
                start = chunk + 1;
            }
            let columns = x[start..end].iter().zip(&y[start..end]);
            let more = z[start..end].iter().zip(&values[start..end]);
            for ((x, y), (z, value)) in columns.zip(more) {
                let c = weight.of(lanes, squared(lanes, here, [x, y, z]));
                weights = lanes.add(weights, c);
                row = lanes.multiply_add(c, lanes.load(value), row);
            }
            products = lanes.multiply_add(row, lanes.splat(values[chunk][lane]), products);
        }
        PairSums {
            weights: lanes.sum(weights),
            products: lanes.sum(products),
        }
    }
}

/// A column of x in which the points up to `lane` stand so far away that they weigh nothing.
#[inline(always)]
fn later(x: &Eight, lane: usize) -> Eight {
    let mut after = *x;
    after[..=lane].fill(crate::block::FAR);
    after
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::tests::{double_sum, sheet};

    #[test]
    fn tiles_make_the_plain_double_sum() {
        let (rows, values) = sheet(1301);
        for nearest in [0.0, 0.7_f64] {
            let decay = Decay::new(3.0, nearest).unwrap();
            let found = pair_sums(&Points::new(&rows).unwrap(), &values, decay).unwrap();
            let wanted = double_sum(&rows, &values, |d| d.max(nearest).powi(-3));
            for (f, w) in [found.weights, found.products].iter().zip(wanted) {
                assert!((f / w - 1.0).abs() < 1e-12, "{f} {w}");
            }
        }
    }

    #[test]
    fn what_cannot_be_summed_is_refused() {
        let decay = Decay::new(3.0, 0.0).unwrap();
        let points = Points::new(&[[0.0; 3], [1.0, 0.0, 0.0]]).unwrap();
        assert!(pair_sums(&points, &[1.0], decay).is_err());
        assert_eq!(
            pair_sums(&points, &[1.0, f64::NAN], decay),
            Err(Refused::Value { index: 1 })
        );
        assert!(Points::new(&[[f64::INFINITY, 0.0, 0.0]]).is_err());
        let none = Points::new(&[]).unwrap();
        assert_eq!(pair_sums(&none, &[], decay), Ok(PairSums::default()));
    }
}
