//! Parameters: numbered and named values, local to a subroutine or not.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use crate::dialect::{Dialect, Naming};
use crate::reading::names;
use crate::reading::number;

/// Numbered parameters beyond this are refused: a program asks for no more on any control.
const LAST_NUMBER: u32 = 100_000;
/// RS-274: #1 to #30 are local to a subroutine.
const LAST_LOCAL: usize = 30;
/// Custom macro B: #1 to #33 are local to a macro.
pub(crate) const LAST_MACRO_LOCAL: u32 = 33;

/// The name of a parameter, where it stands in the source or apart from it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Key<'a> {
    /// `P46`, `#1`.
    Number(u32),
    /// `#<depth>`, in lower case without spaces; Latin-1, as programs are.
    Name(Cow<'a, [u8]>),
}

impl<'a> Key<'a> {
    /// A key as a user writes it: `P46`; `#1`, `1`, `#<depth>` or `depth`.
    pub fn parse(text: &'a str, dialect: &Dialect) -> Option<Self> {
        let mark = char::from(dialect.parameters.mark);
        let text = text.trim();
        if let Some(known) = dialect.rules.parameters().find(|known| known.name.eq_ignore_ascii_case(text)) {
            return Some(Self::Name(Cow::Owned(known.name.to_ascii_lowercase().into_bytes())));
        }
        if dialect.parameters.named == Naming::Plain {
            return Self::plain(text.as_bytes(), dialect);
        }
        let bare = text.strip_prefix(mark).or_else(|| text.strip_prefix(mark.to_ascii_lowercase())).unwrap_or(text);
        if let Ok(number) = bare.parse::<u32>() {
            return (number <= LAST_NUMBER).then_some(Self::Number(number));
        }
        let name = bare.strip_prefix('<').and_then(|name| name.strip_suffix('>')).unwrap_or(bare);
        (dialect.parameters.named == Naming::Brackets && !name.is_empty()).then(|| Self::named(name.as_bytes()))
    }

    /// A name as it stands: `R5` where R is the mark, else a variable.
    fn plain(text: &'a [u8], dialect: &Dialect) -> Option<Self> {
        let end = names::name_end(text, 0)?;
        let digits =
            text.get(1..).filter(|_| text.first().map(u8::to_ascii_uppercase) == Some(dialect.parameters.mark));
        match digits.and_then(|digits| read_number(digits, 0)) {
            Some((key, after)) if after + 1 == text.len() => Some(key),
            _ => (end == text.len() || text.get(end) == Some(&b'[')).then(|| Self::named(text)),
        }
    }

    /// The key of a number computed by a program.
    pub fn numbered(value: f64) -> Option<Self> {
        let number = value.round();
        let whole = (value - number).abs() < 1e-4;
        (whole && (0.0..=f64::from(LAST_NUMBER)).contains(&number)).then_some(Self::Number(number as u32))
    }

    /// The key of a name between angle brackets.
    pub fn named(name: &'a [u8]) -> Self {
        if !name.iter().any(|byte| byte.is_ascii_uppercase() || byte.is_ascii_whitespace()) {
            return Self::Name(Cow::Borrowed(name));
        }
        let kept = name.iter().filter(|byte| !byte.is_ascii_whitespace());
        Self::Name(kept.map(u8::to_ascii_lowercase).collect())
    }

    /// The same apart from the source.
    pub fn into_owned(self) -> Key<'static> {
        match self {
            Self::Number(number) => Key::Number(number),
            Self::Name(name) => Key::Name(Cow::Owned(name.into_owned())),
        }
    }

    /// As the dialect writes it.
    pub fn text(&self, dialect: &Dialect) -> String {
        match self {
            Self::Name(name) if dialect.parameters.named == Naming::Plain => latin_1(name).to_ascii_uppercase(),
            _ => format!("{}{self}", char::from(dialect.parameters.mark)),
        }
    }
}

impl fmt::Display for Key<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Name(name) => write!(formatter, "<{}>", latin_1(name)),
        }
    }
}

fn latin_1(name: &[u8]) -> String {
    name.iter().map(|byte| char::from(*byte)).collect()
}

/// The values at one moment of a run.
#[derive(Clone, Debug, Default)]
pub struct Store {
    numbered: Vec<Option<f64>>,
    global: BTreeMap<Vec<u8>, f64>,
    local: BTreeMap<Vec<u8>, f64>,
    /// The types of declared names, where they change what is assigned.
    types: BTreeMap<Vec<u8>, Type>,
    callers: Vec<Locals>,
}

/// Local parameters put away: numbered, and all named ones or some that a procedure calls its own.
type Locals = (Vec<Option<f64>>, Names);

#[derive(Clone, Debug)]
enum Names {
    All(BTreeMap<Vec<u8>, f64>),
    Some(Vec<(Vec<u8>, Option<f64>, Type)>),
}

/// The type of a declared name (Sinumerik).
#[derive(Clone, Copy, Debug, Default)]
pub enum Type {
    #[default]
    Real,
    Whole,
    Truth,
}

impl Type {
    /// That of the name of a type.
    pub fn of(name: &str) -> Self {
        match name.to_ascii_lowercase().as_str() {
            "int" => Self::Whole,
            "bool" => Self::Truth,
            _ => Self::Real,
        }
    }

