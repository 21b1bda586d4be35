//! The weight matrix times a few vectors to a given number of digits, in a time that grows with the points, not the pairs.
//!
//! What a cell of points does to another one far away is as smooth as the weight is there: it goes from the points to
//! nodes of their cell, from these to the nodes of the other one, and from there to its points, by interpolation (a
//! fast multipole method without expansions; Fong & Darve, J. Comput. Phys. 228, 2009). Near cells meet point by point.

use threads::spread;

use crate::block::Block;
use crate::points::{finite, Points, Refused};
use crate::product::{add, take_away};
use crate::tree::{Cell, Tree};
use crate::weight::Decay;

/// Cells are far from each other when their radii are together no more than this share of their distance.
const OPENING: f64 = 0.6;

/// `C V` as `product` has it, with an error of about 10^-digits Σⱼ cᵢⱼ |vⱼ|.
pub fn far_product(
    points: &Points,
    vectors: &[f64],
    columns: usize,
    decay: Decay,
    digits: f64,
) -> Result<Vec<f64>, Refused> {
    points.matches(vectors.len(), columns)?;
    finite(vectors.iter().copied(), columns)?;
    if points.is_empty() || columns == 0 {
        return Ok(Vec::new());
    }
    let sums = Sums {
        tree: &Tree::new(points, OPENING, digits.clamp(1.0, 12.0)),
        points,
        vectors,
        columns,
        decay,
    };
    Ok(sums.all())
}

struct Sums<'a> {
    tree: &'a Tree,
    points: &'a Points,
    vectors: &'a [f64],
    columns: usize,
    decay: Decay,
}

/// Of every cell: the cells far from it but not from its parent, and for leaves the near leaves.
struct Lists {
    far: Vec<Vec<usize>>,
    near: Vec<Vec<usize>>,
}

impl Sums<'_> {
    fn all(&self) -> Vec<f64> {
        let lists = self.lists();
        let nodes = self.upward();
        let indices: Vec<usize> = (0..self.tree.cells.len()).collect();
        let mut fields = spread(&indices, |&index| {
            self.field(&nodes, &lists.far[index], index)
        });
        drop(nodes);
        self.downward(&mut fields);
        self.at_points(&fields, &lists.near)
    }

    fn lists(&self) -> Lists {
        let cells = &self.tree.cells;
        let mut lists = Lists {
            far: vec![Vec::new(); cells.len()],
            near: vec![Vec::new(); cells.len()],
        };
        let mut pairs = vec![(0, 0)];
        while let Some((a, b)) = pairs.pop() {
            let (here, there) = (&cells[a], &cells[b]);
            if self.are_far(here, there) {
                lists.far[a].push(b);
                continue;
            }
            match (here.children, there.children) {
                (None, None) => lists.near[a].push(b),
                (Some(halves), other) if other.is_none() || here.radius() >= there.radius() => {
                    pairs.extend(halves.map(|half| (half, b)));
                }
                (_, Some(halves)) => pairs.extend(halves.map(|half| (a, half))),
                (Some(_), None) => {}
            }
        }
        lists
    }

    fn are_far(&self, a: &Cell, b: &Cell) -> bool {
        let square: f64 = a
            .centre
            .iter()
            .zip(b.centre)
            .map(|(p, q)| (p - q) * (p - q))
            .sum();
        let (distance, radii) = (square.sqrt(), a.radius() + b.radius());
        radii <= OPENING * distance && distance - radii > self.decay.nearest()
    }

    /// Of every cell its nodes, with what they hold of the vectors.
    fn upward(&self) -> Vec<Block> {
        let cells = &self.tree.cells;
        let indices: Vec<usize> = (0..cells.len()).collect();
        let mut held = spread(&indices, |&index| {
            let cell = &cells[index];
            let mut held = vec![0.0; cell.node_count() * self.columns];
            if cell.children.is_none() {
                let mut shares = Vec::new();
                for &member in self.tree.members(cell) {
                    cell.shares(self.points.at(member), &mut shares);
                    let values = &self.vectors[member * self.columns..];
                    give(&shares, values, self.columns, &mut held);
                }
            }
            held
        });
        let mut shares = Vec::new();
        for (index, cell) in cells.iter().enumerate().rev() {
            for half in cell.children.into_iter().flatten() {
                let (before, after) = held.split_at_mut(half);
                let places = cells[half].places();
                for (place, values) in places.into_iter().zip(after[0].chunks(self.columns)) {
                    cell.shares(place, &mut shares);
                    give(&shares, values, self.columns, &mut before[index]);
                }
            }
        }
        let columns = self.columns;
        let blocks = cells.iter().zip(held).map(|(cell, held)| {
            let places = cell.places();
            Block::new(places.iter().copied(), columns, |row, column| {
                held[row * columns + column]
            })
        });
        blocks.collect()
    }

    /// What the far cells do to the nodes of one.
    fn field(&self, nodes: &[Block], far: &[usize], index: usize) -> Vec<f64> {
        let places = self.tree.cells[index].places();
        let mut sums = vec![0.0; places.len() * self.columns];
        for &other in far {
            add(self.decay, &nodes[other], &places, self.columns, &mut sums);
        }
        sums
    }

    /// Hands every cell's field on to its halves.
    fn downward(&self, fields: &mut [Vec<f64>]) {
        let mut shares = Vec::new();
        for (index, cell) in self.tree.cells.iter().enumerate() {
            for half in cell.children.into_iter().flatten() {
                let (before, after) = fields.split_at_mut(half);
                let places = self.tree.cells[half].places();
                for (place, sums) in places.into_iter().zip(after[0].chunks_mut(self.columns)) {
                    cell.shares(place, &mut shares);
                    take(&shares, &before[index], self.columns, sums);
                }
            }
        }
    }

    fn at_points(&self, fields: &[Vec<f64>], near: &[Vec<usize>]) -> Vec<f64> {
        let (cells, columns) = (&self.tree.cells, self.columns);
        let leaves: Vec<usize> = (0..cells.len())
            .filter(|&k| cells[k].children.is_none())
            .collect();
        let blocks = spread(&leaves, |&leaf| {
            let members = self.tree.members(&cells[leaf]);
            Block::of(self.points, self.vectors, columns, members)
        });
        let mut of_leaf = vec![0; cells.len()];
        leaves
            .iter()
            .enumerate()
            .for_each(|(k, &leaf)| of_leaf[leaf] = k);
        let own = self.decay.at_none();
        let found = spread(&leaves, |&leaf| {
            let members = self.tree.members(&cells[leaf]);
            let places: Vec<[f64; 3]> = members.iter().map(|&k| self.points.at(k)).collect();
            let mut sums = vec![0.0; members.len() * columns];
            let mut shares = Vec::new();
            for (place, sums) in places.iter().zip(sums.chunks_mut(columns)) {
                cells[leaf].shares(*place, &mut shares);
                take(&shares, &fields[leaf], columns, sums);
            }
            for &other in &near[leaf] {
                add(
                    self.decay,
                    &blocks[of_leaf[other]],
                    &places,
                    columns,
                    &mut sums,
                );
            }
            for (&member, sums) in members.iter().zip(sums.chunks_mut(columns)) {
                take_away(sums, own, &self.vectors[member * columns..]);
            }
            sums
        });
        let mut all = vec![0.0; self.vectors.len()];
        for (leaf, sums) in leaves.iter().zip(found) {
            let members = self.tree.members(&cells[*leaf]);
            for (&member, sums) in members.iter().zip(sums.chunks(columns)) {
                all[member * columns..][..columns].copy_from_slice(sums);
            }
        }
        all
    }
}

