//! The lexer: lays blocks and words over the bytes in one pass. Every byte belongs to a word or to what lies between.

use crate::dialect::{Blanks, Class, Dialect, FlowStyle, G};
use crate::modes::codes;
use crate::order::flow::skip_blank;
use crate::order::macros;
use crate::reading::names;
use crate::reading::number;
use crate::reading::program::{Block, Word, WordKind};
use crate::reading::scan::Scanner;
use crate::shapes::curve::{POLAR_ANGLE, POLAR_RADIUS};

/// What a comma may stand before: angle, chamfer, rounding. Any other letter would be a coordinate that is lost.
const CORNERS: [u8; 3] = *b"acr";

/// Words are seldom shorter on the average: a list of words that grows is copied, memory never filled costs nothing.
const LEAST_BYTES_A_WORD: usize = 4;

/// What editors put before a text in UTF-8. It stands before the first block and belongs to none.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Blocks and words of a source shorter than 4 GiB.
pub(crate) fn lex(source: &[u8], dialect: &Dialect) -> (Vec<Block>, Vec<Word>) {
    let lines = memchr::memchr_iter(b'\n', source).count() + 1;
    let mut lexer = Lexer {
        source,
        dialect,
        scanner: Scanner { source, dialect, gave_up_at: None },
        blocks: Vec::with_capacity(lines),
        words: Vec::with_capacity(source.len() / LEAST_BYTES_A_WORD + 1),
        at: if source.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 },
        remark_goes_on: false,
        beyond_tape: false,
        has_returns: memchr::memchr(b'\r', source).is_some(),
        has_polar: dialect.g_code(16.0) == Some(G::Polar(true)),
        polar: false,
    };
    while lexer.at < source.len() {
        lexer.block();
    }
    (lexer.blocks, lexer.words)
}

/// The lexer at a byte of its source.
pub(crate) struct Lexer<'a> {
    pub source: &'a [u8],
    pub dialect: &'a Dialect,
    pub scanner: Scanner<'a>,
    blocks: Vec<Block>,
    words: Vec<Word>,
    at: usize,
    /// The line before was a remark that goes on in this one.
    remark_goes_on: bool,
    /// A `%` has ended the tape, and no program has begun since.
    beyond_tape: bool,
    has_returns: bool,
    /// The dialect has polar coordinates of G16.
    has_polar: bool,
    /// They are in force, in the order in which blocks are written.
    polar: bool,
}

