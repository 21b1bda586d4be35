//! Edits of a part: bytes replaced by text, everything else as it was; new lines are numbered as the program numbers its
//! blocks.

use std::collections::HashSet;
use std::sync::OnceLock;

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

    /// Whether a block has no edits yet.
    pub fn is_open(&self, block: usize) -> bool {
        self.of_block.get(block).is_none_or(|known| known.0 == u32::MAX)
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

    /// The index of the line that each block begins as it is written; one more for their number.
    pub fn first_lines(&self, program: &Program) -> Vec<usize> {
        let breaks = |text: &[u8]| memchr::memchr_iter(b'\n', text).count();
        let mut more = vec![0; program.blocks().len()];
        for edit in &self.edits {
            let new = self.text.get(edit.text.0 as usize..edit.text.1 as usize).unwrap_or(&[]);
            if let Some(slot) = more.get_mut(program.block_at(edit.start as usize)) {
                *slot += breaks(new);
            }
        }
        let mut line = 0;
        let mut first = Vec::with_capacity(more.len() + 1);
        for more in more {
            first.push(line);
            line += 1 + more;
        }
        first.push(line);
        first
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
    /// Writes a word into a block, where [`inserted`] has it.
    pub fn insert(&mut self, program: &Program, block: usize, letter: u8, write: impl FnOnce(&mut Vec<u8>)) {
        let (at, follows, space) = place(program, block, letter);
        self.replace(at, at, |text| {
            text.extend(if follows { space } else { b"" });
            text.push(letter);
            write(text);
            text.extend(if follows { b"" } else { space });
        });
    }
}

/// Where a word that a block has not is written into it, and its bytes with the space beside it.
pub fn inserted(program: &Program, block: usize, word: &[u8]) -> (usize, Vec<u8>) {
    let (at, follows, space) = place(program, block, word.first().copied().unwrap_or(0));
    (at, if follows { [space, word].concat() } else { [word, space].concat() })
}

/// Where a letter's word is written: behind N, codes and the letters before it (true), else before all; and the space
/// that goes between.
fn place(program: &Program, block: usize, letter: u8) -> (usize, bool, &'static [u8]) {
    const ORDER: &[u8] = b"NGXUYVZWABCRIJKF";
    let rank = |letter: u8| ORDER.iter().position(|known| *known == letter);
    let (words, mine) = (program.words_of(block), rank(letter));
    let named = words.iter().find(|word| word.kind == WordKind::Name).map(|word| word.start);
    let rank_of = |word: &Word| match word.kind {
        WordKind::Label => rank(b'N'),
        WordKind::Name if named == Some(word.start) => rank(b'G'),
        _ => rank(word.letter).filter(|_| is_value(word)),
    };
    let before = words.iter().rev().find(|word| rank_of(word).is_some_and(|other| Some(other) <= mine));
    let (start, end) = program.blocks().get(block).map_or((0, 0), |found| (found.start as usize, found.end as usize));
    let space: &[u8] = if is_spaced(program, block) && end > start { b" " } else { b"" };
    let at = before.map_or(words.first().map_or(start, |word| word.start as usize), Word::end);
    (at, before.is_some(), space)
}

/// Whether a block's words are set apart; a single word says nothing and counts as such.
fn is_spaced(program: &Program, block: usize) -> bool {
    let words = program.words_of(block);
    program.dialect().formulas || words.len() < 2 || words.windows(2).any(|pair| pair[0].end() < pair[1].start as usize)
}

/// A number further on than this many blocks is not looked for.
const FURTHER: usize = 100;

/// The numbers of all blocks of a program, looked for once: a search for one, or a jump, is to find the block that had it.
#[derive(Debug, Default)]
pub struct BlockNumbers(OnceLock<HashSet<usize>>);

impl BlockNumbers {
    fn of(&self, program: &Program) -> &HashSet<usize> {
        self.0.get_or_init(|| program.words().iter().filter_map(|word| number_of(program, word)).collect())
    }
}

/// Writes blocks after one, each on its line: N0420 is followed by N0421, N0422 …, without numbers where they do not fit
/// before the next number, another block has one of them, or the program has none. A number that is to stand at the `last`
/// of them is the only one.
pub fn new_lines(
    program: &Program,
    block: usize,
    texts: &[Vec<u8>],
    last: Option<&Word>,
    taken: &BlockNumbers,
    out: &mut Vec<u8>,
) {
    let free = |own: usize| (1..=texts.len()).all(|step| !taken.of(program).contains(&(own + step)));
    let numbers = numbers(program, block, texts.len()).filter(|(own, ..)| last.is_none() && free(*own));
    for (index, text) in texts.iter().enumerate() {
        out.extend(line_ending(program.source()));
        if let Some((number, letter, width, space)) = numbers {
            out.push(letter);
            out.extend(format!("{:0width$}", number + 1 + index).bytes());
            out.extend(space);
        }
        if let Some(number) = last.filter(|_| index + 1 == texts.len()) {
            out.extend(program.text(number));
            out.push(b' ');
        }
        out.extend(text);
    }
}

/// Number of the block, its letter, its width, and the space after it, where `count` numbers fit after it.
fn numbers(program: &Program, block: usize, count: usize) -> Option<(usize, u8, usize, &[u8])> {
    let number = |block: usize| program.words_of(block).iter().find_map(|word| Some((word, number_of(program, word)?)));
    let (word, own) = number(block)?;
    let next = (block + 1..program.blocks().len()).take(FURTHER).find_map(number);
    if next.is_some_and(|(_, next)| next <= own + count) {
        return None;
    }
    let rest = program.source().get(word.end()..)?;
    let space = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    let letter = *program.text(word).first()?;
    Some((own, letter, usize::from(word.length) - 1, if space == 0 { b" " } else { rest.get(..space)? }))
}

/// The number of a block, by its word N. Numbers without a letter are the control's: it counts anew.
fn number_of(program: &Program, word: &Word) -> Option<usize> {
    let is_number = word.letter == b'N' && word.kind == WordKind::Number && (0.0..1e9).contains(&word.value);
    (is_number && !program.text(word)[0].is_ascii_digit()).then_some(word.value as usize)
}

/// That of the source.
pub(crate) fn line_ending(source: &[u8]) -> &'static [u8] {
    match memchr::memchr(b'\n', source) {
        Some(at) if at > 0 && source.get(at - 1) == Some(&b'\r') => b"\r\n",
        _ => b"\n",
    }
}
