//! Edits of a part: bytes replaced by text, everything else as it was.

use nc_program::{Program, Word, WordKind};

/// Bytes `start` to `end` of the part replaced by a stretch of the collected text.
#[derive(Clone, Copy, Debug)]
struct Edit {
    start: u32,
    end: u32,
    text: (u32, u32),
}

/// The edits of a part, gathered move by move.
#[derive(Debug)]
pub(crate) struct Edits {
    edits: Vec<Edit>,
    text: Vec<u8>,
    /// First and one past the last edit of each block that was written.
    of_block: Vec<(u32, u32)>,
}

impl Edits {
    pub fn new(blocks: usize) -> Self {
        Self { edits: Vec::new(), text: Vec::new(), of_block: vec![(u32::MAX, 0); blocks] }
    }

    pub fn len(&self) -> usize {
        self.edits.len()
    }

    /// Replaces bytes by what `write` writes; gives what that gives.
    pub fn replace<R>(&mut self, start: usize, end: usize, write: impl FnOnce(&mut Vec<u8>) -> R) -> R {
        let from = self.text.len() as u32;
        let written = write(&mut self.text);
        self.edits.push(Edit { start: start as u32, end: end as u32, text: (from, self.text.len() as u32) });
        written
    }

    /// Closes the edits since `from` as those of a block. False where it had other ones already: it is run twice.
    pub fn close(&mut self, block: usize, from: usize) -> bool {
        let Some(known) = self.of_block.get_mut(block) else {
            return true;
        };
        if known.0 == u32::MAX {
            *known = (from as u32, self.edits.len() as u32);
            return true;
        }
        let (first, new) = (&self.edits[known.0 as usize..known.1 as usize], &self.edits[from..]);
        let text = |edit: &Edit| &self.text[edit.text.0 as usize..edit.text.1 as usize];
        let same = |a: &Edit, b: &Edit| (a.start, a.end, text(a)) == (b.start, b.end, text(b));
        let equal = first.len() == new.len() && first.iter().zip(new).all(|(a, b)| same(a, b));
        self.edits.truncate(from);
        equal
    }

    /// The part's bytes before `end` with the edits made. Insertions at one place keep their order.
    pub fn apply(&mut self, source: &[u8], end: usize, out: &mut Vec<u8>) {
        self.edits.sort_by_key(|edit| (edit.start, edit.end));
        let mut done = 0;
        for edit in &self.edits {
            out.extend_from_slice(source.get(done..edit.start as usize).unwrap_or(&[]));
            out.extend_from_slice(self.text.get(edit.text.0 as usize..edit.text.1 as usize).unwrap_or(&[]));
            done = edit.end as usize;
        }
        out.extend_from_slice(source.get(done..end).unwrap_or(&[]));
    }
}

/// Whether a word may be edited.
pub(crate) fn is_value(word: &Word) -> bool {
    matches!(word.kind, WordKind::Number | WordKind::Expression)
}

impl Edits {
    /// Writes a word into a block: after N, its codes and the letters before it, else before all.
    pub fn insert(&mut self, program: &Program, block: usize, letter: u8, write: impl FnOnce(&mut Vec<u8>)) {
        const ORDER: &[u8] = b"NGXUYVZWRIJK";
        let rank = |letter: u8| ORDER.iter().position(|known| *known == letter);
        let (words, mine) = (program.words_of(block), rank(letter));
        let named = words.iter().find(|word| word.kind == WordKind::Name).map(|word| word.start);
        let rank_of = |word: &Word| match word.kind {
            WordKind::Label => rank(b'N'),
            WordKind::Name if named == Some(word.start) => rank(b'G'),
            _ => rank(word.letter).filter(|_| is_value(word)),
        };
        let before = words.iter().rev().find(|word| rank_of(word).is_some_and(|other| Some(other) <= mine));
        let space: &[u8] = if is_spaced(program, block) { b" " } else { b"" };
        let at = before.map_or(words.first().map_or(0, |word| word.start as usize), Word::end);
        let leads = before.is_some();
        self.replace(at, at, |text| {
            text.extend(if leads { space } else { b"" });
            text.push(letter);
            write(text);
            text.extend(if leads { b"" } else { space });
        });
    }
}

/// Whether a block's words are set apart; a single word says nothing and counts as such.
fn is_spaced(program: &Program, block: usize) -> bool {
    let words = program.words_of(block);
    program.dialect().formulas || words.len() < 2 || words.windows(2).any(|pair| pair[0].end() < pair[1].start as usize)
}
