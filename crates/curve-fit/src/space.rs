//! The clamped B-spline basis on `[0, length]`.

use crate::error::FitError;

/// Highest degree.
pub const MAX_DEGREE: usize = 3;
/// Most basis functions that differ from zero at one point.
pub const ORDER: usize = MAX_DEGREE + 1;

/// One row of the design matrix: functions `first..=first + degree` at one point, values and first derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BasisRow {
    /// Index of the first function that differs from zero.
    pub first: usize,
    /// Values; entries beyond the degree are zero.
    pub values: [f64; ORDER],
    /// First derivatives; entries beyond the degree are zero.
    pub slopes: [f64; ORDER],
}

/// From which side a knot is looked at, where a derivative may jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The piece that ends at the knot.
    Before,
    /// The piece that begins at the knot.
    After,
}

/// Splines of one degree on one knot sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineSpace {
    degree: usize,
    length: f64,
    /// The interior knots with both ends repeated `degree + 1` times.
    knots: Vec<f64>,
}

impl SplineSpace {
    /// Interior knots in ascending order within (0, length), each at most `degree` times (once for degree 0), so that
    /// every spline is continuous for degree ≥ 1.
    pub fn new(interior: &[f64], length: f64, degree: usize) -> Result<Self, FitError> {
        if degree > MAX_DEGREE {
            return Err(FitError::Degree { degree });
        }
        if !(length.is_finite() && length > 0.0) {
            return Err(FitError::Length { length });
        }
        let repeat = degree.max(1);
        for (index, &knot) in interior.iter().enumerate() {
            let inside = knot > 0.0 && knot < length;
            let ordered = index == 0 || interior[index - 1] <= knot;
            let too_often = index >= repeat && interior[index - repeat] == knot;
            if !inside || !ordered || too_often {
                return Err(FitError::Knot { index, knot });
            }
        }
        let mut knots = vec![0.0; degree + 1];
        knots.extend_from_slice(interior);
        knots.resize(interior.len() + 2 * (degree + 1), length);
        Ok(Self {
            degree,
            length,
            knots,
        })
    }

    /// Degree of the pieces.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// End of the interval.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Number of basis functions.
    pub fn dimension(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Where basis function `index` differs from zero.
    pub fn support(&self, index: usize) -> (f64, f64) {
        (self.knots[index], self.knots[index + self.degree + 1])
    }

    /// `h` with slope(0) = (c₁ − c₀)/h.
    pub(crate) fn start_step(&self) -> f64 {
        (self.knots[self.degree + 1] - self.knots[1]) / self.degree as f64
    }

    /// `h` with slope(length) = (cₙ₋₁ − cₙ₋₂)/h.
    pub(crate) fn end_step(&self) -> f64 {
        let n = self.dimension();
        (self.knots[n + self.degree - 1] - self.knots[n - 1]) / self.degree as f64
    }

    /// Index `j` of the piece `[knot j, knot j + 1]` that holds `point`; the outermost pieces reach beyond the ends.
    pub fn piece(&self, point: f64, side: Side) -> usize {
        let inner = &self.knots[self.degree + 1..self.dimension()];
        self.degree
            + match side {
                Side::After => inner.partition_point(|&knot| knot <= point),
                Side::Before => inner.partition_point(|&knot| knot < point),
            }
    }

    /// The piece after `piece` as long as it ends before `point`: what `piece` finds, for points in ascending order.
    pub(crate) fn advance(&self, mut piece: usize, point: f64) -> usize {
        while piece + 1 < self.dimension() && self.knots[piece + 1] <= point {
            piece += 1;
        }
        piece
    }

    /// What the recursion needs of one piece, an index that `piece` found.
    #[inline]
    pub fn on_piece(&self, piece: usize) -> Piece {
        match self.degree {
            0 => self.prepare::<0>(piece),
            1 => self.prepare::<1>(piece),
            2 => self.prepare::<2>(piece),
            _ => self.prepare::<3>(piece),
        }
    }

    /// The degree is a constant so that the loops unroll.
    #[inline]
    fn prepare<const DEGREE: usize>(&self, piece: usize) -> Piece {
        let mut found = Piece {
            degree: DEGREE,
            first: piece - DEGREE,
            ..Piece::default()
        };
        for k in 0..DEGREE {
            found.after[k] = self.knots[piece + 1 + k];
            found.before[k] = self.knots[piece - k];
        }
        for level in 0..DEGREE {
            for k in 0..=level {
                // Never zero: the two knots enclose the piece, which has a length.
                found.reciprocals[level][k] = 1.0 / (found.after[k] - found.before[level - k]);
            }
        }
        found
    }

    /// Values and slopes at any point, on a piece from `piece`; outside the piece its polynomials are continued.
    pub fn row(&self, point: f64, piece: usize) -> BasisRow {
        let piece = piece.clamp(self.degree, self.dimension() - 1);
        let on_piece = self.on_piece(piece);
        BasisRow {
            first: on_piece.first,
            values: on_piece.values(point),
            slopes: on_piece.slopes(point),
        }
    }
}

/// One piece between two knots, prepared for many points.
#[derive(Clone, Copy, Debug, Default)]
pub struct Piece {
    degree: usize,
    /// Index of the first function that differs from zero on it.
    pub first: usize,
    /// The knots from the piece's end on, and those from its start back.
    after: [f64; MAX_DEGREE],
    before: [f64; MAX_DEGREE],
    /// `reciprocals[level][k]`: one over the support of function `k` of degree `level`.
    reciprocals: [[f64; MAX_DEGREE]; MAX_DEGREE],
}

impl Piece {
    /// Values of the functions that differ from zero; entries beyond the degree are zero.
    #[inline]
    pub fn values(&self, point: f64) -> [f64; ORDER] {
        self.raised_to(self.degree, point)
    }

