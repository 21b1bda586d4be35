//! Going to the start of a move first, where an axis has turned round or what the field depends on has changed.

use nc_program::dialect::{FlowStyle, G};
use nc_program::{MoveKind, Word};

use super::{separate, Here, Writer};
use crate::edits::{is_value, line_ending};
use crate::field::Vector;
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::value::takes_terms;

impl Writer<'_> {
    /// Where the tool has to go before a piece: an axis turned round, what the field depends on changed, or the plane of
    /// an arc that cannot leave it is another.
    pub(super) fn start(&self, here: &Here, actual: &Vector, piece: &Piece) -> Option<Vector> {
        let off = |axis: usize| (piece.start[axis] - actual[axis]).abs();
        let most = (0..3).map(off).fold(0.0, f64::max);
        if self.path.kind[here.index] == MoveKind::Rapid {
            return None;
        }
        if self.knows_travel && most > self.tolerance_mm {
            return Some(piece.start);
        }
        let (_, _, third) = here.state.plane.axes();
        let stays = !self.in_plane(here, [true; 3], piece)[third];
        let lifted = stays && off(third) > here.step.unit * here.state.mm();
        lifted.then(|| [0, 1, 2].map(|axis| if axis == third { piece.start[axis] } else { actual[axis] }))
    }

    /// Goes straight to an arc's start in a block before its own, which then has to say G02 or G03 itself.
    pub(super) fn go_before(
        &mut self,
        here: &Here,
        before: Vector,
        start: Vector,
        live: [bool; 3],
    ) -> Result<Vector, Refused> {
        // Klartext jumps to labels, which have blocks of their own: nothing comes between a block and the one before.
        let follows = !self.whole || self.program.dialect().flow == FlowStyle::Labels;
        let block = self.program.blocks().get(here.block).copied();
        let Some(block) = block.filter(|block| !block.optional && follows) else {
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
        let (before, mut text) = (*actual, self.line_code().to_vec());
        for axis in here.axes.iter().filter(|axis| live[axis.index]) {
            separate(&mut text);
            actual[axis.index] = self.new_coordinate(here, axis, before, to[axis.index], false, &mut text)?;
        }
        Ok(text)
    }

    pub(super) fn arc_code(&self, here: &Here) -> &'static [u8] {
        if self.is_clockwise(here) {
            b"G02"
        } else {
            b"G03"
        }
    }

    /// What follows the end of a new arc in Klartext.
    pub(super) fn turn(&self, here: &Here) -> &'static [u8] {
        match (self.program.dialect().about_pole, self.is_clockwise(here)) {
            (false, _) => b"",
            (true, true) => b" DR-",
            (true, false) => b" DR+",
        }
    }

    fn is_clockwise(&self, here: &Here) -> bool {
        self.geometry.arc(here.index).is_some_and(|arc| arc.sweep > 0.0)
    }

    /// The code of a line.
    pub(super) fn line_code(&self) -> &'static [u8] {
        if takes_terms(self.program) {
            b"G01"
        } else {
            b"L"
        }
    }

    /// The axes that a piece moves: an arc of Klartext stays in its plane.
    pub(super) fn in_plane(&self, here: &Here, mut live: [bool; 3], piece: &Piece) -> [bool; 3] {
        let across = here.state.plane.axes().2;
        let flat = self.program.dialect().about_pole && piece.centre.is_some() && here.axes[across].word.is_none();
        live[across] &= !flat;
        live
    }

    /// Whether a piece of an arc is a line.
    pub(super) fn is_straightened(&self, here: &Here, piece: &Piece) -> bool {
        self.path.kind[here.index] == MoveKind::Arc && piece.centre.is_none()
    }

    /// Makes a line of an arc's block: how it turns, and its radius, are left out.
    pub(super) fn straighten(&mut self, here: &Here) {
        let (program, mut code) = (self.program, self.line_code());
        for word in here.words {
            let turns = matches!(program.code(word), Some(G::Motion(_)));
            if turns || word.letter == program.dialect().rules.radius_letter && is_value(word) {
                let source = program.source().get(..word.start as usize).unwrap_or(&[]);
                let spaces = source.iter().rev().take_while(|byte| **byte == b' ').count();
                let start = if code.is_empty() { source.len() - spaces } else { source.len() };
                self.edits.replace(start, word.end(), |text| text.extend(code));
                code = b"";
            }
        }
    }

    pub(super) fn motion_words(&self, here: &Here) -> Vec<u8> {
        let motion = |word: &&Word| matches!(self.program.code(word), Some(G::Motion(_)));
        here.words.iter().find(motion).map_or(Vec::new(), |word| self.program.text(word).to_vec())
    }
}
