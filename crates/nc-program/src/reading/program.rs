//! A program: its bytes, and the blocks and words laid over them.

use bytes::Bytes;

use crate::dialect::{Class, Dialect, FlowStyle, Name, G, M};
use crate::reading::lex;
use crate::reading::names;

/// What a word is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum WordKind {
    /// A letter and a number: `X30.4`.
    Number,
    /// A letter and something to be computed: `X(P46+0.0625)`, `X#1`.
    Expression,
    /// A value given to a parameter: `P42=(P42-0.02)`, `#<depth>=2`. The letter is the parameter mark.
    Assignment,
    /// A statement in parentheses: `(UPD, 1, TOV(X), 0.00000)`.
    Statement,
    /// A line of flow control: `o100 while [#1 LT 5]`.
    Flow,
    /// A word of more than a letter that is no address: `DIAMON`. The value is its place in the dialect's list.
    Name,
    /// Where a jump may lead: `AGAIN:`.
    Label,
    /// The name of a program to be run: `POCKET(5)`.
    Call,
    /// Text the dialect does not know; kept as it is.
    Unknown,
}

/// A word of a block, as a span of the source.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// The number after the letter, or of the parameter that is assigned, or the place of a name; NaN without one.
    pub value: f64,
    /// First byte.
    pub start: u32,
    /// Length in bytes: what is longer is no word.
    pub length: u16,
    /// The address letter in upper case, in lower case after a comma; the parameter mark of an assignment; 0 for a statement and unknown text.
    pub letter: u8,
    /// What it is.
    pub kind: WordKind,
}

impl Word {
    /// One past the last byte.
    pub fn end(&self) -> usize {
        self.start as usize + usize::from(self.length)
    }
}

/// A block: one line of the source.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// First byte.
    pub start: u32,
    /// One past the last byte, the line end (LF or CRLF) not counted.
    pub end: u32,
    /// Index of its first word.
    pub first_word: u32,
    /// Starts with a slash: run only when the operator says so.
    pub optional: bool,
    /// A `%` line: the ends of the tape.
    pub tape_mark: bool,
}

/// A source of 2 GiB or more: positions are 31 bits wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// Size in bytes.
    pub bytes: usize,
}

/// A program as read.
#[derive(Clone, Debug)]
pub struct Program {
    source: Bytes,
    dialect: &'static Dialect,
    blocks: Vec<Block>,
    words: Vec<Word>,
}

impl Program {
    /// Lays blocks and words over the source, which is not copied. Any bytes can be read.
    pub fn read(source: impl Into<Bytes>, dialect: &'static Dialect) -> Result<Self, TooLarge> {
        let source = source.into();
        if i32::try_from(source.len()).is_err() {
            return Err(TooLarge { bytes: source.len() });
        }
        let (blocks, words) = lex::lex(&source, dialect);
        Ok(Self { source, dialect, blocks, words })
    }

    /// The bytes, as they were read.
    pub fn source(&self) -> &[u8] {
        &self.source
    }