    /// What a value becomes where it is assigned: half of one is rounded up.
    fn converted(self, value: f64) -> f64 {
        match self {
            Self::Whole => (value + 0.5).floor(),
            Self::Truth if !value.is_nan() => f64::from(u8::from(value != 0.0)),
            Self::Real | Self::Truth => value,
        }
    }
}

impl Store {
    /// The value, where one was given.
    pub fn get(&self, key: &Key) -> Option<f64> {
        match key {
            Key::Number(number) => self.numbered.get(*number as usize).copied().flatten(),
            Key::Name(name) if name.starts_with(b"_") => self.global.get(&**name).copied(),
            Key::Name(name) => self.local.get(&**name).copied(),
        }
    }

    /// Gives a value.
    pub fn set(&mut self, key: Key, value: f64) {
        let value = self.type_of(&key).converted(value);
        match key {
            Key::Number(number) => {
                let index = number as usize;
                if index >= self.numbered.len() {
                    self.numbered.resize(index + 1, None);
                }
                if let Some(slot) = self.numbered.get_mut(index) {
                    *slot = Some(value);
                }
            }
            Key::Name(name) if name.starts_with(b"_") => drop(self.global.insert(name.into_owned(), value)),
            Key::Name(name) => drop(self.local.insert(name.into_owned(), value)),
        }
    }

    /// Takes a value away.
    pub fn forget(&mut self, key: &Key) {
        match key {
            Key::Number(number) => {
                if let Some(slot) = self.numbered.get_mut(*number as usize) {
                    *slot = None;
                }
            }
            Key::Name(name) => {
                self.global.remove(&**name);
                self.local.remove(&**name);
            }
        }
    }

    /// Whether the numbered parameter of that index is alike in both, bit by bit.
    pub(crate) fn agrees_at(&self, other: &Self, index: usize) -> bool {
        let bits = |store: &Self| store.numbered.get(index).copied().flatten().map(f64::to_bits);
        bits(self) == bits(other)
    }

    /// Index of the first numbered parameter that is not alike in both.
    pub(crate) fn first_difference(&self, other: &Self) -> Option<usize> {
        (0..self.numbered.len().max(other.numbered.len())).find(|index| !self.agrees_at(other, *index))
    }

    /// Enters a subroutine: the arguments become #1, #2, …, the rest of #1 to #30 zero; the other local parameters are put away.
    pub fn enter(&mut self, arguments: &[f64]) {
        self.put_locals_away(LAST_LOCAL);
        for (index, value) in arguments.iter().chain(std::iter::repeat(&0.0)).enumerate().take(LAST_LOCAL) {
            self.set(Key::Number(index as u32 + 1), *value);
        }
    }

    /// Enters a macro: the arguments get their numbers, the rest of #1 to #33 has no value.
    pub fn enter_macro(&mut self, arguments: &[(u32, f64)]) {
        self.put_locals_away(LAST_MACRO_LOCAL as usize);
        for (number, value) in arguments {
            self.set(Key::Number(*number), *value);
        }
    }

    fn put_locals_away(&mut self, last: usize) {
        self.numbered.resize(self.numbered.len().max(last + 1), None);
        let saved = self.numbered.iter_mut().take(last + 1).map(Option::take).collect();
        self.callers.push((saved, Names::All(std::mem::take(&mut self.local))));
    }

    fn type_of(&self, key: &Key) -> Type {
        match key {
            Key::Name(name) => self.types.get(&**name).copied().unwrap_or_default(),
            Key::Number(_) => Type::Real,
        }
    }

    /// Gives a name a type and a value, which are those of the procedure that runs, until it ends.
    pub fn declare(&mut self, key: Key, of: Type, value: f64) {
        let Key::Name(name) = &key else { return self.set(key, value) };
        let (name, now) = (name.to_vec(), (self.get(&key), self.type_of(&key)));
        if let Some((_, Names::Some(before))) = self.callers.last_mut() {
            if !before.iter().any(|(own, ..)| *own == name) {
                before.push((name.clone(), now.0, now.1));
            }
        }
        self.types.insert(name, of);
        self.set(key, value);
    }

    /// Enters a procedure; what it declares is its own, and all else keeps its value.
    pub fn enter_procedure(&mut self) {
        self.callers.push((Vec::new(), Names::Some(Vec::new())));
    }

    /// Leaves it: the caller's local parameters come back.
    pub fn leave(&mut self) {
        if let Some((saved, local)) = self.callers.pop() {
            for (slot, value) in self.numbered.iter_mut().zip(saved) {
                *slot = value;
            }
            match local {
                Names::All(local) => self.local = local,
                Names::Some(before) => {
                    for (name, value, of) in before {
                        self.types.insert(name.clone(), of);
                        let key = Key::Name(Cow::Owned(name));
                        match value {
                            Some(value) => self.set(key, value),
                            None => self.forget(&key),
                        }
                    }
                }
            }
        }
    }
}

/// Reads the digits of a numbered parameter.
pub fn read_number(bytes: &[u8], at: usize) -> Option<(Key<'static>, usize)> {
    if !bytes.get(at)?.is_ascii_digit() {
        return None;
    }
    let (value, end) = number::read(bytes, at)?;
    Some((Key::numbered(value)?, end))
}
