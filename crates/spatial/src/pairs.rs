//! Sums over pairs of one value a point.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use crate::points::{finite, Points, Refused};
use crate::weight::{Exponent, Weight, WithWeight};

/// Points of a tile: its columns stay in the first cache.
const TILE: usize = 512;
/// Independent sums, so that vector registers hold them all.
const LANES: usize = 16;

/// Sums over all ordered pairs i ≠ j with weights c = d^-k and values z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairSums {
    /// Σ c.
    pub weights: f64,
    /// Σ c².
    pub squares: f64,
    /// Σ c zᵢ zⱼ.
    pub products: f64,
    /// Σ c (zᵢ − zⱼ)².
    pub differences: f64,
}

impl PairSums {
    fn plus(self, other: Self) -> Self {
        Self {
            weights: self.weights + other.weights,
            squares: self.squares + other.squares,
            products: self.products + other.products,
            differences: self.differences + other.differences,
        }
    }
}

/// The sums, every unordered pair worked off once.
pub fn pair_sums(points: &Points, values: &[f64], exponent: Exponent) -> Result<PairSums, Refused> {
    if values.len() != points.len() {
        return Err(Refused::Lengths {
            points: points.len(),
            found: values.len(),
        });
    }
    finite(values.iter().copied())?;
    Ok(exponent.choose(Tiles { points, values }))
}

#[derive(Clone, Copy)]
struct Tiles<'a> {
    points: &'a Points,
    values: &'a [f64],
}

impl WithWeight for Tiles<'_> {
    type Output = PairSums;

    fn call<W: Weight>(self, weight: W) -> PairSums {
        let tiles = self.points.len().div_ceil(TILE);
        let jobs: Vec<(usize, usize)> = (0..tiles)
            .flat_map(|a| (a..tiles).map(move |b| (a, b)))
            .collect();
        let sums = spread(&jobs, |&(a, b)| {
            pulp::Arch::new().dispatch(Tile {
                of: self,
                first: a * TILE,
                second: b * TILE,
                weight,
            })
        });
        let half = sums.into_iter().fold(PairSums::default(), PairSums::plus);
        half.plus(half)
    }
}

/// Results of the jobs in their order, worked off by as many threads as there are cores.
pub(crate) fn spread<J: Sync, R: Send>(jobs: &[J], work: impl Fn(&J) -> R + Sync) -> Vec<R> {
    let threads = thread::available_parallelism()
        .map_or(1, usize::from)
        .min(jobs.len().div_ceil(4));
    if threads < 2 {
        return jobs.iter().map(work).collect();
    }
    let next = AtomicUsize::new(0);
    let run = || {
        let mut done = Vec::new();
        while let Some((index, job)) = take(&next, jobs) {
            done.push((index, work(job)));
        }
        done
    };
    let mut all = thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(run)).collect();
        let mut all = run();
        for other in others {
            match other.join() {
                Ok(done) => all.extend(done),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    });
    all.sort_unstable_by_key(|(index, _)| *index);
    all.into_iter().map(|(_, result)| result).collect()
}

fn take<'a, J>(next: &AtomicUsize, jobs: &'a [J]) -> Option<(usize, &'a J)> {
    let index = next.fetch_add(1, Ordering::Relaxed);
    jobs.get(index).map(|job| (index, job))
}

/// Some points in a row.
struct Columns<'a> {
    x: &'a [f64],
    y: &'a [f64],
    z: &'a [f64],
    values: &'a [f64],
}

impl<'a> Tiles<'a> {
    #[inline(always)]
    fn columns(&self, from: usize, to: usize) -> Columns<'a> {
        let to = to.min(self.values.len());
        let from = from.min(to);
        Columns {
            x: &self.points.x[from..to],
            y: &self.points.y[from..to],
            z: &self.points.z[from..to],
            values: &self.values[from..to],
        }
    }
}

/// Pairs of a point from `first` on and one from `second` on; of one tile alone, each pair once.
struct Tile<'a, W> {
    of: Tiles<'a>,
    first: usize,
    second: usize,
    weight: W,
}

impl<W: Weight> pulp::NullaryFnOnce for Tile<'_, W> {
    type Output = PairSums;

    #[inline(always)]
    fn call(self) -> PairSums {
        let mut sums = Lanes::default();
        let rows = self.of.columns(self.first, self.first + TILE);
        for i in 0..rows.values.len() {
            let start = self.second.max(self.first + i + 1);
            let others = self.of.columns(start, self.second + TILE);
            let here = [rows.x[i], rows.y[i], rows.z[i], rows.values[i]];
            sums.include(here, &others, self.weight);
        }
        sums.total()
    }
}

