//! Turning cycles (G74 to G76, simple cycles): the end that their words state is displaced, and all moves with it.

use super::{Axis, Here, Writer};
use crate::field::Vector;
use crate::part::{require_said, Course};
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::standing::is_increment;
use nc_program::dialect::G;
use nc_program::{MoveKind, Program, Turned, Word, WordKind};

/// The parameter of the GE 2000T's cycle that says where along Z its exit taper begins.
const TAPER_START: f64 = 2.0;

impl Writer<'_> {
    /// Writes a cycle into its block. It keeps its form: a field that displaces its moves by more than the tolerance
    /// differently is refused.
    pub fn turn_cycle(&mut self, cycle: &Turned, pieces: &[Piece], courses: &[Course]) -> Result<(), Refused> {
        let here = self.place(cycle.first);
        let is_cut = |index: &usize| self.path.kind[*index] != MoveKind::Rapid;
        let own = cycle.milled.map(|_| cycle.first);
        let Some(cut) = own.or_else(|| (cycle.first..cycle.end).find(is_cut)) else { return Ok(()) };
        let standing = courses[cut].standing;
        require_said(self.program, self.path, cut, standing, standing)?;
        let by = if cycle.milled.is_some() {
            self.displaced_whole(&here, cycle.first, [true; 3])?
        } else {
            self.displaced_alike(cycle, pieces)?
        };
        let (start, from) = (self.path.start[cycle.first], self.edits.len());
        for axis in [0, 2] {
            let word = self.program.word(cycle.words[axis]);
            let (to, stands) = (cycle.to[axis], word.is_none() && cycle.to[axis] == start[axis]);
            if stands || is_increment(self.program, word, here.state.incremental) {
                continue; // it goes as far from where the tool stands, which is displaced
            }
            let letter = word.map_or(super::AXES[axis], |word| word.letter);
            let own = Axis { letter, word, unit: here.state.axis_mm(axis), incremental: false, ..here.axes[axis] };
            if word.is_some() || here.tells(&own, (by[axis] - self.turning[axis]).abs()) {
                let said = to / own.unit;
                let written = self.value(&here, &own, (to + by[axis]) / own.unit, true, Some(said))?;
                self.turning[axis] = written * own.unit - to;
            }
        }
        if let Some(span) = taper_start(self.program, &here) {
            self.value_of_cycle(&here, span, by[2])?;
        }
        if !self.edits.close(here.block, from) {
            return Err(self.twice(here.block));
        }
        Ok(())
    }

    /// How far the cut of the cycle that is displaced most is displaced: X and Z of all its moves and of its start alike.
    fn displaced_alike(&self, cycle: &Turned, pieces: &[Piece]) -> Result<Vector, Refused> {
        let here = self.place(cycle.first);
        let of = |piece: &Piece| [0, 1, 2].map(|axis| piece.end[axis] - self.path.end[piece.of_move][axis]);
        let Some(by) = pieces.last().map(of) else { return Ok(self.carried) };
        let step = here.step.unit * here.state.mm();
        let apart = |other: Vector| (by[0] - other[0]).abs().max((by[2] - other[2]).abs());
        let whole = pieces.windows(2).all(|pair| pair[0].of_move != pair[1].of_move);
        let most = pieces.iter().map(|piece| apart(of(piece))).fold(apart(self.carried) - step, f64::max);
        if whole && most <= self.tolerance_mm {
            return Ok(by);
        }
        let message =
            format!("the moves of a turning cycle are displaced differently, by {:.2} µm", 1e3 * most.max(0.0));
        let hint = "write the cycle out as moves, or allow a larger tolerance";
        Err(Refused::block(self.block_start(here.block), message, hint))
    }
}

/// The bytes of the position at which the exit taper of a GE 2000T's cycle begins: `P2=-4.5`.
fn taper_start(program: &Program, here: &Here) -> Option<(u32, u32)> {
    here.words.iter().find(|word| program.code(word) == Some(G::TurningCycle))?;
    let sets = |word: &&Word| word.kind == WordKind::Assignment && word.value == TAPER_START;
    let word = here.words.iter().rev().find(sets)?;
    let equals = memchr::memchr(b'=', program.text(word))?;
    Some((word.start + equals as u32 + 1, word.end() as u32))
}
