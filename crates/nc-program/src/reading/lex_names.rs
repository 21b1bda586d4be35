//! Words of more than a letter, as the lexer meets them: names of the dialect's list, variables, labels, calls.

use crate::dialect::{FlowStyle, Naming, G};
use crate::reading::lex::Lexer;
use crate::reading::names::{self, Name};
use crate::reading::number;
use crate::reading::program::WordKind;

impl Lexer<'_> {
    /// A word of more than a letter, or a letter with an equals sign; false where there is none.
    pub(crate) fn named_word(&mut self, start: usize, letter: u8) -> bool {
        if let Some((index, end)) = names::find(self.source, start, self.dialect) {
            self.listed(start, end, index);
            return true;
        }
        if self.dialect.parameters.named != Naming::Plain {
            return false;
        }
        let Some(end) = names::name_end(self.source, start) else { return false };
        let bracket = self.source.get(end) == Some(&b'[');
        let Some(closed) = (if bracket { self.closing(end, b']') } else { Some(end) }) else {
            self.unknown(start);
            return true;
        };
        let after = self.scanner.skip_space(closed);
        match self.source.get(after) {
            Some(b'=') if end == start + 1 && !bracket => self.address(start, after + 1, letter),
            Some(b'=') if self.may_be_variable(letter) => self.plain_assignment(start, after + 1),
            Some(b':') if self.dialect.flow == FlowStyle::Structured => {
                self.push(start, after + 1, 0, WordKind::Label, f64::NAN);
            }
            _ if self.dialect.flow == FlowStyle::Structured && end > start + 1 => match self.arguments_end(end) {
                Some(end) => self.push(start, end, 0, WordKind::Call, f64::NAN),
                None => self.unknown(start),
            },
            _ if matches!(letter, b'N' | b'O') && self.dialect.rules.sequence_names => {
                self.push(start, end, letter, WordKind::Label, f64::NAN)
            }
            _ => return false,
        }
        true
    }

    /// Whether a variable's name may begin with a letter: of OSP V begins those of the control, and N, O, S have a meaning.
    fn may_be_variable(&self, letter: u8) -> bool {
        !self.dialect.rules.local_names || !matches!(letter, b'N' | b'O' | b'S')
    }

    /// A word of the dialect's list, that ends at a byte but for its value.
    fn listed(&mut self, start: usize, end: usize, index: usize) {
        let name = self.dialect.names.get(index).unwrap_or(Name::Inert);
        let end = match name {
            Name::Address(b'T') if self.calls_no_tool(end) => end,
            Name::Address(letter) | Name::Increment(letter) => {
                let equals = self.scanner.skip_space(end);
                let value = if self.source.get(equals) == Some(&b'=') { equals + 1 } else { end };
                return self.address(start, value, letter);
            }
            Name::Flow(_) => return self.push(start, self.text_end(end), 0, WordKind::Flow, f64::NAN),
            // `L Z 25.000`: an axis and its value, which no plane has.
            Name::Code(G::Plane(_)) if self.is_axis_value(start, end) => {
                return self.address(start, end, self.source[start].to_ascii_uppercase());
            }
            Name::Text(G::DefineCycle(_) | G::Pattern(_)) if self.dialect.flow == FlowStyle::Labels => {
                self.head_end(end)
            }
            Name::Text(_) => self.text_end(end),
            Name::Code(_) | Name::Function(_) => end,
            Name::Inert => match self.arguments_end(end) {
                Some(end) => end,
                None => return self.unknown(start),
            },
        };
        self.push(start, end, 0, WordKind::Name, index as f64);
    }

    /// Whether the call of a tool of Klartext names none: `TOOL CALL S2000` changes what it names.
    fn calls_no_tool(&self, end: usize) -> bool {
        let next = self.source.get(self.scanner.skip_space(end)).map(u8::to_ascii_uppercase);
        self.dialect.flow == FlowStyle::Labels && matches!(next, Some(b'S' | b'F'))
    }

    /// One past the text that a byte belongs to, up to the first parameter that gets a value in the same line.
    fn head_end(&self, start: usize) -> usize {
        let end = self.text_end(start);
        let sets = |at: &usize| {
            let digits = self.source[*at + 1..end].iter().take_while(|byte| byte.is_ascii_digit()).count();
            let begins =
                self.source[*at].eq_ignore_ascii_case(&self.dialect.parameters.mark) && self.source[*at - 1] == b' ';
            begins && digits > 0 && self.source.get(self.scanner.skip_space(*at + 1 + digits)) == Some(&b'=')
        };
        (start..end).find(sets).map_or(end, |at| self.source[..at].trim_ascii_end().len())
    }

    /// Whether a name is one letter with a number after blanks.
    fn is_axis_value(&self, start: usize, end: usize) -> bool {
        let value = self.scanner.skip_space(end);
        let starts = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-');
        end == start + 1 && self.source.get(value).is_some_and(starts)
    }

    /// A value after an address: a plain number, or something to be computed.
    fn address(&mut self, start: usize, value: usize, letter: u8) {
        let value = self.scanner.skip_space(value);
        if let Some((number, end)) = self.odd_number(value).filter(|_| self.dialect.decimal_comma) {
            return self.push(start, end, letter, WordKind::Number, number);
        }
        let Some(end) = self.scanner.value_end(value) else { return self.unknown(start) };
        match number::read(self.source, value) {
            Some((number, after)) if after == end => self.push(start, end, letter, WordKind::Number, number),
            _ => self.push(start, end, letter, WordKind::Expression, f64::NAN),
        }
    }

    fn plain_assignment(&mut self, start: usize, value: usize) {
        match self.scanner.value_end(value) {
            Some(end) => self.push(start, end, self.dialect.parameters.mark, WordKind::Assignment, f64::NAN),
            None => self.unknown(start),
        }
    }

    /// One past what may follow a word that takes arguments: `=5`, `("a;b", 3)`, `[1]=2`.
    fn arguments_end(&mut self, end: usize) -> Option<usize> {
        let open = self.scanner.skip_space(end);
        match self.source.get(open) {
            Some(b'(') => self.closing(open, b')'),
            Some(b'[') => {
                let closed = self.closing(open, b']')?;
                let equals = self.scanner.skip_space(closed);
                let given = self.source.get(equals) == Some(&b'=');
                if given {
                    self.scanner.value_end(equals + 1)
                } else {
                    Some(closed)
                }
            }
            Some(b'=') => self.scanner.value_end(open + 1),
            _ => Some(end),
        }
    }

    /// One past the bracket that closes the one at a byte, on the same line; texts between marks are passed over.
    fn closing(&mut self, open: usize, close: u8) -> Option<usize> {
        let opening = *self.source.get(open)?;
        let (mut depth, mut text) = (0usize, false);
        for (offset, &byte) in self.source.get(open..)?.iter().enumerate() {
            match byte {
                b'\n' => break,
                b'"' => text = !text,
                _ if text => {}
                _ if byte == opening => depth += 1,
                _ if byte == close => {
                    depth -= 1;
                    if depth == 0 {
                        return Some(open + offset + 1);
                    }
                }
                _ => {}
            }
        }
        self.scanner.gave_up_at = Some(self.scanner.line_end(open));
        None
    }
}