#[derive(Clone, Copy, Default)]
struct Lanes {
    weights: [f64; LANES],
    squares: [f64; LANES],
    products: [f64; LANES],
    differences: [f64; LANES],
}

impl Lanes {
    /// What is beyond whole chunks goes through the same arithmetic, filled up with the point itself: it weighs nothing.
    #[inline(always)]
    fn include<W: Weight>(&mut self, here: [f64; 4], others: &Columns<'_>, weight: W) {
        let (x, x_rest) = chunks(others.x, here[0]);
        let (y, y_rest) = chunks(others.y, here[1]);
        let (z, z_rest) = chunks(others.z, here[2]);
        let (values, values_rest) = chunks(others.values, here[3]);
        let mut sums = *self;
        for (((x, y), z), values) in x.zip(y).zip(z).zip(values) {
            sums.chunk(here, [x, y, z, values], weight);
        }
        sums.chunk(here, [&x_rest, &y_rest, &z_rest, &values_rest], weight);
        *self = sums;
    }

    #[inline(always)]
    #[allow(clippy::needless_range_loop)] // eight arrays are indexed at once
    fn chunk<W: Weight>(&mut self, here: [f64; 4], there: [&[f64; LANES]; 4], weight: W) {
        let [x, y, z, values] = there;
        let mut c = [0.0; LANES];
        for lane in 0..LANES {
            let (dx, dy, dz) = (here[0] - x[lane], here[1] - y[lane], here[2] - z[lane]);
            c[lane] = dx * dx + dy * dy + dz * dz;
        }
        for entry in &mut c {
            *entry = weight.of(*entry);
        }
        for lane in 0..LANES {
            let dv = here[3] - values[lane];
            self.weights[lane] += c[lane];
            self.squares[lane] += c[lane] * c[lane];
            self.products[lane] += c[lane] * (here[3] * values[lane]);
            self.differences[lane] += c[lane] * (dv * dv);
        }
    }

    fn total(&self) -> PairSums {
        PairSums {
            weights: self.weights.iter().sum(),
            squares: self.squares.iter().sum(),
            products: self.products.iter().sum(),
            differences: self.differences.iter().sum(),
        }
    }
}

/// Whole chunks, and the rest filled up.
#[inline(always)]
fn chunks(column: &[f64], filling: f64) -> (impl Iterator<Item = &[f64; LANES]>, [f64; LANES]) {
    let whole = column.chunks_exact(LANES);
    let mut rest = [filling; LANES];
    rest.iter_mut()
        .zip(whole.remainder())
        .for_each(|(to, from)| *to = *from);
    (whole.filter_map(|chunk| chunk.try_into().ok()), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_make_the_plain_double_sum() {
        let rows: Vec<[f64; 3]> = (0..1300)
            .map(|k| {
                let t = f64::from(k);
                [
                    (t * 0.7).sin() * 40.0,
                    (t * 1.3).cos() * 30.0,
                    (t * 0.1).sin(),
                ]
            })
            .collect();
        let values: Vec<f64> = (0..1300).map(|k| (f64::from(k) * 0.37).sin()).collect();
        let found = pair_sums(&Points::new(&rows).unwrap(), &values, Exponent::Three).unwrap();
        let mut wanted = PairSums::default();
        for (a, p) in rows.iter().zip(&values) {
            for (b, q) in rows.iter().zip(&values) {
                let squared: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
                if squared > 0.0 {
                    let c = squared.sqrt().powi(-3);
                    wanted = wanted.plus(PairSums {
                        weights: c,
                        squares: c * c,
                        products: c * p * q,
                        differences: c * (p - q) * (p - q),
                    });
                }
            }
        }
        for (f, w) in [
            (found.weights, wanted.weights),
            (found.squares, wanted.squares),
            (found.products, wanted.products),
            (found.differences, wanted.differences),
        ] {
            assert!((f / w - 1.0).abs() < 1e-12, "{f} {w}");
        }
    }

    #[test]
    fn what_cannot_be_summed_is_refused() {
        let points = Points::new(&[[0.0; 3], [1.0, 0.0, 0.0]]).unwrap();
        assert!(pair_sums(&points, &[1.0], Exponent::Three).is_err());
        assert_eq!(
            pair_sums(&points, &[1.0, f64::NAN], Exponent::Three),
            Err(Refused::Value { index: 1 })
        );
        assert!(Points::new(&[[f64::INFINITY, 0.0, 0.0]]).is_err());
        let none = Points::new(&[]).unwrap();
        assert_eq!(
            pair_sums(&none, &[], Exponent::Three),
            Ok(PairSums::default())
        );
    }
}