/// Shares out the values of one place among the nodes.
fn give(shares: &[f64], values: &[f64], columns: usize, nodes: &mut [f64]) {
    for (share, node) in shares.iter().zip(nodes.chunks_exact_mut(columns)) {
        for (node, value) in node.iter_mut().zip(values) {
            *node += share * value;
        }
    }
}

/// Adds what the nodes hold to the sums of one place.
fn take(shares: &[f64], nodes: &[f64], columns: usize, sums: &mut [f64]) {
    for (share, node) in shares.iter().zip(nodes.chunks_exact(columns)) {
        for (sum, value) in sums.iter_mut().zip(node) {
            *sum += share * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::tests::sheet;
    use crate::product::product;

    /// Largest error at each number of digits as a share of Σⱼ cᵢⱼ |vⱼ|.
    fn errors<const N: usize>(
        points: &Points,
        values: &[f64],
        decay: Decay,
        digits: [f64; N],
    ) -> [f64; N] {
        let sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
        let scale = product(points, &sizes, 1, decay).unwrap();
        let wanted = product(points, values, 1, decay).unwrap();
        digits.map(|digits| {
            let found = far_product(points, values, 1, decay, digits).unwrap();
            let off = found.iter().zip(&wanted).zip(&scale);
            off.map(|((f, w), s)| (f - w).abs() / s).fold(0.0, f64::max)
        })
    }

    #[test]
    fn the_error_is_what_was_asked_for() {
        let (rows, values) = sheet(6000);
        let points = Points::new(&rows).unwrap();
        for exponent in [1.0, 3.0, 6.0] {
            let decay = Decay::new(exponent, 0.3).unwrap();
            let digits = [2.0, 3.0, 4.0, 6.0];
            for (digits, error) in digits
                .into_iter()
                .zip(errors(&points, &values, decay, digits))
            {
                println!("k {exponent} digits {digits} error {error:.1e}");
                assert!(error < 10_f64.powf(-digits), "{exponent} {digits} {error}");
            }
        }
    }

    #[test]
    fn several_columns_and_odd_points_come_out_as_they_should() {
        let decay = Decay::new(3.0, 0.0).unwrap();
        let points = Points::new(&[[1.0; 3]; 900]).unwrap();
        assert_eq!(
            far_product(&points, &[1.0; 900], 1, decay, 4.0).unwrap(),
            [0.0; 900]
        );
        let (rows, values) = sheet(2000);
        let points = Points::new(&rows).unwrap();
        let two: Vec<f64> = values.iter().flat_map(|v| [1.0, *v]).collect();
        let found = far_product(&points, &two, 2, decay, 5.0).unwrap();
        let single = far_product(&points, &values, 1, decay, 5.0).unwrap();
        for (both, one) in found.chunks(2).zip(single) {
            assert!((both[1] - one).abs() < 1e-9 * both[0]);
        }
        assert!(far_product(&points, &values, 2, decay, 4.0).is_err());
    }
}