    /// Slopes: differences of the functions one degree lower.
    fn slopes(&self, point: f64) -> [f64; ORDER] {
        let mut slopes = [0.0; ORDER];
        if self.degree == 0 {
            return slopes;
        }
        let lower = self.raised_to(self.degree - 1, point);
        for k in 0..self.degree {
            let share = self.degree as f64 * lower[k] * self.reciprocals[self.degree - 1][k];
            slopes[k] -= share;
            slopes[k + 1] += share;
        }
        slopes
    }

    #[inline]
    fn raised_to(&self, degree: usize, point: f64) -> [f64; ORDER] {
        match degree {
            0 => self.raise::<0>(point),
            1 => self.raise::<1>(point),
            2 => self.raise::<2>(point),
            _ => self.raise::<3>(point),
        }
    }

    /// De Boor's recursion; the degree is a constant so that the loops unroll.
    #[inline]
    #[allow(clippy::needless_range_loop)] // four arrays are indexed at once, as in the formula
    fn raise<const DEGREE: usize>(&self, point: f64) -> [f64; ORDER] {
        let mut values = [1.0, 0.0, 0.0, 0.0];
        for level in 0..DEGREE {
            let mut carried = 0.0;
            for k in 0..=level {
                let share = values[k] * self.reciprocals[level][k];
                values[k] = carried + (self.after[k] - point) * share;
                carried = (point - self.before[level - k]) * share;
            }
            values[level + 1] = carried;
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_sum_to_one_and_slopes_to_zero() {
        for degree in 0..=MAX_DEGREE {
            let space = SplineSpace::new(&[1.0, 2.5, 2.75], 4.0, degree).unwrap();
            for step in -2..=42 {
                let point = f64::from(step) * 0.1;
                let row = space.row(point, space.piece(point, Side::After));
                assert!((row.values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                assert!(row.slopes.iter().sum::<f64>().abs() < 1e-13);
            }
        }
    }

    #[test]
    fn a_knot_belongs_to_the_side_asked_for() {
        let space = SplineSpace::new(&[1.0, 1.0, 1.0], 2.0, 3).unwrap();
        assert_eq!(space.piece(1.0, Side::Before), 3);
        assert_eq!(space.piece(1.0, Side::After), 6);
        assert_eq!(space.advance(3, 1.0), 6);
        assert_eq!(space.piece(2.0, Side::After), 6);
    }

    #[test]
    fn a_function_differs_from_zero_on_as_many_pieces_as_it_has_orders() {
        let space = SplineSpace::new(&[1.0, 2.0, 3.0], 4.0, 2).unwrap();
        let found: Vec<_> = (0..space.dimension()).map(|i| space.support(i)).collect();
        let ends = [(0.0, 1.0), (0.0, 2.0), (0.0, 3.0), (1.0, 4.0), (2.0, 4.0)];
        assert_eq!(found, [&ends[..], &[(3.0, 4.0)]].concat());
    }

    #[test]
    fn bad_knots_are_refused() {
        for knots in [
            &[0.0][..],
            &[2.0],
            &[1.0, 0.5],
            &[f64::NAN],
            &[1.0, 1.0, 1.0, 1.0],
        ] {
            assert!(
                matches!(SplineSpace::new(knots, 2.0, 3), Err(FitError::Knot { .. })),
                "{knots:?}"
            );
        }
        assert!(matches!(
            SplineSpace::new(&[], 0.0, 3),
            Err(FitError::Length { .. })
        ));
        assert!(matches!(
            SplineSpace::new(&[], 1.0, 4),
            Err(FitError::Degree { .. })
        ));
    }
}
