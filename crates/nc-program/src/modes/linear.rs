//! Turned, mirrored and scaled coordinates: an affine map from positions as the program calls them to those of the work
//! frame, which is not turned. All that a block works out stays in the program's coordinates; the path is placed when it
//! is done.

use crate::modes::modal::{Compensation, Plane};
use crate::path::{Origin, ToolPath};

/// Factors that differ by less are equal.
pub(crate) const SAME: f64 = 1e-12;

/// place = matrix · position + shift, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Rows.
    pub matrix: [[f64; 3]; 3],
    /// mm.
    pub shift: [f64; 3],
}

impl Linear {
    /// A turn of the plane by an angle in degrees, from its first axis to its second, about a point.
    pub(crate) fn turn(plane: Plane, angle: f64, about: [f64; 3]) -> Self {
        let (first, second, third) = plane.axes();
        let (sine, cosine) = match angle.rem_euclid(360.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            other => other.to_radians().sin_cos(),
        };
        let mut matrix = [[0.0; 3]; 3];
        (matrix[first][first], matrix[first][second]) = (cosine, -sine);
        (matrix[second][first], matrix[second][second]) = (sine, cosine);
        matrix[third][third] = 1.0;
        Self::about(matrix, about)
    }

    /// Each axis times its factor, from a point on.
    pub(crate) fn scaled(factors: [f64; 3], about: [f64; 3]) -> Self {
        let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column| if row == column { factors[row] } else { 0.0 }));
        Self::about(matrix, about)
    }

    /// The map of that matrix that leaves a point where it is.
    fn about(matrix: [[f64; 3]; 3], point: [f64; 3]) -> Self {
        let own = Self { matrix, shift: [0.0; 3] };
        let moved = own.vector(point);
        Self { matrix, shift: [0, 1, 2].map(|axis| point[axis] - moved[axis]) }
    }

    /// `None` for the map that changes nothing.
    pub(crate) fn unless_none(self) -> Option<Self> {
        let none = Self::scaled([1.0; 3], [0.0; 3]);
        (self != none).then_some(self)
    }

    /// A displacement in the work frame.
    pub fn vector(&self, vector: [f64; 3]) -> [f64; 3] {
        self.matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
    }

    /// A position in the work frame.
    pub fn place(&self, position: [f64; 3]) -> [f64; 3] {
        let turned = self.vector(position);
        [0, 1, 2].map(|axis| turned[axis] + self.shift[axis])
    }

    /// From the work frame to the program's coordinates.
    pub fn inverse(&self) -> Self {
        let determinant = self.determinant();
        let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column| self.minor(column, row) / determinant));
        let back = Self { matrix, shift: [0.0; 3] };
        Self { matrix, shift: back.vector(self.shift).map(|value| -value) }
    }

    /// With the sign of its place.
    fn minor(&self, row: usize, column: usize) -> f64 {
        let m = &self.matrix;
        let [r, s] = [(row + 1) % 3, (row + 2) % 3];
        let [c, d] = [(column + 1) % 3, (column + 2) % 3];
        m[r][c] * m[s][d] - m[r][d] * m[s][c]
    }

    fn determinant(&self) -> f64 {
        (0..3).map(|column| self.matrix[0][column] * self.minor(0, column)).sum()
    }

    /// The most that a length is multiplied by: the largest singular value.
    pub fn stretch(&self) -> f64 {
        let m = &self.matrix;
        let product = |i: usize, j: usize| (0..3).map(|row| m[row][i] * m[row][j]).sum::<f64>();
        let mut squares = [0, 1, 2].map(|i| [0, 1, 2].map(|j| product(i, j)));
        let mean = (0..3).map(|i| squares[i][i]).sum::<f64>() / 3.0;
        (0..3).for_each(|i| squares[i][i] -= mean);
        let spread = (squares.iter().flatten().map(|value| value * value).sum::<f64>() / 6.0).sqrt();
        if spread <= SAME * mean {
            return mean.sqrt();
        }
        // Eigenvalues of a symmetric matrix: mean + 2 · spread · cos(angle).
        let determinant = Self { matrix: squares, shift: [0.0; 3] }.determinant() / spread.powi(3);
        let angle = (determinant / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
        (mean + 2.0 * spread * angle.cos()).sqrt()
    }

    /// First the other, then this.
    pub(crate) fn after(&self, inner: &Self) -> Self {
        let columns = [0, 1, 2].map(|column| self.vector([0, 1, 2].map(|row| inner.matrix[row][column])));
        let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column| columns[column][row]));
        Self { matrix, shift: self.place(inner.shift) }
    }

    /// By how much circles of a plane are scaled, and whether they turn the other way; `None` where they are no circles of
    /// that plane any more.
    pub fn of_circles(&self, plane: Plane) -> Option<(f64, bool)> {
        let (first, second, third) = plane.axes();
        let m = &self.matrix;
        let across = [m[first][third], m[second][third], m[third][first], m[third][second]];
        let (u, v) = ([m[first][first], m[second][first]], [m[first][second], m[second][second]]);
        let (long, wide) = (u[0].hypot(u[1]), v[0].hypot(v[1]));
        let even = (long - wide).abs() <= SAME * long && (u[0] * v[0] + u[1] * v[1]).abs() <= SAME * long * wide;
        let flat = across.iter().all(|value| value.abs() <= SAME);
        (flat && even).then_some((long, u[0] * v[1] - u[1] * v[0] < 0.0))
    }
}

