//! Fields: a displacement for every position.

use std::error::Error;

use nc_program::dialect::Letters;

/// A position or a displacement, mm: X (a radius on a lathe), Y, Z.
pub type Vector = [f64; 3];

/// A point moved by a displacement.
pub(crate) fn sum(point: &Vector, by: &Vector) -> Vector {
    [point[0] + by[0], point[1] + by[1], point[2] + by[2]]
}

/// A way of travel from where an axis stands at the start and after a return to its reference point.
pub const FROM_REFERENCE: i8 = 2;
/// A way of travel from a place that the control alone knows, as that of G30.
pub const FROM_ELSEWHERE: i8 = 3;

/// Why a field has no displacement.
#[derive(Debug)]
pub enum Trouble {
    /// The point of this index is outside of where the field is known.
    Outside(usize),
    /// The field itself failed.
    Failed(Box<dyn Error + Send + Sync>),
}

/// What a field of the machine has to know beside the position, which is the work offset's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Number of the work offset in force.
    pub work_offset: u16,
    /// The T word in force; −1 before the first.
    pub tool: i32,
    /// What G52 or TRANS add to a position to make it one of the work offset, mm.
    pub shift: Vector,
    /// What G92 adds to that where the machine counts, mm.
    pub named: Vector,
    /// What the tool's offset in force adds to that, mm; NaN where it is not known.
    pub tool_offset: Vector,
    /// The way each axis goes there, or went last: +1, −1; [`FROM_REFERENCE`], [`FROM_ELSEWHERE`] where it came from there;
    /// 0 before its first move.
    pub travel: [i8; 3],
    /// It lies in a cut.
    pub cuts: bool,
    /// Where A, B, C stand, degrees: NaN where the program has not stated it yet, infinite where it is not known.
    pub rotary: Vector,
}

/// A displacement for every position.
pub trait Field {
    /// Displacements at points, in their order: `found` is cleared and filled.
    fn displacements(&mut self, points: &[Vector], places: &[Place], found: &mut Vec<Vector>) -> Result<(), Trouble>;

    /// The rotary axes with whose places it differs; the program may go to any, but for cuts.
    fn follows(&self) -> Letters {
        Letters::default()
    }

    /// Whether it differs by the way of travel, as backlash does.
    fn knows_travel(&self) -> bool {
        false
    }

    /// Whether lines stay lines: their inner points need not be looked at.
    fn keeps_lines(&self) -> bool {
        false
    }
}

/// p ↦ A·p + t, as the displacement (A − 1)·p + t.
#[derive(Clone, Copy, Debug)]
pub struct Affine {
    /// Rows of A.
    pub matrix: [Vector; 3],
    /// t, mm.
    pub shift: Vector,
}

impl Field for Affine {
    fn displacements(&mut self, points: &[Vector], _: &[Place], found: &mut Vec<Vector>) -> Result<(), Trouble> {
        found.clear();
        found.extend(points.iter().map(|point| {
            [0, 1, 2].map(|axis| {
                let row = self.matrix[axis];
                row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + self.shift[axis] - point[axis]
            })
        }));
        Ok(())
    }

    fn keeps_lines(&self) -> bool {
        true
    }
}

/// Displacements at the nodes of a grid, linear between them (trilinear), unknown outside.
///
/// An axis with one value stands for all: the displacement does not depend on it.
#[derive(Clone, Debug)]
pub struct Grid {
    axes: [Vec<f64>; 3],
    nodes: Vec<Vector>,
}

/// Positions beyond the grid's edge by rounding alone are on it, mm.
const ON_EDGE_MM: f64 = 1e-6;

impl Grid {
    /// Rising node positions of each axis, and a displacement for each node, the last axis running fastest. `None` where
    /// they do not fit together.
    pub fn new(axes: [Vec<f64>; 3], nodes: Vec<Vector>) -> Option<Self> {
        let rising = axes.iter().all(|axis| axis.windows(2).all(|pair| pair[0] < pair[1]));
        let count = axes.iter().try_fold(1usize, |count, axis| count.checked_mul(axis.len()))?;
        (rising && count > 0 && count == nodes.len()).then_some(Self { axes, nodes })
    }

