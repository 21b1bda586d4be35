//! Tensor-product splines at points anywhere: products with the design matrix A, which is never formed.
//!
//! At a point only (degree + 1)² functions differ from zero, the same ones for all points of one cell between knots:
//! cell by cell, a small matrix holds what the points add to AᵀA.

use curve_fit::{Piece, Side, SplineSpace, ORDER};

use crate::Refused;

/// Most functions that differ from zero at one point.
const NEAR: usize = ORDER * ORDER;

/// Splines of two directions at n points (u, v). Points outside see the outermost pieces continued.
#[derive(Clone, Debug)]
pub struct Scattered<'a> {
    spaces: [&'a SplineSpace; 2],
    at: [&'a [f64]; 2],
}

impl<'a> Scattered<'a> {
    /// As many u as v, all finite.
    pub fn new(spaces: [&'a SplineSpace; 2], at: [&'a [f64]; 2]) -> Result<Self, Refused> {
        let (rows, columns) = (at[0].len(), at[1].len());
        if rows != columns {
            let values = rows;
            return Err(Refused::Shape {
                rows: columns,
                columns: 1,
                values,
            });
        }
        for along in at {
            if let Some(index) = along.iter().position(|place| !place.is_finite()) {
                let at = f64::NAN;
                return Err(Refused::Place { index, at });
            }
        }
        Ok(Self { spaces, at })
    }

    /// Number of points.
    pub fn points(&self) -> usize {
        self.at[0].len()
    }

    /// Number of coefficients, those of the second direction next to each other.
    pub fn unknowns(&self) -> usize {
        self.spaces[0].dimension() * self.spaces[1].dimension()
    }

    /// AᵀA, row by row.
    pub fn normal(&self) -> Vec<f64> {
        let unknowns = self.unknowns();
        let mut normal = vec![0.0; unknowns * unknowns];
        for cell in self.sorted().cells() {
            let mut block = [[0.0; NEAR]; NEAR];
            for &point in cell.points {
                let values = cell.values(self.at, point);
                for (row, left) in block.iter_mut().zip(values) {
                    add(row, left, &values);
                }
            }
            for (row, &i) in block.iter().zip(&cell.functions) {
                for (entry, &j) in row.iter().zip(&cell.functions) {
                    normal[i * unknowns + j] += entry;
                }
            }
        }
        normal
    }

    /// AᵀV for V (points × columns): unknowns × columns.
    pub fn sums(&self, vectors: &[f64], columns: usize) -> Result<Vec<f64>, Refused> {
        matches(vectors, self.points(), columns)?;
        let mut sums = vec![0.0; self.unknowns() * columns];
        for cell in self.sorted().cells() {
            for &point in cell.points {
                let values = cell.values(self.at, point);
                let vector = &vectors[point * columns..][..columns];
                for (value, &function) in values.iter().zip(&cell.functions) {
                    add(&mut sums[function * columns..][..columns], *value, vector);
                }
            }
        }
        Ok(sums)
    }

    /// A F for F (unknowns × columns): points × columns.
    pub fn combined(&self, factors: &[f64], columns: usize) -> Result<Vec<f64>, Refused> {
        matches(factors, self.unknowns(), columns)?;
        let mut combined = vec![0.0; self.points() * columns];
        for cell in self.sorted().cells() {
            for &point in cell.points {
                let values = cell.values(self.at, point);
                let sums = &mut combined[point * columns..][..columns];
                for (value, &function) in values.iter().zip(&cell.functions) {
                    add(sums, *value, &factors[function * columns..][..columns]);
                }
            }
        }
        Ok(combined)
    }

    /// a M aᵀ of every row a of A, for M (unknowns × unknowns).
    pub fn squares(&self, matrix: &[f64]) -> Result<Vec<f64>, Refused> {
        let unknowns = self.unknowns();
        matches(matrix, unknowns, unknowns)?;
        let mut squares = vec![0.0; self.points()];
        for cell in self.sorted().cells() {
            let near = |i: usize| cell.functions.map(|j| matrix[i * unknowns + j]);
            let block = cell.functions.map(near);
            for &point in cell.points {
                let values = cell.values(self.at, point);
                let rows = block.iter().zip(values);
                squares[point] = rows.map(|(row, left)| left * dot(row, &values)).sum();
            }
        }
        Ok(squares)
    }

    /// The points sorted by the cell between knots that they are in.
    fn sorted(&self) -> Sorted<'_> {
        let columns = self.spaces[1].dimension();
        let cell_of = |point: usize| {
            let [i, j] = [0, 1].map(|way| self.spaces[way].piece(self.at[way][point], Side::After));
            i * columns + j
        };
        let of: Vec<usize> = (0..self.points()).map(cell_of).collect();
        let mut starts = vec![0; self.unknowns() + 1];
        of.iter().for_each(|&cell| starts[cell + 1] += 1);
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let (mut next, mut order) = (starts.clone(), vec![0; of.len()]);
        for (point, &cell) in of.iter().enumerate() {
            order[next[cell]] = point;
            next[cell] += 1;
        }
        Sorted {
            spaces: self.spaces,
            order,
            starts,
        }
    }
}

struct Sorted<'a> {
    spaces: [&'a SplineSpace; 2],
    order: Vec<usize>,
    starts: Vec<usize>,
}

