//! Expressions, computed straight from the bytes: brackets, parameters, and for RS-274 its functions and operators.

use crate::dialect::{Blanks, Dialect, Functions, Naming};
use crate::reading::names;
use crate::reading::number;
use crate::values::functions::{
    function, macro_function, power, Operator, ARITHMETIC, KLARTEXT, MACRO, RS274, SIEMENS,
};
use crate::values::parameters::{read_number, Key};

/// Brackets and parameters of parameters may nest this deep.
const DEPTH: u32 = 64;

/// Why an expression has no value.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Where, in bytes from the source's start.
    pub at: usize,
    /// What is wrong there, in words.
    pub what: String,
}

/// The value of a macro's parameter that has none: a word of it is as good as not written, in a sum it counts as zero.
pub const VACANT: f64 = f64::from_bits(0x7ff8_0000_5ac0_0001);

/// Whether a value is that of a parameter without one, with whatever sign.
pub fn is_vacant(value: f64) -> bool {
    value.to_bits() << 1 == VACANT.to_bits() << 1
}

/// As it counts in a sum, a product or a function.
pub(crate) fn counted(value: f64) -> f64 {
    if is_vacant(value) {
        0.0
    } else {
        value
    }
}

/// What an expression needs besides its text.
pub trait Values {
    /// The value of a parameter; one that was never given should be noted and read as NaN.
    fn get(&mut self, key: &Key, at: usize) -> f64;
    /// Whether a parameter has a value.
    fn exists(&self, key: &Key) -> bool;
}

/// Computes the value that starts at `at`; gives it and the position after it.
pub fn value(source: &[u8], at: usize, dialect: &Dialect, values: &mut dyn Values) -> Result<(f64, usize), Box<Fault>> {
    let mut reader = Reader { source, dialect, values, at, depth: 0, dry: false };
    let value = reader.value()?;
    Ok((value, reader.at))
}

/// Computes a chain of values and operators without brackets about it: the right side of `#1=#2+3`.
pub fn formula(
    source: &[u8],
    at: usize,
    dialect: &Dialect,
    values: &mut dyn Values,
) -> Result<(f64, usize), Box<Fault>> {
    let mut reader = Reader { source, dialect, values, at, depth: 0, dry: false };
    let value = reader.expression(0)?;
    Ok((value, reader.at))
}

/// The parameter named at `at` (its mark included), and the position after it.
pub fn key(
    source: &[u8],
    at: usize,
    dialect: &Dialect,
    values: &mut dyn Values,
) -> Result<(Key<'static>, usize), Box<Fault>> {
    let mut reader = Reader { source, dialect, values, at, depth: 0, dry: false };
    let key = reader.key()?.into_owned();
    Ok((key, reader.at))
}

/// Where the formula ends that starts at `at`, white space after it left out; or where it stops making sense.
pub(crate) fn formula_end(source: &[u8], at: usize, dialect: &Dialect) -> Result<usize, usize> {
    let mut reader = Reader { source, dialect, values: &mut Nothing, at, depth: 0, dry: true };
    reader.expression(0).map_err(|fault| fault.at)?;
    let read = source.get(at..reader.at).unwrap_or(&[]);
    Ok(at + read.trim_ascii_end().len())
}

/// No parameter has a value.
struct Nothing;

impl Values for Nothing {
    fn get(&mut self, _: &Key, _: usize) -> f64 {
        f64::NAN
    }

    fn exists(&self, _: &Key) -> bool {
        false
    }
}

pub(crate) struct Reader<'a> {
    pub source: &'a [u8],
    pub dialect: &'a Dialect,
    pub values: &'a mut dyn Values,
    pub at: usize,
    depth: u32,
    /// Only its extent is wanted: no value is a fault.
    pub dry: bool,
}

impl<'a> Reader<'a> {
    pub(crate) fn fault<T>(&self, at: usize, what: &str) -> Result<T, Box<Fault>> {
        Err(Box::new(Fault { at, what: what.to_owned() }))
    }

    pub(crate) fn peek(&mut self) -> Option<u8> {
        while self.source.get(self.at).is_some_and(|byte| matches!(byte, b' ' | b'\t')) {
            self.at += 1;
        }
        self.source.get(self.at).copied()
    }

    /// Signs, then a number, brackets, a parameter or a function.
    pub(crate) fn value(&mut self) -> Result<f64, Box<Fault>> {
        let start = self.at;
        self.depth += 1;
        if self.depth > DEPTH {
            return self.fault(start, "brackets nest too deep");
        }
        let value = self.signed();
        self.depth -= 1;
        value
    }