impl ToolPath {
    /// The path of the work frame: each move where its turned, mirrored or scaled coordinates put it. Compensation is at the
    /// side at which the tool then is.
    pub fn placed(mut self) -> Self {
        if self.origins.iter().all(|origin| origin.linear.is_none()) {
            return self;
        }
        let linear = |path: &Self, index: usize| path.origins[path.state[index] as usize].linear;
        for index in 0..self.len() {
            if let Some(linear) = linear(&self, index) {
                self.start[index] = linear.place(self.start[index]);
                self.end[index] = linear.place(self.end[index]);
            }
        }
        for at in 0..self.arcs.len() {
            let of_move = self.arcs[at].of_move;
            let plane = self.states[self.state[of_move] as usize].plane;
            let Some((linear, (scale, mirrored))) =
                linear(&self, of_move).and_then(|l| Some((l, l.of_circles(plane)?)))
            else {
                continue;
            };
            let arc = &mut self.arcs[at];
            arc.centre = linear.place(arc.centre);
            arc.radius *= scale;
            arc.sweep = if mirrored { -arc.sweep } else { arc.sweep };
        }
        for (state, Origin { linear, .. }) in self.states.iter_mut().zip(&self.origins) {
            if linear.and_then(|linear| linear.of_circles(state.plane)).is_some_and(|(_, mirrored)| mirrored) {
                state.compensation = match state.compensation {
                    Compensation::Off => Compensation::Off,
                    Compensation::Left => Compensation::Right,
                    Compensation::Right => Compensation::Left,
                };
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(angle: f64) -> Linear {
        Linear::turn(Plane::Xy, angle, [0.0; 3])
    }

    /// A turn before or after a scaling stretches nothing; a shear, [[1, 1], [0, 1]], stretches by the golden ratio.
    #[test]
    fn the_stretch_is_the_longest_image_of_a_unit_length() {
        let scaled = |factors| Linear::scaled(factors, [0.0; 3]);
        let tilted = Linear::turn(Plane::Zx, 20.0, [0.0; 3]);
        let shear = Linear { matrix: [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };
        let cases = [
            (turn(45.0).after(&scaled([4.0, 1.0, 1.0])), 4.0),
            (tilted.after(&scaled([1.0, 3.0, 5.0])).after(&turn(30.0)), 5.0),
            (scaled([-0.5, 0.25, 0.125]).after(&turn(70.0)), 0.5),
            (turn(37.0), 1.0),
            (scaled([2.0; 3]), 2.0),
            (shear, 1.618033988749895),
        ];
        for (linear, wanted) in cases {
            assert!((linear.stretch() / wanted - 1.0).abs() < 1e-12, "{} for {wanted}", linear.stretch());
        }
    }
}
