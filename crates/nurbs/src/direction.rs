//! One direction of a patch: where it is cut into pieces, and what makes Bézier points of control points there.

use crate::bezier::MOST;
use crate::Refused;

/// Pieces of a whole direction, at least: small enough to be nearly flat.
const FEWEST: usize = 64;

/// One piece of a direction: `from..from + width`, acted on by control points `first..=first + degree`.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) from: f64,
    pub(crate) width: f64,
    pub(crate) first: usize,
    /// Row k makes the k-th Bézier point of those control points.
    pub(crate) bezier: Vec<Vec<f64>>,
    /// First and last of the pieces that join it smoothly, one after the other, itself among them.
    pub(crate) smooth: [usize; 2],
}

/// A direction, cut.
#[derive(Clone, Debug)]
pub(crate) struct Direction {
    pub(crate) degree: usize,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Direction {
    /// From a clamped knot vector. Every span between knots becomes some pieces.
    pub(crate) fn new(degree: usize, knots: &[f64]) -> Result<Self, Refused> {
        let count = knots.len().saturating_sub(degree + 1);
        let ascending = knots.windows(2).all(|pair| pair[0] <= pair[1]);
        if !(1..=MOST).contains(&degree) || count <= degree || !ascending {
            return Err(Refused::Knots);
        }
        let spans: Vec<usize> = (degree..count)
            .filter(|&k| knots[k] < knots[k + 1])
            .collect();
        let each = FEWEST.div_ceil(spans.len().max(1));
        let mut pieces: Vec<Piece> = Vec::new();
        let mut smooth = 0;
        for span in spans {
            // As many equal knots as the degree let the surface have an edge there.
            if span > degree && knots[span + 1 - degree] == knots[span] {
                smooth = pieces.len();
            }
            let (from, to) = (knots[span], knots[span + 1]);
            for k in 0..each {
                let cut = |k: usize| from + (to - from) * k as f64 / each as f64;
                let (a, b) = (cut(k), cut(k + 1));
                pieces.push(Piece {
                    from: a,
                    width: b - a,
                    first: span - degree,
                    bezier: bezier_rows(degree, knots, span, a, b),
                    smooth: [smooth, smooth],
                });
            }
        }
        let mut last = pieces.len().saturating_sub(1);
        for k in (0..pieces.len()).rev() {
            pieces[k].smooth[1] = last;
            if pieces[k].smooth[0] == k {
                last = k.saturating_sub(1);
            }
        }
        let domain = (knots[degree], knots[count]);
        if pieces.is_empty() || !(domain.1 - domain.0).is_finite() {
            return Err(Refused::Knots);
        }
        let (low, high) = domain;
        Ok(Self {
            degree,
            pieces,
            low,
            high,
        })
    }

    /// The piece that holds a place, among those from `range[0]` to `range[1]`.
    pub(crate) fn at(&self, place: f64, range: [usize; 2]) -> usize {
        let behind = self.pieces.partition_point(|piece| piece.from <= place);
        behind.saturating_sub(1).clamp(range[0], range[1])
    }

    /// All pieces.
    pub(crate) fn whole(&self) -> [usize; 2] {
        [0, self.pieces.len() - 1]
    }

    /// Where pieces from `range[0]` to `range[1]` begin and end.
    pub(crate) fn bounds(&self, range: [usize; 2]) -> [f64; 2] {
        let end = match self.pieces.get(range[1] + 1) {
            Some(next) => next.from,
            None => self.high,
        };
        [self.pieces[range[0]].from, end]
    }
}

/// What makes the Bézier points of a span's curve between a and b: its blossom at a…a, a…ab, …, b…b.
fn bezier_rows(degree: usize, knots: &[f64], span: usize, a: f64, b: f64) -> Vec<Vec<f64>> {
    let of = |ends: usize| -> Vec<f64> {
        let arguments: Vec<f64> = (0..degree)
            .map(|k| if k < degree - ends { a } else { b })
            .collect();
        blossom(degree, knots, span, &arguments)
    };
    (0..=degree).map(of).collect()
}

/// How much each control point of a span counts in the blossom at some arguments (de Boor's algorithm).
fn blossom(degree: usize, knots: &[f64], span: usize, arguments: &[f64]) -> Vec<f64> {
    let unit =
        |k: usize| -> Vec<f64> { (0..=degree).map(|j| f64::from(u8::from(j == k))).collect() };
    let mut shares: Vec<Vec<f64>> = (0..=degree).map(unit).collect();
    for (r, at) in arguments.iter().enumerate() {
        for j in (r + 1..=degree).rev() {
            let (left, right) = (knots[span + j - degree], knots[span + j - r]);
            let share = (at - left) / (right - left);
            let (below, own) = shares.split_at_mut(j);
            for (own, below) in own[0].iter_mut().zip(&below[j - 1]) {
                *own = (1.0 - share) * below + share * *own;
            }
        }
    }
    shares.pop().unwrap_or_default()
}