    fn signed(&mut self) -> Result<f64, Box<Fault>> {
        let mut sign = 1.0;
        loop {
            let byte = self.peek();
            if !matches!(byte, Some(b'0'..=b'9' | b'.' | b'+' | b'-')) {
                return Ok(sign * self.computed()?);
            }
            if let Some((value, end)) = self.number() {
                self.at = end;
                return Ok(sign * value);
            }
            match byte {
                Some(b'-') => sign = -sign,
                Some(b'+') => {}
                _ => return Ok(sign * self.computed()?),
            }
            self.at += 1;
        }
    }

    /// A number; white space within it does not end it in RS-274.
    fn number(&self) -> Option<(f64, usize)> {
        let (value, end) = number::read(self.source, self.at)?;
        if self.dialect.blanks != Blanks::WithinNumber || !matches!(self.source.get(end), Some(b' ' | b'\t')) {
            return Some((value, end));
        }
        let (mut digits, mut at, mut end) = (Vec::new(), self.at, end);
        while let Some(&byte) = self.source.get(at) {
            match byte {
                b'0'..=b'9' | b'.' => end = at + 1,
                b'+' | b'-' if digits.is_empty() => {}
                b' ' | b'\t' => {
                    at += 1;
                    continue;
                }
                _ => break,
            }
            digits.push(byte);
            at += 1;
        }
        number::read(&digits, 0).filter(|(_, used)| *used == digits.len()).map(|(value, _)| (value, end))
    }

    fn computed(&mut self) -> Result<f64, Box<Fault>> {
        let at = self.at;
        match self.peek() {
            Some(byte) if byte == self.dialect.brackets.0 => self.brackets(),
            Some(b'"') if self.dialect.formulas => self.text(),
            Some(byte) if self.dialect.formulas && names::is_start(byte) => self.named(),
            Some(byte) if byte.to_ascii_uppercase() == self.dialect.parameters.mark => {
                let key = self.key()?;
                Ok(self.values.get(&key, at))
            }
            Some(byte) if self.dialect.functions != Functions::None && byte.is_ascii_alphabetic() => self.function(),
            _ => self.fault(self.at, "a number, a parameter or an opening bracket is missing"),
        }
    }

    pub(crate) fn brackets(&mut self) -> Result<f64, Box<Fault>> {
        self.open()?;
        let value = self.expression(0)?;
        self.close()?;
        Ok(value)
    }

    pub(crate) fn open(&mut self) -> Result<(), Box<Fault>> {
        if self.peek() != Some(self.dialect.brackets.0) {
            return self.fault(self.at, "an opening bracket is missing");
        }
        self.at += 1;
        Ok(())
    }

    pub(crate) fn close(&mut self) -> Result<(), Box<Fault>> {
        if self.peek() != Some(self.dialect.brackets.1) {
            return self.fault(self.at, "an operator or a closing bracket is missing");
        }
        self.at += 1;
        Ok(())
    }

    /// A chain of values and operators that bind more strongly than `floor`; equals associate to the left.
    pub(crate) fn expression(&mut self, floor: u8) -> Result<f64, Box<Fault>> {
        let mut left = self.value()?;
        while let Some(operator) = self.operator().filter(|operator| operator.strength > floor) {
            let at = self.at;
            self.at += operator.text.len();
            let right = self.expression(operator.strength)?;
            let compares = operator.strength == 1;
            let (one, other) = if compares { (left, right) } else { (counted(left), counted(right)) };
            left = match (operator.apply)(one, other) {
                Err(what) if !self.dry => return self.fault(at, what),
                result => result.unwrap_or(f64::NAN),
            };
        }
        Ok(left)
    }