impl Lexer<'_> {
    fn block(&mut self) {
        let start = self.at;
        let first_word = self.words.len();
        let (mut optional, mut tape_mark) = (false, false);
        if self.remark_goes_on || self.is_beyond_tape() {
            self.at = self.scanner.line_end(self.at);
        }
        while let Some(class) = self.after_words() {
            let first = self.words.len() == first_word;
            match class {
                Class::LineEnd => break,
                _ if first && self.is_remark() => self.at = self.scanner.line_end(self.at),
                Class::Name if first && self.is_file_name() => self.at = self.scanner.line_end(self.at),
                Class::Name => self.word_slowly(self.at, self.letter(self.at)),
                Class::LineComment => self.at = self.scanner.line_end(self.at),
                Class::BlockEnd if self.ends_block() => self.at += 1,
                Class::BlockEnd if self.precedes_prose() => self.at = self.scanner.line_end(self.at),
                Class::Comment => self.comment(),
                Class::Statement => self.statement(),
                Class::Parameter => self.assignment(),
                Class::Comma => self.comma_word(),
                Class::Slash if first && !optional => {
                    optional = true;
                    self.at += 1;
                    self.skip_level();
                }
                _ if self.is_program_name(first_word) => {
                    let line = self.source.get(self.at..self.scanner.line_end(self.at)).unwrap_or(&[]);
                    self.at += memchr::memchr(b'>', line).map_or(line.len(), |end| end + 1);
                }
                Class::Percent if first => {
                    tape_mark = true;
                    self.beyond_tape = first_word > 0 && !self.beyond_tape;
                    self.at = self.scanner.line_end(self.at);
                }
                Class::Digit if first => self.block_number(),
                Class::Slash if self.dialect.rules.slash_within => self.slash_within(),
                // `F[#1*2].`: a point behind a value in brackets changes nothing.
                Class::Other if self.source.get(self.at) == Some(&b'.') && self.follows_feed() => self.at += 1,
                Class::Slash
                | Class::Percent
                | Class::Digit
                | Class::Space
                | Class::BlockEnd
                | Class::Letter
                | Class::Other => self.unknown(self.at),
            }
        }
        if self.has_returns && self.runs_on(start) {
            self.words.truncate(first_word);
            let end = self.at;
            self.push_unknown(start, self.without_return(start, end));
            self.at = end;
            (optional, tape_mark) = (false, false);
        }
        if self.has_polar {
            self.letter_polar(first_word);
        }
        let optional = optional || self.goes_on_skipped(start);
        let line = self.source.get(start..self.at).unwrap_or(&[]).trim_ascii();
        let begins = line.iter().find(|byte| !byte.is_ascii_digit() && **byte != b' ');
        let is_remark = self.remark_goes_on || begins == Some(&b';');
        self.remark_goes_on = is_remark && self.dialect.flow == FlowStyle::Labels && line.ends_with(b"~");
        let (start, end, first_word) = (start as u32, self.without_return(start, self.at) as u32, first_word as u32);
        self.blocks.push(Block { start, end, first_word, optional, tape_mark });
        self.at += 1;
    }

    /// Between G16 and G15, X and Y of a block that moves are radius and angle.
    fn letter_polar(&mut self, first_word: usize) {
        let dialect = self.dialect;
        let words = self.words.get_mut(first_word..).unwrap_or(&mut []);
        let codes = words.iter().filter(|word| word.letter == b'G' && word.kind == WordKind::Number);
        let mut acts = false;
        for code in codes.filter_map(|word| dialect.g_code(word.value)) {
            match code {
                G::Polar(on) => self.polar = on,
                code => acts |= codes::acts(code),
            }
        }
        let values = words.iter_mut().filter(|word| matches!(word.kind, WordKind::Number | WordKind::Expression));
        for word in values.filter(|_| self.polar && !acts) {
            word.letter = match word.letter {
                b'X' => POLAR_RADIUS,
                b'Y' => POLAR_ANGLE,
                other => other,
            };
        }
    }

    /// Whether a carriage return without a line feed stands within the line: blocks that end so cannot be told apart.
    fn runs_on(&self, start: usize) -> bool {
        let line = self.source.get(start..self.at).unwrap_or(&[]);
        memchr::memchr(b'\r', line.trim_ascii()).is_some()
    }

    /// Whether a line is a remark: no block of Klartext or Sinumerik begins with a bracket; set-up sheets above a program do.
    fn is_remark(&self) -> bool {
        matches!(self.dialect.flow, FlowStyle::Labels | FlowStyle::Structured)
            && self.source.get(self.at) == Some(&b'(')
    }

    /// Whether the end of a block is followed by prose: a word of two letters that begins no statement of a macro.
    fn precedes_prose(&self) -> bool {
        let at = names::skip_blank(self.source, self.at + 1);
        let word = self.source.get(at..at + 2).is_some_and(|letters| letters.iter().all(u8::is_ascii_alphabetic));
        word && !macros::begins(self.source, at) && !macros::writes_out(self.source, at)
    }

    /// Whether the line at hand is text behind the end of the tape, which the control does not read.
    fn is_beyond_tape(&mut self) -> bool {
        let line = self.source.get(self.at..self.scanner.line_end(self.at)).unwrap_or(&[]).trim_ascii_start();
        let begins = matches!(line.first(), Some(b'O' | b'o' | b':')) && line.get(1).is_some_and(u8::is_ascii_digit);
        self.beyond_tape &= !begins;
        self.beyond_tape && self.dialect.flow == FlowStyle::Macro && line.first() != Some(&b'%')
    }

    /// Whether a program's name in angle brackets comes next: behind its number, or in place of it.
    fn is_program_name(&self, first_word: usize) -> bool {
        self.dialect.flow == FlowStyle::Macro
            && self.source.get(self.at) == Some(&b'<')
            && matches!(self.words.get(first_word..), Some([] | [Word { letter: b'O', .. }]))
    }

    /// Whether a line goes on with an optional block: Q parameters behind one with `~`, or `$` of an OSP.
    fn goes_on_skipped(&self, start: usize) -> bool {
        let Some(before) = self.blocks.last().filter(|before| before.optional) else { return false };
        let first = self.source.get(start..self.at).and_then(|line| line.trim_ascii_start().first());
        let lines = self.source.get(before.start as usize..before.end as usize);
        match first {
            Some(b'Q' | b'q') => {
                self.dialect.flow == FlowStyle::Labels && lines.is_some_and(|line| line.contains(&b'~'))
            }
            Some(b'$') => self.dialect.rules.sequence_names,
            _ => false,
        }
    }

    /// Whether an F or S by a value in brackets ends here; words that a correction changes are to end with their value.
    fn follows_feed(&self) -> bool {
        let last = self.words.last().filter(|word| word.kind == WordKind::Expression && word.end() == self.at);
        last.is_some_and(|word| matches!(word.letter, b'F' | b'S'))
    }

    /// Whether only comments and further ends of a block follow on the line.
    fn ends_block(&self) -> bool {
        let mut rest = self.source.get(self.at + 1..self.scanner.line_end(self.at)).unwrap_or(&[]).trim_ascii_start();
        while let [first, after @ ..] = rest {
            let after = match self.dialect.class(*first) {
                Class::BlockEnd => Some(after),
                Class::Comment => after.iter().position(|&byte| byte == b')').and_then(|end| after.get(end + 1..)),
                _ => None,
            };
            let Some(after) = after else { return false };
            rest = after.trim_ascii_start();
        }
        true
    }

    /// Whether a line is the name under which an OSP sends its file: `$SHAFT.MIN%`.
    fn is_file_name(&self) -> bool {
        let line = self.source.get(self.at..self.scanner.line_end(self.at)).unwrap_or(&[]);
        self.dialect.rules.sequence_names && line.first() == Some(&b'$') && line.trim_ascii_end().ends_with(b"%")
    }

    /// Over the level of a leading slash: `/2 G00`, `/3N40`. Where blocks begin with their number it may be that.
    fn skip_level(&mut self) {
        let level = matches!(self.source.get(self.at), Some(b'1'..=b'9'));
        let ends = !self.source.get(self.at + 1).is_some_and(|next| next.is_ascii_digit() || *next == b'.');
        if level && ends && self.dialect.flow != FlowStyle::Labels && self.dialect.flow != FlowStyle::OWords {
            self.at += 1;
        }
    }

    /// A slash between two words, with its level.
    fn slash_within(&mut self) {
        let start = self.at;
        self.at += 1;
        self.skip_level();
        self.push_unknown(start, self.at);
    }

    /// What comes after white space and words that start with a letter, nearly all there is: between them the place is
    /// not told through memory.
    #[inline]
    fn after_words(&mut self) -> Option<Class> {
        let mut at = self.at;
        loop {
            let class = self.scanner.class(at);
            at = match class {
                Some(Class::Space) => at + 1,
                Some(Class::Letter) => self.word(at),
                _ => {
                    self.at = at;
                    return class;
                }
            }
        }
    }

    /// One past a word that starts with a letter.
    #[inline]
    fn word(&mut self, start: usize) -> usize {
        let letter = self.letter(start);
        self.number_word(start, letter).unwrap_or_else(|| {
            self.word_slowly(start, letter);
            self.at
        })
    }

    /// Where a word of a letter and a number ends.
    #[inline]
    fn number_word(&mut self, start: usize, letter: u8) -> Option<usize> {
        let (value, end) = number::read(self.source, start + 1)?;
        if !self.number_ends(end) || letter == b'O' && self.dialect.flow == FlowStyle::OWords {
            return None;
        }
        if value.is_infinite() {
            return None; // some hundred digits: no control takes them
        }
        let length = u16::try_from(end - start).ok()?;
        self.words.push(Word { value, start: start as u32, length, letter, kind: WordKind::Number });
        Some(end)
    }

    /// The letter at which a word starts, in upper case; that of a polar coordinate for its mark, O for a colon.
    #[inline]
    fn letter(&self, at: usize) -> u8 {
        match self.source.get(at) {
            Some(b'@') => POLAR_RADIUS,
            Some(b'^') => POLAR_ANGLE,
            Some(b':') => b'O',
            byte => byte.map_or(0, u8::to_ascii_uppercase),
        }
    }

    /// `12` at a line's start.
    fn block_number(&mut self) {
        let start = self.at;
        let end = names::skip(self.source, start, |byte| byte.is_ascii_digit());
        let number = self.source.get(start..end).unwrap_or(&[]);
        match number::read(number, 0).filter(|(value, _)| value.is_finite()) {
            Some((value, _)) => self.push(start, end, b'N', WordKind::Number, value),
            None => self.push_unknown(start, end),
        }
    }

    /// Whether a number is over at `end`: nothing follows that would make it another kind of word.
    #[inline]
    fn number_ends(&self, end: usize) -> bool {
        match self.source.get(end) {
            Some(b'=' | b',' | b'.') => false,
            Some(b' ' | b'\t') => {
                let next = self.source.get(self.scanner.skip_space(end));
                let goes_on = self.dialect.blanks == Blanks::WithinNumber && matches!(next, Some(b'0'..=b'9' | b'.'));
                !(goes_on || next == Some(&b'='))
            }
            _ => true,
        }
    }

    fn word_slowly(&mut self, start: usize, letter: u8) {
        if letter == b'O' && self.dialect.flow == FlowStyle::OWords
            || self.dialect.flow == FlowStyle::Macro && macros::begins(self.source, start)
        {
            return self.flow(start);
        }
        if !self.dialect.names.is_empty() && self.named_word(start, letter) {
            return;
        }
        if self.dialect.flow == FlowStyle::Macro && macros::writes_out(self.source, start) {
            return self.push(start, self.text_end(start + 1), 0, WordKind::Statement, f64::NAN);
        }
        if let Some((index, end)) = self.numbered_assignment(start, letter) {
            return self.push(start, end, letter, WordKind::Assignment, index);
        }
        if let Some((value, end)) = self.odd_number(start + 1) {
            return self.push(start, end, letter, WordKind::Number, value);
        }
        match self.scanner.expression_end(start + 1) {
            Some(end) => self.push(start, end, letter, WordKind::Expression, f64::NAN),
            None => self.unknown(start),
        }
    }

    #[inline]
    pub(crate) fn push(&mut self, start: usize, end: usize, letter: u8, kind: WordKind, value: f64) {
        let Ok(length) = u16::try_from(end - start) else { return self.push_unknown(start, end) };
        self.words.push(Word { value, start: start as u32, length, letter, kind });
        self.at = end;
    }

    /// Text that is no word, in pieces where it is longer than a word can be.
    fn push_unknown(&mut self, start: usize, end: usize) {
        let mut at = start;
        while at < end {
            let length = u16::try_from(end - at).unwrap_or(u16::MAX);
            self.words.push(Word { value: f64::NAN, start: at as u32, length, letter: 0, kind: WordKind::Unknown });
            at += usize::from(length);
        }
        self.at = end;
    }

    /// `P42=(P42-0.02)`, `P1=0.15`: a parameter mark that is a letter, digits, equals sign, value.
    fn numbered_assignment(&mut self, start: usize, letter: u8) -> Option<(f64, usize)> {
        if letter != self.dialect.parameters.mark {
            return None;
        }
        let (index, end) = number::read(self.source, start + 1)?;
        let equals = self.scanner.skip_space(end);
        if self.source.get(equals) != Some(&b'=') {
            return None;
        }
        Some((index, self.scanner.value_end(equals + 1)?))
    }

    /// Numbers with white space or a decimal comma in them, where the dialect has such.
    pub(crate) fn odd_number(&self, start: usize) -> Option<(f64, usize)> {
        let spaced = self.dialect.blanks == Blanks::BeforeNumber;
        let start = if spaced { self.scanner.skip_space(start) } else { start };
        if !matches!(self.source.get(start)?, b'0'..=b'9' | b'.' | b',' | b'+' | b'-' | b' ' | b'\t') {
            return None;
        }
        let mut digits = Vec::new();
        let (mut at, mut comma, mut end) = (start, false, start);
        while let Some(&byte) = self.source.get(at) {
            at += 1;
            match byte {
                b'+' | b'-' if digits.is_empty() => digits.push(byte),
                b'0'..=b'9' | b'.' => digits.push(byte),
                b',' if self.dialect.decimal_comma && !comma && self.between_digits(at - 1) => {
                    comma = true;
                    digits.push(b'.');
                }
                b' ' | b'\t' if self.dialect.blanks == Blanks::WithinNumber => continue,
                _ => break,
            }
            end = at;
        }
        let (value, used) = number::read(&digits, 0)?;
        (used == digits.len() && value.is_finite()).then_some((value, end))
    }

    fn between_digits(&self, at: usize) -> bool {
        let digit = |at: usize| self.source.get(at).is_some_and(u8::is_ascii_digit);
        at > 0 && digit(at - 1) && digit(at + 1)
    }

    /// `#1=5`, `#<depth>=[#1*2]`.
    fn assignment(&mut self) {
        let start = self.at;
        match self.assignment_end(start) {
            Some(end) => self.push(start, end, self.dialect.parameters.mark, WordKind::Assignment, f64::NAN),
            None => self.unknown(start),
        }
    }

    fn assignment_end(&mut self, start: usize) -> Option<usize> {
        let name_end = self.scanner.parameter_end(start)?;
        let equals = self.scanner.skip_space(name_end);
        if self.source.get(equals) != Some(&b'=') {
            return None;
        }
        if self.dialect.flow == FlowStyle::Macro {
            return Some(self.text_end(equals + 1));
        }
        self.scanner.value_end(equals + 1)
    }

    fn comment(&mut self) {
        let rest = self.source.get(self.at..).unwrap_or(&[]);
        let end = memchr::memchr2(b')', b'\n', rest).map_or(self.source.len(), |found| self.at + found);
        if self.source.get(end) == Some(&b')') {
            self.at = end + 1;
        } else {
            self.push_unknown(self.at, self.without_return(self.at, end));
        }
    }

    /// An end of line without the carriage return before it.
    fn without_return(&self, start: usize, end: usize) -> usize {
        let both = end > start && self.source.get(end - 1..=end) == Some(b"\r\n");
        end - usize::from(both)
    }

    fn statement(&mut self) {
        match self.scanner.bracket_end(self.at) {
            Some(end) => self.push(self.at, end, 0, WordKind::Statement, f64::NAN),
            None => self.unknown(self.at),
        }
    }

    /// `,R0.5`: a corner between this block and the next; its letter in lower case.
    fn comma_word(&mut self) {
        let start = self.at;
        let letter = self.source.get(start + 1).map_or(0, u8::to_ascii_lowercase);
        match self.scanner.value_end(start + 2).filter(|_| CORNERS.contains(&letter)) {
            Some(end) => self.push(start, end, letter, WordKind::Expression, f64::NAN),
            None => self.unknown(start),
        }
    }

    /// A flow control line: everything up to a comment.
    fn flow(&mut self, start: usize) {
        let mut end = self.text_end(start + 1);
        if self.dialect.flow == FlowStyle::OWords {
            // A comment may stand between its arguments.
            while let Some(more) = self.after_comment(end) {
                end = self.text_end(more + 1);
            }
        }
        self.push(start, end, b'O', WordKind::Flow, f64::NAN);
    }

    /// Where the text of a line goes on after the comment that follows a byte.
    fn after_comment(&self, end: usize) -> Option<usize> {
        let at = skip_blank(self.source, end);
        let goes_on = !matches!(
            self.scanner.class(at),
            None | Some(Class::LineEnd | Class::LineComment | Class::BlockEnd | Class::Comment)
        );
        (at > self.scanner.skip_space(end) && goes_on).then_some(at)
    }

    /// Where the text of a block ends that starts before `end`: at a comment or the line's end, less white space.
    pub(crate) fn text_end(&self, mut end: usize) -> usize {
        let mut at = end;
        while let Some(class) = self.scanner.class(at) {
            if matches!(class, Class::LineEnd | Class::LineComment | Class::BlockEnd | Class::Comment) {
                break;
            }
            at += 1;
            if class != Class::Space {
                end = at;
            }
        }
        end
    }

    /// Text that is no word: up to the next white space or comment; up to where a search for a bracket gave up.
    pub(crate) fn unknown(&mut self, start: usize) {
        let mut end = self.scanner.gave_up_at.take().unwrap_or(start + 1).max(start + 1);
        while let Some(class) = self.scanner.class(end) {
            if matches!(class, Class::LineEnd | Class::Space | Class::LineComment | Class::BlockEnd | Class::Comment) {
                break;
            }
            end += 1;
        }
        self.push_unknown(start, self.without_return(start, end));
    }
}