impl Sorted<'_> {
    /// The cells that hold points.
    fn cells(&self) -> impl Iterator<Item = Cell<'_>> {
        let columns = self.spaces[1].dimension();
        let held = self
            .starts
            .windows(2)
            .enumerate()
            .filter(|(_, ends)| ends[0] < ends[1]);
        held.map(move |(cell, ends)| {
            let pieces = [
                self.spaces[0].on_piece(cell / columns),
                self.spaces[1].on_piece(cell % columns),
            ];
            // Functions beyond the degree are zero: they are given the number of one that there is.
            let near = |way: usize, k: usize| pieces[way].first + k.min(self.spaces[way].degree());
            Cell {
                pieces,
                functions: std::array::from_fn(|k| {
                    near(0, k / ORDER) * columns + near(1, k % ORDER)
                }),
                points: &self.order[ends[0]..ends[1]],
            }
        })
    }
}

/// A cell between knots: the functions that differ from zero there, and the points in it.
struct Cell<'a> {
    pieces: [Piece; 2],
    functions: [usize; NEAR],
    points: &'a [usize],
}

impl Cell<'_> {
    /// What the functions are at a point.
    fn values(&self, at: [&[f64]; 2], point: usize) -> [f64; NEAR] {
        let (u, v) = (
            self.pieces[0].values(at[0][point]),
            self.pieces[1].values(at[1][point]),
        );
        let mut values = [0.0; NEAR];
        for (row, left) in values.chunks_exact_mut(ORDER).zip(u) {
            add(row, left, &v);
        }
        values
    }
}

fn matches(matrix: &[f64], rows: usize, columns: usize) -> Result<(), Refused> {
    let values = matrix.len();
    if values != rows * columns {
        return Err(Refused::Shape {
            rows,
            columns,
            values,
        });
    }
    Ok(())
}

fn add(target: &mut [f64], factor: f64, values: &[f64]) {
    for (entry, value) in target.iter_mut().zip(values) {
        *entry += factor * value;
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: usize = 300;

    /// Points in no order, some outside, and the design matrix written out.
    fn case(degree: usize, test: impl Fn(&Scattered<'_>, &[Vec<f64>])) {
        let spaces = [vec![0.2, 0.5], vec![0.25, 0.4, 0.7]]
            .map(|knots| SplineSpace::new(&knots, 1.0, degree).unwrap());
        let [u, v] = [0.618, 0.755].map(|step| {
            let places = (1..=POINTS).map(|k| (k as f64 * step).fract() * 1.02 - 0.01);
            places.collect::<Vec<f64>>()
        });
        let scattered = Scattered::new([&spaces[0], &spaces[1]], [&u, &v]).unwrap();
        let row = |way: usize, at: f64| {
            let found = spaces[way].row(at, spaces[way].piece(at, Side::After));
            let mut row = vec![0.0; spaces[way].dimension()];
            for k in 0..=degree {
                row[found.first + k] = found.values[k];
            }
            row
        };
        let design: Vec<Vec<f64>> = u
            .iter()
            .zip(&v)
            .map(|(&u, &v)| {
                let (a, b) = (row(0, u), row(1, v));
                a.iter()
                    .flat_map(|a| b.iter().map(move |b| a * b))
                    .collect()
            })
            .collect();
        test(&scattered, &design);
    }

    fn close(found: &[f64], wanted: impl IntoIterator<Item = f64>) {
        let wanted: Vec<f64> = wanted.into_iter().collect();
        assert_eq!(found.len(), wanted.len());
        for (a, b) in found.iter().zip(wanted) {
            assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a} {b}");
        }
    }

    fn some(count: usize) -> Vec<f64> {
        (0..count).map(|k| (k as f64 * 0.37).sin()).collect()
    }

    #[test]
    fn products_are_those_of_the_design_matrix_written_out() {
        for degree in [1, 2, 3] {
            case(degree, |scattered, design| {
                let n = scattered.unknowns();
                let column = |i: usize| design.iter().map(move |row| row[i]);
                let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
                close(
                    &scattered.normal(),
                    pairs.map(|(i, j)| column(i).zip(column(j)).map(|(a, b)| a * b).sum()),
                );
                let vectors = some(POINTS * 2);
                let pairs = (0..n).flat_map(|i| (0..2).map(move |k| (i, k)));
                close(
                    &scattered.sums(&vectors, 2).unwrap(),
                    pairs.map(|(i, k)| {
                        column(i)
                            .zip(vectors.chunks(2))
                            .map(|(a, v)| a * v[k])
                            .sum()
                    }),
                );
                let factors = some(n * 3);
                let pairs = design.iter().flat_map(|row| (0..3).map(move |k| (row, k)));
                close(
                    &scattered.combined(&factors, 3).unwrap(),
                    pairs.map(|(row, k)| {
                        row.iter()
                            .zip(factors.chunks(3))
                            .map(|(a, f)| a * f[k])
                            .sum()
                    }),
                );
                let matrix = some(n * n);
                close(
                    &scattered.squares(&matrix).unwrap(),
                    design.iter().map(|row| {
                        row.iter()
                            .zip(matrix.chunks(n))
                            .map(|(a, m)| a * dot(m, row))
                            .sum()
                    }),
                );
            });
        }
    }

    #[test]
    fn what_does_not_match_is_refused() {
        let space = SplineSpace::new(&[0.5], 1.0, 3).unwrap();
        let spaces = [&space, &space];
        assert!(Scattered::new(spaces, [&[0.1, 0.2], &[0.3]]).is_err());
        assert!(matches!(
            Scattered::new(spaces, [&[0.1, 0.2], &[0.3, f64::NAN]]),
            Err(Refused::Place { index: 1, .. })
        ));
        let two = Scattered::new(spaces, [&[0.1, 0.2], &[0.3, 0.4]]).unwrap();
        assert!(two.sums(&[0.0; 3], 2).is_err());
        assert!(two.combined(&[0.0; 3], 1).is_err());
        assert!(two.squares(&[0.0; 3]).is_err());
        assert!(two.combined(&[], 0).unwrap().is_empty());
    }
}
