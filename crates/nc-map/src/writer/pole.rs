//! Arcs of Klartext about a pole: their centre stands in a block of its own, CC, before them.

use super::{Here, Writer, AXES, SAME_MM};
use crate::edits::is_value;
use crate::field::Vector;
use crate::refusal::Refused;
use nc_program::dialect::G;
use nc_program::{Arc, Program, Word, WordKind};

/// The blocks of a part that set the pole of its arcs, in order.
pub(crate) fn poles(program: &Program) -> Vec<usize> {
    if !program.dialect().about_pole {
        return Vec::new();
    }
    let sets = |word: &&Word| matches!(program.code(word), Some(G::Pole(_)));
    program.words().iter().filter(sets).map(|word| program.block_at(word.start as usize)).collect()
}

impl Writer<'_> {
    /// Whether an arc goes about a pole.
    pub(super) fn is_about_pole(&self, here: &Here) -> bool {
        self.program.dialect().about_pole && !here.words.iter().any(|word| word.letter == b'R' && is_value(word))
    }

    /// Displaces the pole of an arc; one that several arcs share has to go to one place for all of them.
    pub(super) fn write_pole(&mut self, here: &Here, arc: &Arc, wanted: Vector) -> Result<(), Refused> {
        let (program, from) = (self.program, self.edits.len());
        let before = self.poles.partition_point(|block| *block < here.block);
        let Some(block) = before.checked_sub(1).and_then(|index| self.poles.get(index)).copied() else {
            return Err(self.no_centre(here));
        };
        let (first, second, _) = here.state.plane.axes();
        for axis in [first, second] {
            let (unit, old) = (here.state.axis_mm(axis), arc.centre[axis]);
            let says = |word: &&Word| {
                let value = if word.kind == WordKind::Number { word.value * unit } else { old };
                let plain = word.letter == AXES[axis] && is_value(word) && program.reference(word).is_none();
                plain && !here.state.incremental && (value - old).abs() <= SAME_MM
            };
            let word = program.words_of(block).iter().rev().find(says).ok_or_else(|| self.no_centre(here))?;
            self.replace_value(here, word, wanted[axis] / unit, old / unit, true)?;
        }
        if self.edits.close(block, from) {
            return Ok(());
        }
        Err(self.twice(block))
    }
}
