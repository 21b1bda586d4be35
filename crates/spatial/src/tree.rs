//! Points in boxes within boxes, and what stands for the points of a box as seen from afar.

use crate::points::Points;

/// Most points of a box that is not halved again.
const LEAF: usize = 128;
/// Most nodes along an axis.
const MOST: usize = 12;

/// A box around points `first..end` of the tree's order.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    pub(crate) first: usize,
    pub(crate) end: usize,
    pub(crate) centre: [f64; 3],
    half: [f64; 3],
    /// The halves it is split into.
    pub(crate) children: Option<[usize; 2]>,
    nodes: [Vec<f64>; 3],
}

/// Cells, every one before its halves, the first around all points; `order` lists the points.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    pub(crate) order: Vec<usize>,
    pub(crate) cells: Vec<Cell>,
}

impl Tree {
    /// Halves boxes at the median along their longest side.
    ///
    /// Along an axis a cell has as many nodes as interpolate what is `opening` times smaller than its distance, to so
    /// many digits.
    pub(crate) fn new(points: &Points, opening: f64, digits: f64) -> Self {
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut cells = vec![Cell::around(points, &order, 0, opening, digits)];
        let mut index = 0;
        while let Some(cell) = cells.get(index) {
            let (first, end, axis) = (cell.first, cell.end, cell.longest());
            if end - first > LEAF && cell.half[axis] > 0.0 {
                let middle = (end - first) / 2;
                let some = &mut order[first..end];
                some.select_nth_unstable_by(middle, |&a, &b| {
                    points.at(a)[axis].total_cmp(&points.at(b)[axis])
                });
                let (left, right) = some.split_at(middle);
                let halves = [
                    Cell::around(points, left, first, opening, digits),
                    Cell::around(points, right, first + middle, opening, digits),
                ];
                cells[index].children = Some([cells.len(), cells.len() + 1]);
                cells.extend(halves);
            }
            index += 1;
        }
        Self { order, cells }
    }

    /// The points of a cell.
    pub(crate) fn members(&self, cell: &Cell) -> &[usize] {
        &self.order[cell.first..cell.end]
    }
}

impl Cell {
    fn around(points: &Points, some: &[usize], first: usize, opening: f64, digits: f64) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &index in some {
            for (axis, value) in points.at(index).into_iter().enumerate() {
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
            }
        }
        let axes = [0, 1, 2];
        let half = axes.map(|axis| (0.5 * (high[axis] - low[axis])).max(0.0));
        let mut cell = Self {
            first,
            end: first + some.len(),
            centre: axes.map(|axis| 0.5 * (high[axis] + low[axis])),
            half,
            children: None,
            nodes: Default::default(),
        };
        let distance = cell.radius() / opening;
        cell.nodes = axes.map(|axis| {
            let count = nodes_for(half[axis], distance, digits);
            chebyshev(cell.centre[axis], half[axis], count)
        });
        cell
    }

    fn longest(&self) -> usize {
        let by_side = |&a: &usize, &b: &usize| self.half[a].total_cmp(&self.half[b]);
        (0..3).max_by(by_side).unwrap_or(0)
    }

    /// Half its diagonal.
    pub(crate) fn radius(&self) -> f64 {
        let [a, b, c] = self.half;
        (a * a + b * b + c * c).sqrt()
    }

    /// How many nodes it has.
    pub(crate) fn node_count(&self) -> usize {
        self.nodes.iter().map(Vec::len).product()
    }

    /// The nodes, along the last axis first.
    pub(crate) fn places(&self) -> Vec<[f64; 3]> {
        let [x, y, z] = &self.nodes;
        let row = |&x: &f64| {
            y.iter()
                .flat_map(move |&y| z.iter().map(move |&z| [x, y, z]))
        };
        x.iter().flat_map(row).collect()
    }

    /// Of a function known at the nodes: what each node counts at that place.
    pub(crate) fn shares(&self, place: [f64; 3], shares: &mut Vec<f64>) {
        let mut along = [[0.0; MOST]; 3];
        for ((along, nodes), at) in along.iter_mut().zip(&self.nodes).zip(place) {
            lagrange(nodes, at, along);
        }
        let [x, y, z] = &self.nodes;
        shares.clear();
        for a in &along[0][..x.len()] {
            for b in &along[1][..y.len()] {
                shares.extend(along[2][..z.len()].iter().map(|c| a * b * c));
            }
        }
    }
}

/// Nodes over `half` a side to either hand that interpolate a function to so many digits, its next singularity being
/// that `distance` away.
///
/// The error of Chebyshev interpolation falls with ρ^-n, ρ = s + √(s² − 1) for a singularity at s.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // positive and small
fn nodes_for(half: f64, distance: f64, digits: f64) -> usize {
    if half <= 0.0 {
        return 1;
    }
    let away = (distance / half).max(1.01);
    let falls = (away + (away * away - 1.0).sqrt()).log10();
    ((digits / falls).ceil() as usize).clamp(1, MOST)
}

fn chebyshev(centre: f64, half: f64, count: usize) -> Vec<f64> {
    let step = std::f64::consts::PI / (2 * count) as f64;
    (0..count)
        .map(|k| centre + half * (step * (2 * k + 1) as f64).cos())
        .collect()
}

/// Lagrange's polynomials of the nodes.
fn lagrange(nodes: &[f64], at: f64, values: &mut [f64; MOST]) {
    for (k, (value, own)) in values.iter_mut().zip(nodes).enumerate() {
        *value = 1.0;
        for (j, other) in nodes.iter().enumerate() {
            if j != k {
                *value *= (at - other) / (own - other);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::tests::sheet;

    #[test]
    fn every_point_is_in_one_leaf_and_every_leaf_interpolates() {
        let (rows, _) = sheet(3000);
        let tree = Tree::new(&Points::new(&rows).unwrap(), 0.6, 4.0);
        let mut seen = vec![0; 3000];
        let mut shares = Vec::new();
        for cell in &tree.cells {
            for &index in tree.members(cell) {
                if cell.children.is_none() {
                    seen[index] += 1;
                }
                cell.shares(rows[index], &mut shares);
                let f = |[x, y, _]: [f64; 3]| 1.0 + 0.3 * x - 0.2 * x * y;
                let found: f64 = shares
                    .iter()
                    .zip(cell.places())
                    .map(|(s, p)| s * f(p))
                    .sum();
                assert!((found - f(rows[index])).abs() < 1e-9);
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
    }

    #[test]
    fn coincident_points_are_not_split_for_ever() {
        let tree = Tree::new(&Points::new(&[[1.0; 3]; 900]).unwrap(), 0.6, 4.0);
        assert_eq!((tree.cells.len(), tree.cells[0].node_count()), (1, 1));
    }
}
