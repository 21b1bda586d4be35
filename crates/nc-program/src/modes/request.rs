//! What one block asks for: its values by letter and its codes.

use crate::dialect::G;
use crate::reading::letters::Letters;
use crate::values::parameters::Key;

/// Most G codes that a block may carry.
const CODES: usize = 16;
/// Addresses from `A` to `z`.
const ADDRESSES: usize = 58;

/// A call or return by M code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jump {
    /// None.
    None,
    /// Calls the program of the number P.
    Program,
    /// Calls the blocks from N of P.
    Block,
    /// Goes back.
    Return,
    /// Goes to blocks that are not in this file, or by a signal.
    Elsewhere,
    /// Calls the program that the word names.
    Named(usize),
}

/// A block's request.
#[derive(Debug)]
pub struct Request {
    values: [f64; ADDRESSES],
    words: [i32; ADDRESSES],
    present: Letters,
    increments: Letters,
    positions: Letters,
    /// Letters whose number has no decimal point.
    pub pointless: Letters,
    codes: [(G, u32); CODES],
    code_count: usize,
    /// Values given to parameters in this block, with the offset of each.
    pub assignments: Vec<(Key<'static>, f64)>,
    /// The program ends with this block.
    pub ends: bool,
    /// The tool of T goes into the spindle.
    pub changes_tool: bool,
    /// Where to go on after it.
    pub jump: Jump,
    /// The word that calls the cycle defined last, and whether every move after it does, too.
    pub cycle_call: Option<(i32, bool)>,
}

impl Request {
    /// An empty one.
    pub fn new() -> Self {
        Self {
            values: [0.0; ADDRESSES],
            words: [-1; ADDRESSES],
            present: Letters::default(),
            increments: Letters::default(),
            positions: Letters::default(),
            pointless: Letters::default(),
            codes: [(G::Inert, 0); CODES],
            code_count: 0,
            assignments: Vec::new(),
            ends: false,
            changes_tool: false,
            jump: Jump::None,
            cycle_call: None,
        }
    }

    /// Forgets the block before.
    #[inline]
    pub fn clear(&mut self) {
        (self.present, self.increments, self.positions, self.pointless) = Default::default();
        self.code_count = 0;
        self.assignments.clear();
        self.ends = false;
        self.changes_tool = false;
        self.jump = Jump::None;
        self.cycle_call = None;
    }

    /// Notes a value; the last one of a letter counts.
    #[inline]
    pub fn set(&mut self, letter: u8, value: f64, word: usize) {
        let index = usize::from(letter.wrapping_sub(b'A'));
        if let (Some(slot), Some(source)) = (self.values.get_mut(index), self.words.get_mut(index)) {
            *slot = value;
            *source = word as i32;
            self.present.add(letter);
        }
    }

    /// The value of a letter, if the block has it.
    #[inline]
    pub fn get(&self, letter: u8) -> Option<f64> {
        let index = usize::from(letter.wrapping_sub(b'A'));
        let value = self.values.get(index)?;
        self.present.has(letter).then_some(*value)
    }

    /// Takes a value away, as if its word were not there.
    pub fn take(&mut self, letter: u8) {
        self.present.remove(letter);
    }

    /// Multiplies a value.
    pub fn scale(&mut self, letter: u8, by: f64) {
        if let Some(slot) = self.values.get_mut(usize::from(letter.wrapping_sub(b'A'))) {
            *slot *= by;
        }
    }

    /// Says that the value of a letter is an increment (true) or a position (false), whatever mode is in force.
    pub fn refer(&mut self, letter: u8, increment: bool) {
        let of = if increment { &mut self.increments } else { &mut self.positions };
        of.add(letter);
    }

    /// Whether the value of a letter is an increment, where its word says so.
    #[inline]
    pub fn reference(&self, letter: u8) -> Option<bool> {
        let increment = self.increments.has(letter);
        (increment || self.positions.has(letter)).then_some(increment)
    }

    /// Index of the word of a letter, −1 without one.
    pub fn word(&self, letter: u8) -> i32 {
        let index = usize::from(letter.wrapping_sub(b'A'));
        if self.get(letter).is_some() {
            self.words.get(index).copied().unwrap_or(-1)
        } else {
            -1
        }
    }

    /// Whether any of these letters is there.
    #[inline]
    pub fn any(&self, letters: &[u8]) -> bool {
        self.present.meets(Letters::of(letters))
    }

    /// Notes a code's meaning and the word's index. False when there are too many.
    pub fn add_code(&mut self, code: G, word: usize) -> bool {
        let Some(slot) = self.codes.get_mut(self.code_count) else {
            return false;
        };
        *slot = (code, word as u32);
        self.code_count += 1;
        true
    }

    /// The codes in order: the meaning, and the word's index.
    pub fn codes(&self) -> &[(G, u32)] {
        self.codes.get(..self.code_count).unwrap_or(&[])
    }

    /// A cycle's own parameter: `P1=0.15`.
    pub fn cycle_parameter(&self, number: u32) -> Option<f64> {
        self.assignments.iter().rev().find(|(key, _)| *key == Key::Number(number)).map(|(_, value)| *value)
    }
}
