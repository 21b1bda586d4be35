//! Cycles of an Okuma lathe from where the tool stands to X and Z: threads, grooves, taps. Their passes are the control's.

use crate::dialect::G;
use crate::modes::request::Request;
use crate::path::{MoveKind, Turned, INHERITED};
use crate::run::Runner;

impl Runner<'_> {
    /// The path has the place where it begins and the space that it cuts; where it ends has to be said after it.
    pub(crate) fn own_cycle(&mut self, request: &Request, word: i32) {
        if request.get(b'X').is_none() || request.get(b'Z').is_none() {
            return self.not_followed(word, "X and Z are not both given");
        }
        self.note_opaque(word, "its passes are not in the path");
        let (start, first) = (self.state.position, self.path.len());
        let (to, words) = self.target(request, false);
        let space = [[0, 1, 2].map(|axis| start[axis].min(to[axis])), [0, 1, 2].map(|axis| start[axis].max(to[axis]))];
        self.emit(MoveKind::Rapid, start, [INHERITED; 3]);
        self.path.turned.push(Turned { first, end: self.path.len(), words, to, milled: Some(space) });
        self.state.frame.rename([true, false, true]);
    }

    /// `$ H2.45 L2`: further words of the block before, which the control reads with it.
    pub(crate) fn continued(&mut self, word: i32) {
        let text = self.word_text(word).to_ascii_uppercase();
        let names_axis = text.as_bytes().windows(2).any(|pair| {
            let value = pair[1].is_ascii_digit() || matches!(pair[1], b'-' | b'+' | b'.' | b'=' | b' ');
            matches!(pair[0], b'X' | b'Z' | b'C' | b'Y' | b'I' | b'K') && value
        });
        let codes = |block: usize| {
            let own = self.program.words_of(block);
            own.iter().find_map(|word| self.program.code(word).filter(|code| matches!(code, G::OwnCycle | G::Lap(_))))
        };
        let is_more = |block: usize| {
            self.program.words_of(block).first().is_some_and(|word| self.program.text(word).starts_with(b"$"))
        };
        let begun = (0..self.block).rev().find(|block| !is_more(*block)).and_then(codes);
        match begun {
            Some(G::OwnCycle) if !names_axis => {}
            Some(G::Lap(_)) if !names_axis => self.note_opaque(word, "other conditions on the way are not in the path"),
            _ => self.not_followed(word, "it goes on with the block before"),
        }
    }
}
