//! Going to the start of a move first, where an axis has turned round or what the field depends on has changed.

use super::{separate, Here, Writer};
use crate::field::Vector;
use crate::lines::line_ending;
use crate::refusal::Refused;
use crate::value::takes_terms;
use nc_program::dialect::G;
use nc_program::{MoveKind, Word};

impl Writer<'_> {
    /// Whether the tool has to go to a start first: an axis turned round, or what the field depends on changed.
    pub(super) fn is_off(&self, here: &Here, actual: &Vector, start: &Vector) -> bool {
        let off = (0..3).map(|axis| (start[axis] - actual[axis]).abs()).fold(0.0, f64::max);
        self.path.kind[here.index] != MoveKind::Rapid && self.tolerance_mm.is_some_and(|tolerance| off > tolerance)
    }

    /// Goes straight to an arc's start in a block before its own, which then has to say G02 or G03 itself.
    pub(super) fn go_before(
        &mut self,
        here: &Here,
        before: Vector,
        start: Vector,
        live: [bool; 3],
    ) -> Result<Vector, Refused> {
        if !takes_terms(self.program) {
            return Err(self.indivisible(here, "an arc of Klartext"));
        }
        let block = self.program.blocks().get(here.block).copied();
        let Some(block) = block.filter(|block| !block.optional && !self.whole) else {
            return Err(self.unreachable(here));
        };
        let mut actual = before;
        let mut text = self.straight(here, start, live, &mut actual)?;
        if let Some(feed) = here.words.iter().find(|word| word.letter == b'F') {
            separate(&mut text);
            text.extend(self.program.text(feed));
        }
        let (at, ending) = (block.start as usize, line_ending(self.program.source()));
        self.edits.replace(at, at, |out| out.extend(text.iter().chain(ending)));
        self.added += 1;
        if self.motion_words(here).is_empty() {
            let code = self.arc_code(here);
            self.edits.insert(self.program, here.block, b'G', |text| text.extend(&code[1..]));
        }
        Ok(actual)
    }

    /// A straight block to a point.
    pub(super) fn straight(
        &self,
        here: &Here,
        to: Vector,
        live: [bool; 3],
        actual: &mut Vector,
    ) -> Result<Vec<u8>, Refused> {
        let (before, mut text) = (*actual, b"G01".to_vec());
        for axis in here.axes.iter().filter(|axis| live[axis.index]) {
            separate(&mut text);
            actual[axis.index] = self.new_coordinate(here, axis, before, to[axis.index], false, &mut text)?;
        }
        Ok(text)
    }

    pub(super) fn arc_code(&self, here: &Here) -> &'static [u8] {
        let clockwise = self.geometry.arc(here.index).is_some_and(|arc| arc.sweep > 0.0);
        if clockwise {
            b"G02"
        } else {
            b"G03"
        }
    }

    pub(super) fn motion_words(&self, here: &Here) -> Vec<u8> {
        let motion = |word: &&Word| matches!(self.program.code(word), Some(G::Motion(_)));
        here.words.iter().find(motion).map_or(Vec::new(), |word| self.program.text(word).to_vec())
    }
}
