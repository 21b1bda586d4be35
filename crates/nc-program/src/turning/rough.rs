//! Roughing cycles (G71 to G73) taken apart into moves, in coordinates of their own.
//!
//! A point is (along, deep), mm: how far the tool has gone in the direction of its cuts, and how deep below the cycle's
//! start. G71 cuts along Z and goes deep in X, G72 the other way round. A contour that begins at its deepest point and
//! comes out as it runs along is type I of the control's manuals; `rough_pockets` has their type II.

use crate::compensation::offset::minus;
use crate::path::MoveKind;
use crate::shapes::arc::Point;

/// How a cycle roughs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rough {
    /// Cuts along Z, deeper in X with each (G71).
    Along,
    /// Cuts along X, deeper in Z with each (G72).
    Face,
    /// The contour again and again, nearer each time (G73).
    Pattern,
}

/// More cuts than this are a slip of the depth of cut.
pub(crate) const MOST: f64 = 10_000.0;
/// What rounding makes of a contour that runs square to its cuts, or ends where an arc turns back, mm.
pub(crate) const SLACK: f64 = 0.005;
/// Levels closer than this are one, mm.
pub(crate) const SAME: f64 = 1e-9;

/// A piece of the contour: a line, or an arc of a quarter turn at most.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub from: Point,
    pub to: Point,
    pub centre: Option<Point>,
}

/// A move of the roughing: what it is, where it ends, and the centre of one that follows an arc of the contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    pub kind: MoveKind,
    pub to: Point,
    pub centre: Option<Point>,
}

impl Step {
    pub fn straight(kind: MoveKind, to: Point) -> Self {
        Self { kind, to, centre: None }
    }
}

impl Piece {
    /// Whether it does not turn back.
    pub fn runs_on(&self) -> bool {
        minus(self.to, self.from)[0] >= -SLACK
    }

    /// Where it crosses a depth between those of its ends.
    pub fn crossing(&self, depth: f64) -> f64 {
        let (from, to) = (self.from, self.to);
        let along = match self.centre {
            None => from[0] + (to[0] - from[0]) * (depth - from[1]) / (to[1] - from[1]),
            Some(centre) => {
                let (first, last) = (minus(from, centre), minus(to, centre));
                let across = (first[0].hypot(first[1]).powi(2) - (depth - centre[1]).powi(2)).max(0.0).sqrt();
                centre[0] + across.copysign(first[0] + last[0])
            }
        };
        along.max(from[0].min(to[0])).min(from[0].max(to[0]))
    }
}

/// Whether pieces never turn back, and nowhere go down again from where they have come out to: the slack is that of the
/// whole way, which many short pieces do not add up.
pub(crate) fn come_out(pieces: &[Piece]) -> bool {
    let mut highest = f64::INFINITY;
    pieces.iter().all(|piece| {
        highest = highest.min(piece.from[1]);
        piece.runs_on() && piece.to[1] <= highest + SLACK
    })
}

/// A contour that is roughed out from above.
pub(crate) struct Roughing {
    pub pieces: Vec<Piece>,
    pub depth_of_cut: f64,
    /// How far the tool is lifted and goes back after each cut, on each axis.
    pub escape: f64,
    /// Whether the tool goes down at feed, as the contour's first block does.
    pub feeds_down: bool,
}

impl Roughing {
    /// Whether the contour is of type I: it begins deepest, not behind the start, and comes out all the way.
    pub fn is_monotone(&self) -> bool {
        let begins = self.pieces.first().is_some_and(|first| first.from[0] >= -SLACK && first.from[1] > SAME);
        begins && come_out(&self.pieces)
    }