    fn operator(&mut self) -> Option<&'static Operator> {
        let first = self.peek()?.to_ascii_lowercase();
        if first == self.dialect.brackets.1 {
            return None; // by far the most often what comes
        }
        let doubled = self.source.get(self.at + 1) == Some(&first);
        if self.dialect.functions != Functions::Siemens && !doubled {
            if let Some(operator) = ARITHMETIC.iter().find(|operator| operator.text[0] == first) {
                return Some(operator); // as good as always one of these four
            }
        }
        let rest = self.source.get(self.at..)?;
        let own: &[Operator] = match self.dialect.functions {
            Functions::None => &[],
            Functions::Rs274 => &RS274,
            Functions::Macro => &MACRO,
            Functions::Siemens => &SIEMENS,
            Functions::Klartext => &KLARTEXT,
        };
        let ends = |at: usize| !self.dialect.formulas || !rest.get(at).is_some_and(|byte| names::is_name(*byte));
        let whole = |text: &[u8]| text.last().is_some_and(|last| !last.is_ascii_alphabetic()) || ends(text.len());
        let begins = |text: &[u8]| rest.get(..text.len()).is_some_and(|start| start.eq_ignore_ascii_case(text));
        let stands = |operator: &&Operator| {
            operator.text.first() == Some(&first) && begins(operator.text) && whole(operator.text)
        };
        own.iter().find(stands).or_else(|| ARITHMETIC.iter().find(stands))
    }

    fn key(&mut self) -> Result<Key<'a>, Box<Fault>> {
        if self.dialect.parameters.named == Naming::Plain {
            return self.plain_key();
        }
        let start = self.at;
        self.at += 1;
        if let Some((key, end)) = read_number(self.source, self.at) {
            self.at = end;
            return Ok(key);
        }
        if !self.dialect.parameters.computed {
            return self.fault(start, "a parameter without a number");
        }
        if self.dialect.parameters.named == Naming::Brackets && self.peek() == Some(b'<') {
            return self.name();
        }
        let number = self.value()?;
        match Key::numbered(number) {
            Some(key) => Ok(key),
            None if number.is_nan() => self.fault(start, "a parameter whose number is not known"),
            None => self.fault(start, &format!("there is no parameter number {number}")),
        }
    }

    fn name(&mut self) -> Result<Key<'a>, Box<Fault>> {
        let rest = self.source.get(self.at + 1..).unwrap_or(&[]);
        let length = rest.iter().position(|byte| matches!(byte, b'>' | b'\n')).unwrap_or(rest.len());
        if rest.get(length) != Some(&b'>') {
            return self.fault(self.at, "a name without its closing bracket");
        }
        self.at += length + 2;
        Ok(Key::named(rest.get(..length).unwrap_or(&[])))
    }

    fn function(&mut self) -> Result<f64, Box<Fault>> {
        let start = self.at;
        while self.source.get(self.at).is_some_and(u8::is_ascii_alphabetic) {
            self.at += 1;
        }
        let name = self.source.get(start..self.at).unwrap_or(&[]).to_ascii_lowercase();
        let macros = self.dialect.functions == Functions::Macro;
        if name == b"exists" && !macros {
            return self.exists();
        }
        self.open()?;
        let argument = counted(self.expression(0)?);
        let second = if macros && self.peek() == Some(b',') { Some(self.second()?) } else { None };
        self.close()?;
        match (name.as_slice(), second) {
            (b"atan", Some(x)) => Ok(self.angle(argument, x, start)),
            (b"atan", None) if macros && self.peek() != Some(b'/') => Ok(argument.atan().to_degrees()),
            (b"atan", None) => self.arc_tangent(argument, start),
            (b"pow", Some(exponent)) => power(argument, exponent).or_else(|what| self.fault(start, what)),
            (_, Some(_)) => self.fault(start, "this function has no second argument"),
            (name, None) => match if macros { macro_function(name, argument) } else { function(name, argument) } {
                Some(value) if value.is_finite() || argument.is_nan() => Ok(value),
                Some(_) => self.fault(start, &format!("the function has no value at {argument}")),
                None => self.fault(start, &format!("unknown function {}", String::from_utf8_lossy(name))),
            },
        }
    }

    /// The value behind a comma.
    fn second(&mut self) -> Result<f64, Box<Fault>> {
        self.at += 1;
        Ok(counted(self.expression(0)?))
    }

    /// The angle of a direction, in degrees; a parameter of the machine says how those below zero are counted. Controls
    /// with macros know no zero with a sign.
    fn angle(&mut self, y: f64, x: f64, at: usize) -> f64 {
        let unsigned = |value: f64| if self.dialect.functions == Functions::Macro { value + 0.0 } else { value };
        let angle = unsigned(y).atan2(unsigned(x)).to_degrees();
        match self.dialect.rules.arc_tangent.filter(|_| angle < 0.0) {
            Some(parameter) => match self.values.get(&Key::named(parameter.name.as_bytes()), at) {
                0.0 => angle + 360.0,
                known if known.is_nan() => known,
                _ => angle,
            },
            None => angle,
        }
    }

    /// `ATAN[y]/[x]`.
    fn arc_tangent(&mut self, y: f64, start: usize) -> Result<f64, Box<Fault>> {
        if self.peek() != Some(b'/') {
            return self.fault(self.at, "ATAN needs two arguments: ATAN[y]/[x]");
        }
        self.at += 1;
        let x = self.brackets()?;
        Ok(self.angle(y, x, start))
    }

    /// `EXISTS[#<name>]`.
    fn exists(&mut self) -> Result<f64, Box<Fault>> {
        self.open()?;
        if self.peek() != Some(self.dialect.parameters.mark) {
            return self.fault(self.at, "EXISTS needs a parameter");
        }
        let key = self.key()?;
        self.close()?;
        Ok(f64::from(u8::from(self.values.exists(&key))))
    }
}
