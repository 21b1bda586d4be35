//! A patch, and the feet of points on it.

use std::fmt;

use threads::spread;

use crate::bezier::{bernstein, evaluated, Lifted, Local};
use crate::boxes::{Boxes, Search};
use crate::descent::descended;
use crate::direction::Direction;
use crate::Point3;

/// Points whose feet one job finds.
const JOB: usize = 512;

/// A B-spline patch, cut into Bézier pieces.
#[derive(Clone, Debug)]
pub struct Patch {
    pub(crate) directions: [Direction; 2],
    /// Control points of the pieces, piece by piece.
    nets: Vec<Lifted>,
    boxes: Boxes,
}

/// The closest point of a patch: its parameters, place, and derivatives by u and by v.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// (u, v).
    pub at: [f64; 2],
    /// The point of the patch.
    pub point: Point3,
    /// Derivative by u.
    pub du: Point3,
    /// Derivative by v.
    pub dv: Point3,
}

/// Why a patch or a point was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum Refused {
    /// Knots that do not ascend, are too few, or of a degree below 1 or above 25.
    Knots,
    /// Control points that are not as many as the knots ask for, no finite numbers, or of a weight that is not positive.
    Control,
    /// A point or its parameters that are no finite numbers.
    Point {
        /// Which point.
        index: usize,
    },
    /// Not as many parameters to start from as points.
    Lengths {
        /// Points.
        points: usize,
        /// Parameters.
        near: usize,
    },
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Knots => write!(
                f,
                "the knots do not ascend, or do not fit the degree (1 to 25)"
            ),
            Self::Control => write!(
                f,
                "the control points do not fit the knots, or have no positive weight"
            ),
            Self::Point { index } => write!(f, "point {index} is no finite number"),
            Self::Lengths { points, near } => {
                write!(f, "{near} places to start from for {points} points")
            }
        }
    }
}

impl std::error::Error for Refused {}

impl Patch {
    /// From degrees and clamped knots along u and v, and control points (w x, w y, w z, w), row by row.
    pub fn new(
        degrees: [usize; 2],
        knots: [&[f64]; 2],
        control: &[Lifted],
    ) -> Result<Self, Refused> {
        let [u, v] = [0, 1].map(|k| Direction::new(degrees[k], knots[k]));
        let directions = [u?, v?];
        let counts = [0, 1].map(|k| knots[k].len() - degrees[k] - 1);
        let fits = control.len() == counts[0] * counts[1];
        if !fits
            || !control
                .iter()
                .all(|c| c[3] > 0.0 && c.iter().all(|x| x.is_finite()))
        {
            return Err(Refused::Control);
        }
        let nets = nets_of(&directions, control, counts[1]);
        let boxes = Boxes::new(&directions, &nets);
        Ok(Self {
            directions,
            nets,
            boxes,
        })
    }

    /// The feet of points, in their order. `near`: parameters from where the search is to start, one a point.
    ///
    /// Without them a foot is the nearest point of the whole patch: control points bound what a piece can hold.
    pub fn feet(&self, points: &[Point3], near: Option<&[[f64; 2]]>) -> Result<Vec<Foot>, Refused> {
        let finite = |index: &usize| !points[*index].iter().all(|x| x.is_finite());
        if let Some(index) = (0..points.len()).find(finite) {
            return Err(Refused::Point { index });
        }
        if let Some(near) = near {
            if near.len() != points.len() {
                return Err(Refused::Lengths {
                    points: points.len(),
                    near: near.len(),
                });
            }
            if let Some(index) = near.iter().position(|at| !at.iter().all(|x| x.is_finite())) {
                return Err(Refused::Point { index });
            }
        }
        let jobs: Vec<usize> = (0..points.len()).step_by(JOB).collect();
        let found = spread(&jobs, |&first| {
            let some = first..(first + JOB).min(points.len());
            let mut search = Search::default();
            some.map(|k| match near {
                Some(near) => descended(self, points[k], near[k]),
                None => self.boxes.nearest(self, points[k], &mut search),
            })
            .collect::<Vec<Foot>>()
        });
        Ok(found.into_iter().flatten().collect())
    }

    /// The patch at (u, v), looked at from within some of its pieces.
    #[inline]
    pub(crate) fn local(&self, at: [f64; 2], ranges: [[usize; 2]; 2]) -> Local {
        let [u, v] = &self.directions;
        let (i, j) = (u.at(at[0], ranges[0]), v.at(at[1], ranges[1]));
        let basis = |direction: &Direction, k: usize, at: f64| {
            let piece = &direction.pieces[k];
            bernstein(
                direction.degree,
                (at - piece.from) / piece.width,
                piece.width,
            )
        };
        let (along, across) = (basis(u, i, at[0]), basis(v, j, at[1]));
        let net = net_of(&self.nets, &self.directions, [i, j]);
        evaluated(net, [u.degree, v.degree], &along, &across)
    }
}