    /// The straight cuts, each as deep as the one before plus the depth of cut, and back to the height of the start. The
    /// cut along the contour takes what is left. `None` when the depth of cut makes no sense.
    pub fn cuts(&self) -> Option<Vec<Step>> {
        let deepest = self.pieces.first()?.from[1];
        let count = ((deepest - SAME) / self.depth_of_cut).floor();
        if !(self.depth_of_cut > 0.0 && (0.0..=MOST).contains(&count)) {
            return None;
        }
        let down = self.way_down();
        let mut steps = Vec::new();
        for cut in 1..=count as usize {
            let depth = cut as f64 * self.depth_of_cut;
            let reach = self.reach(depth);
            steps.push(Step::straight(down, [0.0, depth]));
            if reach > SAME {
                steps.push(Step::straight(MoveKind::Line, [reach, depth]));
                steps.push(Step::straight(MoveKind::Rapid, [reach - self.escape, depth - self.escape]));
                steps.push(Step::straight(MoveKind::Rapid, [0.0, depth - self.escape]));
            }
        }
        Some(steps)
    }

    /// How the contour's first block comes to it.
    pub fn way_down(&self) -> MoveKind {
        if self.feeds_down {
            MoveKind::Line
        } else {
            MoveKind::Rapid
        }
    }

    /// How far a cut at a depth goes: to the contour.
    pub fn reach(&self, depth: f64) -> f64 {
        let comes_above = self.pieces.iter().find(|piece| piece.to[1] < depth);
        let end = self.pieces.last().map_or(0.0, |last| last.to[0]);
        comes_above.map_or(end, |piece| if piece.from[1] <= depth { piece.from[0] } else { piece.crossing(depth) })
    }
}

#[cfg(test)]
mod tests {
    use super::{come_out, Piece, Roughing, Step};
    use crate::path::MoveKind::{Line, Rapid};

    fn line(from: [f64; 2], to: [f64; 2]) -> Piece {
        Piece { from, to, centre: None }
    }

    fn step() -> Roughing {
        let pieces = vec![line([1.0, 5.0], [4.0, 5.0]), line([4.0, 5.0], [6.0, 1.0]), line([6.0, 1.0], [6.0, 0.0])];
        Roughing { pieces, depth_of_cut: 2.0, escape: 0.5, feeds_down: false }
    }

    #[test]
    fn cuts_end_at_the_contour_and_leave_less_than_one_depth() {
        let expected = [
            (Rapid, [0.0, 2.0]),
            (Line, [5.5, 2.0]),
            (Rapid, [5.0, 1.5]),
            (Rapid, [0.0, 1.5]),
            (Rapid, [0.0, 4.0]),
            (Line, [4.5, 4.0]),
            (Rapid, [4.0, 3.5]),
            (Rapid, [0.0, 3.5]),
        ];
        assert_eq!(step().cuts().unwrap(), expected.map(|(kind, to)| Step::straight(kind, to)));
    }

    #[test]
    fn arcs_end_cuts_on_their_own_side_of_the_centre() {
        let hollow = Piece { from: [2.0, 5.0], to: [7.0, 0.0], centre: Some([7.0, 5.0]) };
        let bulge = Piece { from: [2.0, 5.0], to: [7.0, 0.0], centre: Some([2.0, 0.0]) };
        assert!((hollow.crossing(2.0) - 3.0).abs() < 1e-12);
        assert!((bulge.crossing(3.0) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn pockets_and_lines_that_turn_back_are_not_of_type_i() {
        let with = |piece: Piece| Roughing { pieces: vec![line([0.0, 5.0], [1.0, 5.0]), piece], ..step() };
        assert!(step().is_monotone());
        assert!(!with(line([1.0, 5.0], [2.0, 6.0])).is_monotone());
        assert!(!with(line([1.0, 5.0], [0.5, 4.0])).is_monotone());
    }

    #[test]
    fn a_line_in_short_pieces_goes_down_as_it_does_in_one() {
        let down = |from: usize| {
            line([from as f64, 5.0 + 0.003 * from as f64], [from as f64 + 1.0, 5.003 + 0.003 * from as f64])
        };
        assert!(come_out(&[down(0)]));
        assert!(!come_out(&[down(0), down(1)]));
    }

    #[test]
    fn a_depth_of_cut_that_makes_no_sense() {
        for depth_of_cut in [0.0, -1.0, 1e-9, f64::NAN] {
            assert!(Roughing { depth_of_cut, ..step() }.cuts().is_none());
        }
    }
}
