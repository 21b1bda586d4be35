//! Points with values in columns of whole vectors, and what one point has to do with all of them.

use crate::lanes::{Eight, Lanes, LANES};
use crate::points::Points;
use crate::weight::Weight;

/// Columns x, y, z and values, filled up to whole vectors with points so far away that they weigh nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    pub(crate) place: [Vec<Eight>; 3],
    /// A column a value.
    pub(crate) values: Vec<Vec<Eight>>,
}

/// Where points stand that only fill up: a distance whose square is still a number, and whose powers are none.
pub(crate) const FAR: f64 = 1e150;

impl Block {
    /// Of some of the points and their rows of `vectors`.
    pub(crate) fn of(points: &Points, vectors: &[f64], columns: usize, some: &[usize]) -> Self {
        let places = some.iter().map(|&row| points.at(row));
        Self::new(places, columns, |row, column| {
            vectors[some[row] * columns + column]
        })
    }

    /// Of points (x, y, z), and their values in columns.
    pub(crate) fn new(
        points: impl Iterator<Item = [f64; 3]> + Clone,
        columns: usize,
        value: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let count = points.clone().count();
        let axis = |axis: usize| whole(points.clone().map(|p| p[axis]), FAR);
        let column = |column| whole((0..count).map(|row| value(row, column)), 0.0);
        Self {
            place: [axis(0), axis(1), axis(2)],
            values: (0..columns).map(column).collect(),
        }
    }

    /// Adds Σⱼ c(|here − xⱼ|) vⱼ for M columns from `first` on to `sums`.
    #[inline(always)]
    pub(crate) fn weigh<const M: usize, L: Lanes, W: Weight>(
        &self,
        lanes: L,
        weight: W,
        here: [f64; 3],
        first: usize,
        sums: &mut [f64],
    ) {
        let here = [
            lanes.splat(here[0]),
            lanes.splat(here[1]),
            lanes.splat(here[2]),
        ];
        let mut totals = [lanes.splat(0.0); M];
        let count = self.place[0].len();
        let [x, y, z] = &self.place;
        let (y, z) = (&y[..count], &z[..count]);
        let mut columns: [&[Eight]; M] = [&[]; M];
        for (column, values) in columns.iter_mut().zip(&self.values[first..first + M]) {
            *column = &values[..count];
        }
        for chunk in 0..count {
            let c = weight.of(
                lanes,
                squared(lanes, here, [&x[chunk], &y[chunk], &z[chunk]]),
            );
            for k in 0..M {
                totals[k] = lanes.multiply_add(c, lanes.load(&columns[k][chunk]), totals[k]);
            }
        }
        for (sum, total) in sums.iter_mut().zip(totals) {
            *sum += lanes.sum(total);
        }
    }
}

/// Squares of the distances.
#[inline(always)]
pub(crate) fn squared<L: Lanes>(lanes: L, here: [L::Vector; 3], there: [&Eight; 3]) -> L::Vector {
    let dx = lanes.subtract(here[0], lanes.load(there[0]));
    let dy = lanes.subtract(here[1], lanes.load(there[1]));
    let dz = lanes.subtract(here[2], lanes.load(there[2]));
    lanes.multiply_add(dz, dz, lanes.multiply_add(dy, dy, lanes.multiply(dx, dx)))
}

fn whole(values: impl Iterator<Item = f64>, filling: f64) -> Vec<Eight> {
    let mut column: Vec<Eight> = Vec::new();
    for (k, value) in values.enumerate() {
        if k % LANES == 0 {
            column.push([filling; LANES]);
        }
        if let Some(last) = column.last_mut() {
            last[k % LANES] = value;
        }
    }
    column
}

#[cfg(test)]
pub(crate) mod tests {
    /// Points on a bent sheet, and values.
    pub(crate) fn sheet(n: u32) -> (Vec<[f64; 3]>, Vec<f64>) {
        let rows = (0..n)
            .map(|k| {
                let t = f64::from(k);
                let (x, y) = (
                    50.0 * (t * 0.754_877_666).fract(),
                    50.0 * (t * 0.569_840_291).fract(),
                );
                [x, y, 4.0 * (x / 14.0).sin() * (y / 17.0).cos()]
            })
            .collect();
        (rows, (0..n).map(|k| (f64::from(k) * 0.37).sin()).collect())
    }

    /// The double sums Σ c and Σ c zᵢ zⱼ, coincident points left out.
    pub(crate) fn double_sum(
        rows: &[[f64; 3]],
        values: &[f64],
        c: impl Fn(f64) -> f64,
    ) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (i, (a, p)) in rows.iter().zip(values).enumerate() {
            for (j, (b, q)) in rows.iter().zip(values).enumerate() {
                let squared: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
                if i != j {
                    sums[0] += c(squared.sqrt());
                    sums[1] += c(squared.sqrt()) * p * q;
                }
            }
        }
        sums
    }
}
