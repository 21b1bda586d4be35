//! Turned, mirrored and scaled coordinates: an affine map from positions as the program calls them to those of the work
//! frame, which is not turned. All that a block works out stays in the program's coordinates; the path is placed when it
//! is done.

use crate::modes::modal::{Compensation, Plane};
use crate::path::{Origin, ToolPath};

/// Factors that differ by less are equal.
const SAME: f64 = 1e-12;

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
        let m = &self.matrix;
        let minor = |row: usize, column: usize| {
            let [r, s] = [(row + 1) % 3, (row + 2) % 3];
            let [c, d] = [(column + 1) % 3, (column + 2) % 3];
            m[r][c] * m[s][d] - m[r][d] * m[s][c]
        };
        let determinant = (0..3).map(|column| m[0][column] * minor(0, column)).sum::<f64>();
        let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column| minor(column, row) / determinant));
        let back = Self { matrix, shift: [0.0; 3] };
        Self { matrix, shift: back.vector(self.shift).map(|value| -value) }
    }

    /// The most that a length is multiplied by along an axis.
    pub fn stretch(&self) -> f64 {
        let length = |row: &[f64; 3]| row.iter().map(|value| value * value).sum::<f64>().sqrt();
        self.matrix.iter().map(length).fold(0.0, f64::max)
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
