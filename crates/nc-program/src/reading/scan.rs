//! Where a value ends: found without computing it, and never beyond its line.

use crate::dialect::{Class, Dialect, FlowStyle, Functions, Naming};
use crate::reading::number;
use crate::values::expression;

/// Names of parameters are no longer than this.
pub(crate) const NAME_LENGTH: usize = 256;

/// Finds ends of values.
pub(crate) struct Scanner<'a> {
    pub source: &'a [u8],
    pub dialect: &'a Dialect,
    /// Where the last search for a closing bracket gave up: the line's end or a comment. Nothing before it can be
    /// understood, and looking again from every letter of the line would take its length squared.
    pub gave_up_at: Option<usize>,
}

impl Scanner<'_> {
    #[inline]
    pub fn class(&self, at: usize) -> Option<Class> {
        self.source.get(at).map(|byte| self.dialect.class(*byte))
    }

    pub fn line_end(&self, at: usize) -> usize {
        let rest = self.source.get(at..).unwrap_or(&[]);
        memchr::memchr(b'\n', rest).map_or(self.source.len(), |found| at + found)
    }

    #[inline]
    pub fn skip_space(&self, mut at: usize) -> usize {
        while self.class(at) == Some(Class::Space) {
            at += 1;
        }
        at
    }

    /// End of a number or of a value to be computed.
    pub fn value_end(&mut self, at: usize) -> Option<usize> {
        let at = self.skip_space(at);
        if self.dialect.formulas {
            return self.formula_end(at);
        }
        match number::read(self.source, at) {
            Some((_, end)) => Some(end),
            None => self.expression_end(at),
        }
    }

    /// End of a value to be computed: signs, then brackets, a parameter or a function.
    pub fn expression_end(&mut self, at: usize) -> Option<usize> {
        let mut at = self.skip_space(at);
        if self.dialect.flow == FlowStyle::Labels {
            // A coordinate of Klartext is a number or a parameter: no letter of another word is its value.
            let sign = matches!(self.source.get(at), Some(b'+' | b'-'));
            let first = self.source.get(at + usize::from(sign))?.to_ascii_uppercase();
            return if first == self.dialect.parameters.mark { self.formula_end(at) } else { None };
        }
        if self.dialect.formulas {
            return self.formula_end(at);
        }
        while matches!(self.source.get(at), Some(b'+' | b'-')) {
            at = self.skip_space(at + 1);
        }
        let byte = *self.source.get(at)?;
        if byte == self.dialect.brackets.0 {
            self.bracket_end(at)
        } else if byte == self.dialect.parameters.mark && self.dialect.parameters.computed {
            self.parameter_end(at)
        } else if self.dialect.functions != Functions::None && byte.is_ascii_alphabetic() {
            self.function_end(at)
        } else {
            None
        }
    }

    /// End of a chain of operands and operators.
    fn formula_end(&mut self, at: usize) -> Option<usize> {
        match expression::formula_end(self.source, at, self.dialect) {
            Ok(end) => (end > at).then_some(end),
            Err(fault) => {
                self.gave_up_at = Some(fault);
                None
            }
        }
    }

    /// One past the bracket that closes the one at `at`.
    pub fn bracket_end(&mut self, at: usize) -> Option<usize> {
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
            } else if matches!(self.dialect.class(byte), Class::LineEnd | Class::LineComment) {
                self.gave_up_at = Some(at + offset);
                return None;
            }
        }
        self.gave_up_at = Some(self.source.len());
        None
    }

    /// End of `#12`, `##3`, `#<name>`, `#[…]`.
    pub fn parameter_end(&mut self, mut at: usize) -> Option<usize> {
        while self.source.get(at) == Some(&b'#') {
            at = self.skip_space(at + 1);
        }
        match *self.source.get(at)? {
            b'<' if self.dialect.parameters.named == Naming::Brackets => self.name_end(at),
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
        let most = self.source.len().min(at + NAME_LENGTH);
        let found = at + memchr::memchr2(b'>', b'\n', self.source.get(at..most)?)?;
        (self.source.get(found) == Some(&b'>')).then_some(found + 1)
    }

    /// End of `SIN[…]`, `ATAN[…]/[…]`.
    fn function_end(&mut self, at: usize) -> Option<usize> {
        let letters = self.source.get(at..)?.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let name = self.source.get(at..at + letters)?;
        let end = self.bracketed_end(at + letters)?;
        if !name.eq_ignore_ascii_case(b"atan") {
            return Some(end);
        }
        let slash = self.skip_space(end);
        match self.source.get(slash) {
            Some(b'/') => self.bracketed_end(slash + 1),
            _ => Some(end).filter(|_| self.dialect.functions == Functions::Macro),
        }
    }

    fn bracketed_end(&mut self, at: usize) -> Option<usize> {
        let at = self.skip_space(at);
        if self.source.get(at) == Some(&self.dialect.brackets.0) {
            self.bracket_end(at)
        } else {
            None
        }
    }
}
