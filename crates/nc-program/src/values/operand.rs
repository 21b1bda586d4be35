//! Operands that are names: variables, constants and functions with any number of arguments.

use crate::dialect::Functions;
use crate::reading::names::{name_end, skip};
use crate::reading::scan::NAME_LENGTH;
use crate::values::expression::{Fault, Reader};
use crate::values::functions;
use crate::values::parameters::{read_number, Key};

impl<'a> Reader<'a> {
    /// What a name stands for.
    pub(crate) fn named(&mut self) -> Result<f64, Box<Fault>> {
        let start = self.at;
        let end = name_end(self.source, start).unwrap_or(start);
        let name = self.source.get(start..end).unwrap_or(&[]).to_ascii_lowercase();
        if let Some(constant) = functions::constant(&name) {
            self.at = end;
            return Ok(constant);
        }
        if self.dialect.functions == Functions::Klartext && functions::klartext(&name, f64::NAN).is_some() {
            self.at = end;
            let argument = self.value()?;
            return match functions::klartext(&name, argument) {
                Some(value) if value.is_finite() || argument.is_nan() => Ok(value),
                _ if self.dry => Ok(f64::NAN),
                _ => self.fault(start, &format!("the function has no value at {argument}")),
            };
        }
        if name == b"not" {
            self.at = end;
            let value = self.value()?;
            return Ok(if value.is_nan() { value } else { f64::from(u8::from(value == 0.0)) });
        }
        let bracket = self.source.get(skip(self.source, end, |byte| byte == b' '));
        let of_macro = self.dialect.functions == Functions::Macro && functions::macro_function(&name, 0.0).is_some();
        if of_macro && bracket == Some(&self.dialect.brackets.0) {
            self.at = end;
            self.peek();
            let argument = self.brackets()?;
            return match functions::macro_function(&name, argument) {
                Some(value) if value.is_finite() || argument.is_nan() => Ok(value),
                _ if self.dry => Ok(f64::NAN),
                _ => self.fault(start, &format!("the function has no value at {argument}")),
            };
        }
        if bracket == Some(&b'(') {
            self.at = end;
            let arguments = self.arguments()?;
            return self.called(start, &name, &arguments);
        }
        let key = self.plain_key()?;
        Ok(self.values.get(&key, start))
    }

    fn called(&self, start: usize, name: &[u8], arguments: &[f64]) -> Result<f64, Box<Fault>> {
        let known = arguments.iter().all(|argument| !argument.is_nan());
        match functions::of_arguments(name, arguments) {
            Some(value) if value.is_finite() || !known => Ok(value),
            _ if self.dry => Ok(f64::NAN),
            Some(_) => self.fault(start, &format!("the function has no value at {arguments:?}")),
            None => self.fault(start, &format!("unknown function {}", String::from_utf8_lossy(name))),
        }
    }

    /// `(a, b)`: the values.
    pub(crate) fn arguments(&mut self) -> Result<Vec<f64>, Box<Fault>> {
        self.open()?;
        let mut values = vec![self.expression(0)?];
        while self.peek() == Some(b',') {
            self.at += 1;
            values.push(self.expression(0)?);
        }
        self.close()?;
        Ok(values)
    }

    /// `R1`, `R[R2+1]`, `DEPTH`, `SIZE[2]`, `$AA_IW[X]`.
    pub(crate) fn plain_key(&mut self) -> Result<Key<'a>, Box<Fault>> {
        let start = self.at;
        let Some(end) = name_end(self.source, start).filter(|end| end - start <= NAME_LENGTH) else {
            return self.fault(start, "a name is missing");
        };
        let text = self.source.get(start..end).unwrap_or(&[]);
        let numbered = text.first().is_some_and(|first| first.to_ascii_uppercase() == self.dialect.parameters.mark);
        let number = read_number(self.source, start + 1).filter(|(_, after)| numbered && *after == end);
        self.at = end;
        if let Some((key, _)) = number {
            return Ok(key);
        }
        if self.source.get(end) != Some(&b'[') {
            return Ok(Key::named(text));
        }
        if text.first() == Some(&b'$') {
            return self.system_key(start);
        }
        self.at += 1;
        let index = self.expression(0)?;
        let (one, at) = (numbered && text.len() == 1, self.at);
        let key = if one { Key::numbered(index) } else { Some(self.element(text, index)?) };
        if self.peek() != Some(b']') {
            return self.fault(at, "an operator or a closing bracket is missing");
        }
        self.at += 1;
        match key {
            Some(key) => Ok(key),
            None if self.dry || index.is_nan() => Ok(Key::Number(0)),
            None => self.fault(start, &format!("there is no parameter number {index}")),
        }
    }

    /// An element of a field, of one index or two.
    fn element(&mut self, name: &[u8], first: f64) -> Result<Key<'static>, Box<Fault>> {
        let mut text = format!("{}[{first}", String::from_utf8_lossy(name));
        if self.peek() == Some(b',') {
            self.at += 1;
            text += &format!(",{}", self.expression(0)?);
        }
        Ok(Key::named(format!("{text}]").as_bytes()).into_owned())
    }

    /// A variable of the control's own, index and all.
    fn system_key(&mut self, start: usize) -> Result<Key<'a>, Box<Fault>> {
        let most = self.source.len().min(start + NAME_LENGTH);
        let text = self.source.get(start..most).unwrap_or(&[]);
        let length = memchr::memchr2(b']', b'\n', text).unwrap_or(text.len());
        if text.get(length) != Some(&b']') {
            return self.fault(start, "an index without its closing bracket");
        }
        self.at = start + length + 1;
        Ok(Key::named(text.get(..=length).unwrap_or(&[])))
    }

    /// `"text"`: it has no value.
    pub(crate) fn text(&mut self) -> Result<f64, Box<Fault>> {
        let rest = self.source.get(self.at + 1..).unwrap_or(&[]);
        match memchr::memchr2(b'"', b'\n', rest) {
            Some(length) if rest.get(length) == Some(&b'"') => {
                self.at += length + 2;
                Ok(f64::NAN)
            }
            _ => self.fault(self.at, "a text without its closing mark"),
        }
    }
}