/// The control points of one piece.
pub(crate) fn net_of<'a>(
    nets: &'a [Lifted],
    directions: &[Direction; 2],
    piece: [usize; 2],
) -> &'a [Lifted] {
    let [u, v] = directions;
    let size = (u.degree + 1) * (v.degree + 1);
    let first = (piece[0] * v.pieces.len() + piece[1]) * size;
    &nets[first..first + size]
}

/// Control points of all pieces from those of the patch, `columns` in a row.
fn nets_of(directions: &[Direction; 2], control: &[Lifted], columns: usize) -> Vec<Lifted> {
    let [u, v] = directions;
    let mut nets = Vec::new();
    for along in &u.pieces {
        let rows: Vec<Vec<Lifted>> = along
            .bezier
            .iter()
            .map(|shares| {
                (0..columns)
                    .map(|column| {
                        combined(shares, |k| control[(along.first + k) * columns + column])
                    })
                    .collect()
            })
            .collect();
        for across in &v.pieces {
            for row in &rows {
                nets.extend(
                    across
                        .bezier
                        .iter()
                        .map(|shares| combined(shares, |k| row[across.first + k])),
                );
            }
        }
    }
    nets
}

fn combined(shares: &[f64], of: impl Fn(usize) -> Lifted) -> Lifted {
    let mut sum = [0.0; 4];
    for (k, share) in shares.iter().enumerate() {
        let control = of(k);
        for (sum, value) in sum.iter_mut().zip(control) {
            *sum += share * value;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A half cylinder of radius 1 along y, 0 ≤ x ≤ π by two exact arcs with an edge of knots between them.
    fn arch() -> Patch {
        let h = 0.5_f64.sqrt();
        let arc = [
            [1.0, 0.0, 1.0],
            [h, h, h],
            [0.0, 1.0, 1.0],
            [-h, h, h],
            [-1.0, 0.0, 1.0],
        ];
        let control: Vec<Lifted> = arc
            .iter()
            .flat_map(|[x, z, w]| [[*x, 0.0, *z, *w], [*x, 5.0 * w, *z, *w]])
            .collect();
        let knots = [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0];
        Patch::new([2, 1], [&knots, &[0.0, 0.0, 1.0, 1.0]], &control).unwrap()
    }

    #[test]
    fn feet_on_an_arch_stand_below_their_points() {
        for k in 0..40 {
            let angle = 0.03 + 0.077 * f64::from(k);
            for radius in [0.4, 1.0, 2.5] {
                let point = [radius * angle.cos(), 2.0, radius * angle.sin()];
                let foot = arch().feet(&[point], None).unwrap()[0];
                assert!(
                    (foot.point[0] - angle.cos()).abs() < 1e-12,
                    "{angle} {radius}"
                );
                assert!((foot.point[2] - angle.sin()).abs() < 1e-12);
                assert!((foot.at[1] - 0.4).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_start_given_is_gone_on_from_even_over_an_edge() {
        let point = [-1.5, 1.0, 0.5];
        let far = arch().feet(&[point], Some(&[[0.1, 0.9]])).unwrap()[0];
        let near = arch().feet(&[point], None).unwrap()[0];
        assert!((far.at[0] - near.at[0]).abs() < 1e-12 && far.at[0] > 0.5);
    }

    #[test]
    fn what_is_no_patch_or_no_point_is_refused() {
        let line: &[f64] = &[0.0, 0.0, 1.0, 1.0];
        let square = [
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 1.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 1.0],
            [1.0, 1.0, 0.0, 1.0],
        ];
        let refused =
            |degrees, knots, control: &[Lifted]| Patch::new(degrees, knots, control).unwrap_err();
        assert_eq!(refused([0, 1], [line, line], &square), Refused::Knots);
        assert_eq!(
            refused([1, 1], [line, &[0.0, 1.0, 0.0, 1.0]], &square),
            Refused::Knots
        );
        assert_eq!(refused([1, 1], [&[], line], &square), Refused::Knots);
        assert_eq!(refused([1, 1], [line, &[0.0; 4]], &square), Refused::Knots);
        assert_eq!(
            refused([1, 1], [line, line], &square[1..]),
            Refused::Control
        );
        let mut weightless = square;
        weightless[2][3] = 0.0;
        assert_eq!(refused([1, 1], [line, line], &weightless), Refused::Control);
        let patch = Patch::new([1, 1], [line, line], &square).unwrap();
        let points = [[0.5, 0.5, 1.0], [0.5, f64::NAN, 1.0]];
        assert_eq!(
            patch.feet(&points, None).unwrap_err(),
            Refused::Point { index: 1 }
        );
        let wrong = Refused::Lengths { points: 1, near: 0 };
        assert_eq!(patch.feet(&points[..1], Some(&[])).unwrap_err(), wrong);
        assert!(patch.feet(&[], None).unwrap().is_empty());
    }
}
