//! Roughing of CYCLE95 taken apart: equal infeeds, each cut to the contour and along it up to the cut before.
//!
//! Coordinates are (along, deep) as in `rough`: from the contour's outermost point, and from where it begins. A contour
//! that goes down again (relief cuts) is not followed.

use crate::path::MoveKind;
use crate::shapes::arc::Point;
use crate::shapes::drawn::{planar, Contour};
use crate::turning::removal::Side;
use crate::turning::rough::{come_out, Piece, Step, MOST, SAME};
use crate::turning::rough_contour::{pieces, Own};

/// What the words say of it; lengths without sign, mm, on the radius.
pub(crate) struct Stock {
    /// The greatest infeed.
    pub depth: f64,
    /// What is left on in x and z, and along the contour.
    pub left: [f64; 2],
    pub along: f64,
    /// How far the tool is lifted after a cut, and how far from it a cut begins, on each axis.
    pub lift: f64,
    pub side: Side,
    /// Cuts along X instead of Z.
    pub faces: bool,
}

/// A move in the machine's coordinates.
pub(crate) struct Cut {
    pub kind: MoveKind,
    pub to: [f64; 3],
    pub centre: Option<[f64; 3]>,
}

impl Stock {
    /// Which coordinates of a position lie along the cuts and go deep.
    fn axes(&self) -> (usize, usize) {
        if self.faces {
            (0, 2)
        } else {
            (2, 0)
        }
    }

    /// The coordinates of the cycle, and the contour in them, its deepest end first.
    fn own(&self, contour: &Contour) -> Option<(Own, Vec<Piece>)> {
        let axes = self.axes();
        let deep = match (self.faces, self.side) {
            (false, Side::Inside) => 1.0,
            _ => -1.0,
        };
        let (start, end) = (planar(contour.start, axes), planar(contour.cuts.last()?.end, axes));
        let turned = deep * (end[1] - start[1]) > 0.0;
        let (first, last) = if turned { (end, start) } else { (start, end) };
        let raw = pieces(contour, axes, |point| point);
        let heights = raw.iter().flat_map(|piece| [piece.from[1], piece.to[1]]);
        let top = heights.map(|height| -deep * height).fold(f64::NEG_INFINITY, f64::max) * -deep;
        let along = (last[0] - first[0]).signum();
        let own = Own::new(axes, [first[0], top], [along, deep]);
        let mut found = pieces(contour, axes, |point| own.inside(point));
        if turned {
            found.reverse();
            found.iter_mut().for_each(|piece| std::mem::swap(&mut piece.from, &mut piece.to));
        }
        Some((own, found))
    }

    /// What is left on, in the cycle's coordinates: before the contour and above it.
    fn left_on(&self) -> Point {
        let [x, z] = self.left;
        if self.faces {
            [x, z]
        } else {
            [z, x]
        }
    }

    /// Where the tool stands before and after finishing: off the contour's outermost point and off its beginning.
    pub fn start(&self, contour: &Contour) -> Option<[f64; 3]> {
        let (own, _) = self.own(contour)?;
        Some(own.outside_of_origin([-self.lift, -self.lift], contour.start))
    }

    /// The moves; why there are none.
    pub fn cuts(&self, contour: &Contour) -> Result<Vec<Cut>, &'static str> {
        if self.along != 0.0 {
            return Err("an allowance along the contour (FAL) is not followed");
        }
        if self.faces && self.side == Side::Inside {
            return Err("which way it faces inside is the control's");
        }
        let (own, pieces) = self.own(contour).ok_or("its contour has no cut")?;
        if !come_out(&pieces) {
            return Err("its contour has relief cuts");
        }
        let steps = self.steps(&pieces).ok_or("its infeed makes no sense")?;
        let left = self.left_on();
        let place = |point: Point| own.outside_of_origin([point[0] - left[0], point[1] - left[1]], contour.start);
        let cut = |step: &Step| Cut { kind: step.kind, to: place(step.to), centre: step.centre.map(place) };
        Ok(steps.iter().map(cut).collect())
    }

    fn steps(&self, pieces: &[Piece]) -> Option<Vec<Step>> {
        let total = pieces.first()?.from[1];
        let count = (total / self.depth - SAME).ceil();
        if !(self.depth > 0.0 && total > SAME && count <= MOST) {
            return None;
        }
        let stand = [-self.lift, -self.lift];
        let rapid = |to: Point| Step::straight(MoveKind::Rapid, to);
        let mut steps = vec![rapid(stand)];
        for cut in 1..=count as usize {
            let level = |number: usize| if number as f64 == count { total } else { number as f64 * total / count };
            let (depth, above) = (level(cut), level(cut - 1));
            steps.push(rapid([stand[0], depth]));
            let way = follow(pieces, depth, above);
            let reach = way.first().map_or(stand[0], |first| first.to[0]);
            steps.push(Step::straight(MoveKind::Line, [reach, depth]));
            steps.extend(way.iter().skip(1));
            let end = steps.last().map_or(stand, |last| last.to);
            steps.push(rapid([end[0] - self.lift, end[1] - self.lift]));
            steps.push(rapid([stand[0], end[1] - self.lift]));
        }
        steps.push(rapid(stand));
        Some(steps)
    }
}

/// Where a cut at a depth meets the contour, then along that up to the cut above.
fn follow(pieces: &[Piece], depth: f64, above: f64) -> Vec<Step> {
    let mut way: Vec<Step> = Vec::new();
    for piece in pieces {
        let (from, to) = (piece.from, piece.to);
        if from[1] > depth + SAME && to[1] > depth + SAME {
            continue;
        }
        let flat = (to[1] - depth).abs() <= SAME;
        if way.len() <= 1 && flat {
            way = vec![Step::straight(MoveKind::Line, to)];
            continue;
        }
        if way.is_empty() {
            let start = if from[1] > depth + SAME { [piece.crossing(depth), depth] } else { from };
            way.push(Step::straight(MoveKind::Line, start));
        }
        let ends = to[1] <= above + SAME;
        let end = if to[1] < above - SAME { [piece.crossing(above), above] } else { to };
        let kind = if piece.centre.is_some() { MoveKind::Arc } else { MoveKind::Line };
        way.push(Step { kind, to: end, centre: piece.centre });
        if ends {
            break;
        }
    }
    if way.is_empty() {
        way.extend(pieces.last().map(|last| Step::straight(MoveKind::Line, last.to)));
    }
    way
}