    /// The dialect it was read in.
    pub fn dialect(&self) -> &'static Dialect {
        self.dialect
    }

    /// The blocks: block i is line i + 1.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// All words, in order.
    pub fn words(&self) -> &[Word] {
        &self.words
    }

    /// The word of that index; `None` below zero, where no word set a thing.
    pub fn word(&self, index: i32) -> Option<&Word> {
        usize::try_from(index).ok().and_then(|index| self.words.get(index))
    }

    /// Range of indices of a block's words.
    pub fn word_range(&self, block: usize) -> std::ops::Range<usize> {
        let total = self.words.len();
        let first = self.blocks.get(block).map_or(total, |found| found.first_word as usize);
        let after = self.blocks.get(block + 1).map_or(total, |next| next.first_word as usize);
        first..after
    }

    /// The words of a block.
    pub fn words_of(&self, block: usize) -> &[Word] {
        self.words.get(self.word_range(block)).unwrap_or(&[])
    }

    /// The text of a word.
    pub fn text(&self, word: &Word) -> &[u8] {
        self.source.get(word.start as usize..word.end()).unwrap_or(&[])
    }

    /// Where the value of a word starts: after its letter, after the equals sign of an assignment.
    pub fn value_start(&self, word: &Word) -> usize {
        let (mut at, end) = (word.start as usize, word.end());
        match word.kind {
            WordKind::Assignment => at = memchr::memchr(b'=', self.text(word)).map_or(end, |offset| at + offset + 1),
            WordKind::Expression if self.text(word).first() == Some(&b',') => at += 2,
            WordKind::Number | WordKind::Expression => at += self.address_length(word),
            _ => return at,
        }
        while at < end && self.source.get(at).is_some_and(|byte| self.dialect.class(*byte) == Class::Space) {
            at += 1;
        }
        at
    }

    /// Length of what stands before the value: a letter, or a name, with the equals sign after it.
    fn address_length(&self, word: &Word) -> usize {
        let (start, end) = (word.start as usize, word.end());
        let text = self.source.get(..end).unwrap_or(&[]);
        if self.dialect.names.is_empty() {
            return 1;
        }
        if text.get(start).is_some_and(u8::is_ascii_digit) {
            return 0;
        }
        let named = names::meaning(text, start, self.dialect);
        let address = named.filter(|(name, _)| matches!(name, Name::Address(_) | Name::Increment(_)));
        let after = address.map_or(start + 1, |(_, after)| after);
        let equals = names::skip(text, after, |byte| byte == b' ' || byte == b'\t');
        // `X1.5` is X and 1.5: only with an equals sign is X1 an axis of that name.
        let numbered = text.get(start + 1..after).is_some_and(|rest| rest.iter().all(u8::is_ascii_digit));
        match text.get(equals) {
            Some(b'=') => equals + 1 - start,
            _ if numbered => 1,
            _ => after - start,
        }
    }

    /// Whether a word says that its value is an increment (true) or a position (false): `X=IC(5)`, `IX+5`.
    #[inline]
    pub fn reference(&self, word: &Word) -> Option<bool> {
        if self.dialect.names.is_empty() || !matches!(word.kind, WordKind::Number | WordKind::Expression) {
            return self.dialect.increments.filter(|letters| letters.contains(&word.letter)).map(|_| true);
        }
        self.reference_of_name(word)
    }

    fn reference_of_name(&self, word: &Word) -> Option<bool> {
        if let Some((Name::Increment(_), _)) = names::meaning(&self.source, word.start as usize, self.dialect) {
            return Some(true);
        }
        let at = self.value_start(word);
        let end = names::name_end(&self.source, at).filter(|_| word.kind == WordKind::Expression)?;
        let name = self.source.get(at..end)?.to_ascii_uppercase();
        let bracket = names::skip(&self.source, end, |byte| byte == b' ');
        self.source.get(bracket).filter(|byte| **byte == b'(')?;
        match name.as_slice() {
            b"IC" => Some(true),
            b"AC" | b"DC" | b"ACP" | b"ACN" => Some(false),
            _ => None,
        }
    }

    /// Whether a text within a block leaves out the words after it, where the operator has that switched on: `/`, `/2`.
    pub fn begins_skip(&self, word: &Word) -> bool {
        let text = self.text(word);
        let level = text.strip_prefix(b"/").is_some_and(|rest| rest.is_empty() || matches!(rest, [b'1'..=b'9']));
        word.kind == WordKind::Unknown && self.dialect.rules.slash_within && level
    }

    /// Whether a block leads to or from a contour on a way of the control's own (APPR, DEP).
    pub fn leads(&self, block: i32) -> bool {
        let coded = |word: &Word| matches!(self.code(word), Some(G::Approach | G::Leave(_)));
        self.dialect.flow == FlowStyle::Labels && self.words_of(block as usize).iter().any(coded)
    }

    /// What a word does as a code, where it is one that the dialect knows: `G01`, `TRANS`, `L`.
    #[inline]
    pub fn code(&self, word: &Word) -> Option<G> {
        match (word.kind, word.letter) {
            (WordKind::Number, b'G') => self.dialect.g_code(word.value),
            (WordKind::Name, _) => match self.dialect.names.get(word.value as usize) {
                Some(Name::Code(code) | Name::Text(code)) => Some(code),
                _ => None,
            },
            _ => None,
        }
    }

    /// Index of the block that holds a byte.
    pub fn block_at(&self, offset: usize) -> usize {
        self.blocks.partition_point(|block| block.start as usize <= offset).saturating_sub(1)
    }
}

/// What a G code, or a word that acts as one, does (`Dwell`, `Drill(Tap)`), an M code with an `M` before it (`MEnd`);
/// `None` for what is none.
pub fn meaning(program: &Program, word: &Word) -> Option<String> {
    let dialect = program.dialect();
    match (word.kind, word.letter) {
        (WordKind::Number, b'G') => dialect.g_code(word.value).map(of_g),
        (WordKind::Number, b'M') => dialect.m_code(word.value).map(of_m),
        (WordKind::Name, _) => match dialect.names.get(word.value as usize)? {
            Name::Code(code) | Name::Text(code) => Some(of_g(code)),
            Name::Function(function) => Some(of_m(function)),
            Name::Inert => Some(of_g(G::Inert)),
            _ => None,
        },
        _ => None,
    }
}

fn of_g(code: G) -> String {
    match code {
        G::Setting(..) | G::ToleranceCycle => of_g(G::Inert),
        _ => format!("{code:?}"),
    }
}

fn of_m(function: M) -> String {
    format!("M{function:?}")
}
