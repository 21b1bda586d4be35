//! The lexer: lays blocks and words over the bytes in one pass. Every byte belongs to a word or to what lies between.

use crate::dialect::{Class, Dialect};
use crate::number;
use crate::program::{Block, Word, WordKind};

/// Blocks and words of a source shorter than 4 GiB.
pub fn lex(source: &[u8], dialect: &Dialect) -> (Vec<Block>, Vec<Word>) {
    let lines = memchr::memchr_iter(b'\n', source).count() + 1;
    let mut lexer = Lexer {
        source,
        dialect,
        blocks: Vec::with_capacity(lines),
        words: Vec::with_capacity(source.len() / 8 + 1),
        at: 0,
    };
    while lexer.at < source.len() {
        lexer.block();
    }
    (lexer.blocks, lexer.words)
}

struct Lexer<'a> {
    source: &'a [u8],
    dialect: &'a Dialect,
    blocks: Vec<Block>,
    words: Vec<Word>,
    at: usize,
}

impl Lexer<'_> {
    fn block(&mut self) {
        let start = self.at;
        let first_word = self.words.len();
        let (mut optional, mut tape_mark) = (false, false);
        while let Some(class) = self.class(self.at) {
            match class {
                Class::LineEnd => break,
                Class::Space => self.at += 1,
                Class::Letter => self.word(),
                Class::LineComment => self.at = self.line_end(self.at),
                Class::Comment => self.comment(),
                Class::Statement => self.statement(),
                Class::Slash if self.words.len() == first_word && !optional => {
                    optional = true;
                    self.at += 1;
                }
                Class::Percent if self.words.len() == first_word => {
                    tape_mark = true;
                    self.at = self.line_end(self.at);
                }
                Class::Parameter => self.assignment(),
                Class::Slash | Class::Percent | Class::Other => self.unknown(self.at),
            }
        }
        let mut end = self.at;
        if end > start && self.source.get(end - 1) == Some(&b'\r') {
            end -= 1;
        }
        self.blocks.push(Block {
            start: start as u32,
            end: end as u32,
            first_word: first_word as u32,
            optional,
            tape_mark,
        });
        self.at += 1;
    }

    #[inline]
    fn class(&self, at: usize) -> Option<Class> {
        self.source.get(at).map(|byte| self.dialect.class(*byte))
    }

    fn line_end(&self, at: usize) -> usize {
        self.source
            .get(at..)
            .and_then(|rest| memchr::memchr(b'\n', rest))
            .map_or(self.source.len(), |found| at + found)
    }

    fn skip_space(&self, mut at: usize) -> usize {
        while self.class(at) == Some(Class::Space) {
            at += 1;
        }
        at
    }

    #[inline]
    fn word(&mut self) {
        let start = self.at;
        let letter = self.source.get(start).map_or(0, u8::to_ascii_uppercase);
        if let Some((value, end)) = number::read(self.source, start + 1) {
            if self.number_ends(end) && !(letter == b'O' && self.dialect.flow) {
                self.push(Word {
                    value,
                    ..word(start, end, letter, WordKind::Number)
                });
                return;
            }
        }
        self.word_slowly(start, letter);
    }

    /// Whether a number is over at `end`: nothing follows that would make it another kind of word.
    #[inline]
    fn number_ends(&self, end: usize) -> bool {
        match self.source.get(end) {
            Some(b'=' | b',') => false,
            Some(b' ' | b'\t') if self.dialect.spaced_numbers => !matches!(
                self.source.get(self.skip_space(end)),
                Some(b'0'..=b'9' | b'.')
            ),
            Some(b' ' | b'\t') => self.source.get(self.skip_space(end)) != Some(&b'='),
            _ => true,
        }
    }

    fn word_slowly(&mut self, start: usize, letter: u8) {
        if letter == b'O' && self.dialect.flow {
            return self.flow(start);
        }
        if let Some(word) = self.numbered_assignment(start, letter) {
            return self.push(word);
        }
        if let Some(word) = self.odd_number(start, letter) {
            return self.push(word);
        }
        match self.expression_end(start + 1) {
            Some(end) => self.push(word(start, end, letter, WordKind::Expression)),
            None => self.unknown(start),
        }
    }

    fn push(&mut self, word: Word) {
        self.at = word.end as usize;
        self.words.push(word);
    }

    /// `P42=(P42-0.02)`, `P1=0.15`: a parameter mark that is a letter, digits, equals sign, value.
    fn numbered_assignment(&self, start: usize, letter: u8) -> Option<Word> {
        if letter != self.dialect.parameters.mark {
            return None;
        }
        let (index, end) = number::read(self.source, start + 1)?;
        let equals = self.skip_space(end);
        if self.source.get(equals) != Some(&b'=') {
            return None;
        }
        let end = self.value_end(equals + 1)?;
        Some(Word {
            value: index,
            ..word(start, end, letter, WordKind::Assignment)
        })
    }

    /// Numbers with white space or a decimal comma in them, where the dialect has such.
    fn odd_number(&self, start: usize, letter: u8) -> Option<Word> {
        let mut digits = Vec::new();
        let (mut at, mut comma, mut end) = (start + 1, false, start + 1);
        while let Some(&byte) = self.source.get(at) {
            match byte {
                b'+' | b'-' if digits.is_empty() => digits.push(byte),
                b'0'..=b'9' | b'.' => digits.push(byte),
                b',' if self.dialect.decimal_comma && !comma && self.digits_around(at) => {
                    comma = true;
                    digits.push(b'.');
                }
                b' ' | b'\t' if self.dialect.spaced_numbers || digits.is_empty() => {
                    at += 1;
                    continue;
                }
                _ => break,
            }
            at += 1;
            end = at;
        }
        let (value, used) = number::read(&digits, 0)?;
        (used == digits.len()).then(|| Word {
            value,
            decimal_comma: comma,
            ..word(start, end, letter, WordKind::Number)
        })
    }

    fn digits_around(&self, at: usize) -> bool {
        let digit = |at: usize| self.source.get(at).is_some_and(u8::is_ascii_digit);
        at > 0 && digit(at - 1) && digit(at + 1)
    }

    fn value_end(&self, at: usize) -> Option<usize> {
        let at = self.skip_space(at);
        match number::read(self.source, at) {
            Some((_, end)) => Some(end),
            None => self.expression_end(at),
        }
    }

    /// End of a value to be computed: signs, then brackets, a parameter or a function.
    fn expression_end(&self, at: usize) -> Option<usize> {
        let mut at = self.skip_space(at);
        while matches!(self.source.get(at), Some(b'+' | b'-')) {
            at = self.skip_space(at + 1);
        }
        let byte = *self.source.get(at)?;
        if byte == self.dialect.brackets.0 {
            return self.bracket_end(at);
        }
        if byte == self.dialect.parameters.mark && self.dialect.parameters.named {
            return self.parameter_end(at);
        }
        if self.dialect.functions && byte.is_ascii_alphabetic() {
            return self.function_end(at);
        }
        None
    }

    /// One past the bracket that closes the one at `at`, within the line.
    fn bracket_end(&self, at: usize) -> Option<usize> {
        let (open, close) = self.dialect.brackets;
        let mut depth = 0usize;
        for (offset, &byte) in self.source.get(at..)?.iter().enumerate() {
            if byte == open {
                depth += 1;
            } else if byte == close {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return Some(at + offset + 1);
                }
            } else if byte == b'\n' || self.dialect.class(byte) == Class::LineComment {
                return None;
            }
        }
        None
    }

    /// End of `#12`, `##3`, `#<name>`, `#[…]`.
    fn parameter_end(&self, mut at: usize) -> Option<usize> {
        while self.source.get(at) == Some(&b'#') {
            at = self.skip_space(at + 1);
        }
        match *self.source.get(at)? {
            b'<' => self.name_end(at),
            b'0'..=b'9' => {
                while self.source.get(at).is_some_and(u8::is_ascii_digit) {
                    at += 1;
                }
                Some(at)
            }
            _ => self.expression_end(at),
        }
    }

    fn name_end(&self, at: usize) -> Option<usize> {
        let line = self.source.get(at..self.line_end(at))?;
        memchr::memchr(b'>', line).map(|found| at + found + 1)
    }

    /// End of `SIN[…]`, `ATAN[…]/[…]`.
    fn function_end(&self, at: usize) -> Option<usize> {
        let mut open = at;
        while self.source.get(open).is_some_and(u8::is_ascii_alphabetic) {
            open += 1;
        }
        let name = self.source.get(at..open)?;
        let end = self.bracket_end_after(open)?;
        if !name.eq_ignore_ascii_case(b"atan") {
            return Some(end);
        }
        let slash = self.skip_space(end);
        if self.source.get(slash) != Some(&b'/') {
            return None;
        }
        self.bracket_end_after(slash + 1)
    }

    fn bracket_end_after(&self, at: usize) -> Option<usize> {
        let at = self.skip_space(at);
        (self.source.get(at) == Some(&self.dialect.brackets.0))
            .then(|| self.bracket_end(at))
            .flatten()
    }

    /// `#1=5`, `#<depth>=[#1*2]`.
    fn assignment(&mut self) {
        let start = self.at;
        let end = self.parameter_end(start).and_then(|end| {
            let equals = self.skip_space(end);
            (self.source.get(equals) == Some(&b'=')).then_some(equals + 1)
        });
        match end.and_then(|value| self.value_end(value)) {
            Some(end) => self.push(word(
                start,
                end,
                self.dialect.parameters.mark,
                WordKind::Assignment,
            )),
            None => self.unknown(start),
        }
    }

    fn comment(&mut self) {
        let line_end = self.line_end(self.at);
        let rest = self.source.get(self.at..line_end).unwrap_or(&[]);
        match memchr::memchr(b')', rest) {
            Some(found) => self.at += found + 1,
            None => self.unknown_to(self.at, line_end),
        }
    }

    fn statement(&mut self) {
        match self.bracket_end(self.at) {
            Some(end) => self.push(word(self.at, end, 0, WordKind::Statement)),
            None => self.unknown_to(self.at, self.line_end(self.at)),
        }
    }

    /// A flow control line: everything up to a comment.
    fn flow(&mut self, start: usize) {
        let mut end = start + 1;
        let mut at = end;
        while let Some(class) = self.class(at) {
            match class {
                Class::LineEnd | Class::LineComment | Class::Comment => break,
                Class::Space => at += 1,
                _ => {
                    at += 1;
                    end = at;
                }
            }
        }
        self.push(word(start, end, b'O', WordKind::Flow));
    }

    /// Text that is no word: up to the next white space or comment.
    fn unknown(&mut self, start: usize) {
        let mut end = start + 1;
        while let Some(class) = self.class(end) {
            if matches!(
                class,
                Class::LineEnd | Class::Space | Class::LineComment | Class::Comment
            ) {
                break;
            }
            end += 1;
        }
        self.unknown_to(start, end);
    }

    fn unknown_to(&mut self, start: usize, end: usize) {
        self.push(word(start, end, 0, WordKind::Unknown));
    }
}

const fn word(start: usize, end: usize, letter: u8, kind: WordKind) -> Word {
    Word {
        value: f64::NAN,
        start: start as u32,
        end: end as u32,
        letter,
        kind,
        decimal_comma: false,
    }
}