    fn at(&self, point: &Vector) -> Option<Vector> {
        let (x, u) = cell(&self.axes[0], point[0])?;
        let (y, v) = cell(&self.axes[1], point[1])?;
        let (z, w) = cell(&self.axes[2], point[2])?;
        let (rows, columns) = (self.axes[1].len(), self.axes[2].len());
        let mut sum = [0.0; 3];
        for (x, u) in [(x, 1.0 - u), (x + 1, u)] {
            for (y, v) in [(y, 1.0 - v), (y + 1, v)] {
                for (z, w) in [(z, 1.0 - w), (z + 1, w)] {
                    let share = u * v * w;
                    if share != 0.0 {
                        let node = self.nodes.get((x * rows + y) * columns + z)?;
                        sum = [0, 1, 2].map(|axis| sum[axis] + share * node[axis]);
                    }
                }
            }
        }
        Some(sum)
    }
}

/// The node at or before a position, and how far the way to the next has been gone.
fn cell(axis: &[f64], position: f64) -> Option<(usize, f64)> {
    let (first, last) = (*axis.first()?, *axis.last()?);
    if axis.len() == 1 {
        return position.is_finite().then_some((0, 0.0));
    }
    if !(first - ON_EDGE_MM..=last + ON_EDGE_MM).contains(&position) {
        return None;
    }
    let index = axis.partition_point(|node| *node <= position).clamp(1, axis.len() - 1) - 1;
    let (low, high) = (*axis.get(index)?, *axis.get(index + 1)?);
    Some((index, ((position - low) / (high - low)).clamp(0.0, 1.0)))
}

impl Field for Grid {
    fn displacements(&mut self, points: &[Vector], _: &[Place], found: &mut Vec<Vector>) -> Result<(), Trouble> {
        found.clear();
        for (index, point) in points.iter().enumerate() {
            found.push(self.at(point).ok_or(Trouble::Outside(index))?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Affine, Field, Grid, Trouble};

    fn at(field: &mut dyn Field, point: [f64; 3]) -> Option<[f64; 3]> {
        let mut found = Vec::new();
        match field.displacements(&[point], &[], &mut found) {
            Ok(()) => found.first().copied(),
            Err(Trouble::Outside(0)) => None,
            Err(other) => panic!("{other:?}"),
        }
    }

    #[test]
    fn between_the_nodes_it_is_linear_and_outside_unknown() {
        let nodes = vec![[0.0, 0.0, 1.0], [0.0, 0.0, 3.0], [1.0, 0.0, 1.0], [1.0, 0.0, 3.0]];
        let mut grid = Grid::new([vec![0.0, 10.0], vec![0.0], vec![0.0, 4.0]], nodes).unwrap();
        assert_eq!(at(&mut grid, [5.0, 77.0, 1.0]), Some([0.5, 0.0, 1.5]));
        assert_eq!(at(&mut grid, [10.0, 0.0, 4.0]), Some([1.0, 0.0, 3.0]));
        assert_eq!(at(&mut grid, [10.1, 0.0, 4.0]), None);
        assert_eq!(at(&mut grid, [5.0, 0.0, f64::NAN]), None);
        assert!(Grid::new([vec![1.0, 1.0], vec![0.0], vec![0.0]], vec![[0.0; 3]; 2]).is_none());
        assert!(Grid::new([vec![1.0], vec![0.0], vec![0.0]], vec![[0.0; 3]; 2]).is_none());
    }

    #[test]
    fn a_quarter_turn() {
        let mut turn = Affine { matrix: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0, 0.0, 2.0] };
        assert_eq!(at(&mut turn, [3.0, 1.0, 5.0]), Some([-4.0, 2.0, 2.0]));
    }
}
