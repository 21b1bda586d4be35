//! Contours that a roughing and a finishing cycle share: displaced once, as the finishing cycle runs them.
//!
//! A roughing cycle works out its passes from the same blocks and its own allowance, so they keep their distance from
//! the contour. It comes to it from where it was called itself: what the contour inherits from there is not written in.

use std::collections::HashMap;

use nc_program::dialect::{FlowStyle, G};
use nc_program::{MoveKind, Program, Word, WordKind};

use super::{Here, Writer};
use crate::field::Vector;
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::role::roughs;

/// Coordinates less than this apart are one: a contour does not turn back by it, mm.
const SAME: f64 = 1e-9;

/// Where a piece of a shared contour ended and ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended {
    call: i32,
    block: usize,
    before: Vector,
    after: Vector,
}

impl Writer<'_> {
    /// The call of the cycle that makes a move of a contour which is roughed as well.
    fn shared_call(&self, index: usize) -> Option<i32> {
        let call = self.path.call[index];
        let [block, _] = *self.path.calls.get(usize::try_from(call).ok()?)?;
        let runs = |word: &Word| {
            matches!(self.program.code(word), Some(G::Profile(_) | G::FinishContour | G::RoughContour(_)))
        };
        let runs = self.program.words_of(block as usize).iter().any(runs);
        (runs && roughs(self.program)).then_some(call)
    }

    /// Whether an axis stands where the cycle of a shared contour began: another cycle has it elsewhere.
    fn is_of_start(&self, index: usize, axis: usize) -> bool {
        let Some(call) = self.shared_call(index) else { return false };
        let mut own = (0..index).rev().take_while(|other| self.path.call[*other] == call);
        own.all(|other| self.path.words[other][axis] < 0)
    }

    /// Whether an axis that a block does not name is left as it is: the first block of a Fanuc or Haas contour names one
    /// axis, or the cycle is another. Refused where a cut would miss its place by that.
    pub(super) fn is_left(&self, here: &Here, axis: usize, off_mm: f64) -> Result<bool, Refused> {
        if !self.is_of_start(here.index, axis) {
            return Ok(false);
        }
        let cuts = self.path.kind[here.index] != MoveKind::Rapid;
        if self.program.dialect().flow != FlowStyle::Macro || cuts && off_mm > self.tolerance_mm {
            return Err(self.other_start(here, axis));
        }
        Ok(true)
    }

    /// A cut that leads away from where an axis was left has to begin where it shall.
    pub(super) fn require_begun(&self, here: &Here, before: &Vector, first: &Piece) -> Result<(), Refused> {
        let named = here.axes.iter().filter(|axis| axis.word.is_some());
        if self.path.kind[here.index] == MoveKind::Rapid || named.clone().count() < 2 {
            return Ok(());
        }
        for axis in named {
            let off = (first.start[axis.index] - before[axis.index]).abs() - self.tolerance_mm;
            if here.tells(axis, off) && self.is_of_start(here.index, axis.index) {
                return Err(self.other_start(here, axis.index));
            }
        }
        Ok(())
    }

    /// The number of a block that ends such a contour: it goes to the last of its pieces, which the cycle has to reach.
    pub(super) fn last_number<'b>(&self, here: &Here<'b>) -> Option<&'b Word> {
        let call = self.path.call[here.index];
        let [block, _] = *self.path.calls.get(usize::try_from(call).ok()?)?;
        let runs = |word: &Word| matches!(self.program.code(word), Some(G::FinishContour | G::RoughContour(_)));
        let ends = || self.path.call.iter().zip(&self.path.block).filter(|(of, _)| **of == call);
        let last = self.program.words_of(block as usize).iter().any(runs)
            && ends().all(|(_, block)| *block as usize <= here.block);
        here.words.iter().find(move |word| last && word.letter == b'N' && word.kind == WordKind::Number)
    }

    /// Notes where a piece ends, if its contour is shared.
    pub(super) fn note_end(&mut self, here: &Here, piece: &Piece, after: Vector) {
        if let Some(call) = self.shared_call(here.index) {
            let before = self.geometry.point(here.index, piece.share);
            self.shared.push(Ended { call, block: here.block, before, after });
        }
    }
}

/// The first block at which a shared contour turns back along X or Z where it did not before.
pub(crate) fn turns_back(program: &Program, ends: &[Ended]) -> Option<usize> {
    if program.dialect().flow != FlowStyle::Macro {
        return None;
    }
    let mut calls: HashMap<i32, Vec<&Ended>> = HashMap::new();
    ends.iter().for_each(|end| calls.entry(end.call).or_default().push(end));
    let turned = calls.values().flat_map(|ends| {
        [0, 2].into_iter().filter_map(move |axis| {
            let before = ends.iter().map(|end| end.before[axis]);
            let after = ends.iter().map(|end| end.after[axis]);
            first_turn(before).is_none().then(|| first_turn(after)).flatten().map(|at| ends[at].block)
        })
    });
    turned.min()
}

/// The index of the first value that goes against the way of those before.
fn first_turn(values: impl Iterator<Item = f64>) -> Option<usize> {
    let (mut way, mut last) = (0.0, f64::NAN);
    for (index, value) in values.enumerate() {
        let by = value - last;
        if by.abs() > SAME {
            if by * way < 0.0 {
                return Some(index);
            }
            way = by;
        }
        last = value;
    }
    None
}
