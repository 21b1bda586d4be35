//! Dialects: how a control spells its programs and what its codes mean.

mod class;
mod code;
mod list;

pub use crate::controls::Rules;
pub use crate::reading::letters::Letters;
pub(crate) use crate::reading::names::{Name, Names};
pub use crate::shapes::curve::PoleFrom;

use crate::modes::modal::Modal;

pub(crate) use class::common_classes;
pub use class::{Blanks, Class};
pub use code::{G, M};
pub use list::{
    FANUC_LATHE, FANUC_LATHE_B, FANUC_MILL, GE2000T, HAAS_LATHE, HAAS_MILL, HEIDENHAIN, LINUXCNC, OKUMA_LATHE, SIEMENS,
};

/// Controls with a constant of their own.
const BUILT_IN: [&Dialect; 10] = [
    &GE2000T,
    &LINUXCNC,
    &FANUC_LATHE,
    &FANUC_LATHE_B,
    &FANUC_MILL,
    &HAAS_LATHE,
    &HAAS_MILL,
    &SIEMENS,
    &HEIDENHAIN,
    &OKUMA_LATHE,
];

/// Returns every dialect there is.
pub fn dialects() -> impl Iterator<Item = &'static Dialect> {
    BUILT_IN.into_iter().chain(&crate::controls::IN_FILES)
}

/// How names of parameters are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Naming {
    /// There are none.
    None,
    /// In angle brackets after the mark: `#<depth>`.
    Brackets,
    /// As they are: `DEPTH`, `$AA_IW[X]`.
    Plain,
}

/// How parameters are written.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// `P` in `P46`, `#` in `#1`.
    pub mark: u8,
    /// Names are allowed.
    pub named: Naming,
    /// Parameters may stand for a value without brackets, and their numbers may be computed.
    pub computed: bool,
    /// A number never given a value reads as zero, as the control does; a finding says so.
    pub unset_is_zero: bool,
}

/// How the offset of a tool comes into force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToolOffset {
    /// By a code (G43), from the row that H names.
    Code,
    /// By the last two digits of T.
    InT,
    /// By T and the letter of an edge (D; OG of an Okuma): its lengths go to the axes that the plane says.
    Edge(u8),
    /// By the call of the tool, along the axis that it names.
    Call,
    /// In a way that is not followed.
    Unknown,
}

/// How flow control is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowStyle {
    /// There is none.
    None,
    /// O-words of RS-274.
    OWords,
    /// IF, GOTO, WHILE, DO, END; programs and blocks called by number.
    Macro,
    /// IF, ELSE, ENDIF and their like, jumps to labels, programs called by name.
    Structured,
    /// LBL, CALL LBL, FN 9 to FN 12.
    Labels,
}

/// Functions and word operators of expressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Functions {
    /// There are none.
    None,
    /// Those of RS-274.
    Rs274,
    /// Those of custom macro B.
    Macro,
    /// Those of Sinumerik.
    Siemens,
    /// Those of Klartext: no brackets about an argument.
    Klartext,
}

/// A dialect's rules.
#[derive(Debug)]
pub struct Dialect {
    /// The name by which users choose it.
    pub name: &'static str,
    /// The control of which it is a variant in a file of its own; empty of others.
    pub like: &'static str,
    /// Patterns of lines in its programs alone, of a variant, with their points for whoever recognises programs.
    pub marks: &'static [(u32, &'static str)],
    /// Words of more than a letter.
    pub(crate) names: Names,
    /// A value is a chain of operands and operators, without brackets about it: `X=R1+10`.
    pub formulas: bool,
    /// Class of each byte where a word may start.
    pub classes: [Class; 256],
    /// Opening and closing bracket of expressions.
    pub brackets: (u8, u8),
    /// Parameters.
    pub parameters: Parameters,
    /// Functions and word operators of expressions.
    pub functions: Functions,
    /// White space in a word of a letter and a number.
    pub blanks: Blanks,
    /// A comma between digits is read as a decimal point, and reported.
    pub decimal_comma: bool,
    /// P in an arc block is the number of turns begun.
    pub turns: bool,
    /// Addresses of a line's angle with the plane's first axis.
    pub line_angle: &'static [u8],
    /// Arcs without a radius are about the pole.
    pub about_pole: bool,
    /// Flow control.
    pub flow: FlowStyle,
    /// Letters that increase X, Y, Z, whatever mode is in force.
    pub increments: Option<[u8; 3]>,
    /// How the offset of a tool comes into force.
    pub tool_offset: ToolOffset,
    /// What codes do beyond their meaning.
    pub rules: Rules,
    /// Address letters of moves that are not in the path.
    pub other_axes: Letters,
    /// Address letters that mean something.
    pub letters: Letters,
    /// Those of them that mean something in blocks of the control's own cycles alone.
    pub cycle_letters: Letters,
    /// Meaning of a G code, given ten times its number.
    pub g: fn(u16) -> Option<G>,
    /// Meaning of an M code.
    pub m: fn(u16) -> Option<M>,
    /// State at the program's start.
    pub initial: Modal,
    /// Smallest programmable step in inch and in millimetres.
    pub resolution: (f64, f64),
    /// Opening and closing of a comment, as this dialect's own text is written.
    pub comment: (&'static str, &'static str),
}

impl Dialect {
    /// The dialect of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        dialects().find(|dialect| dialect.name == name)
    }

    /// How the radius of an arc is written, up to its value: `R`, `CR=`.
    pub fn radius_address(&self) -> String {
        let letter = char::from(self.rules.radius_letter);
        self.names.spelt(Name::Address(b'R')).map_or_else(|| letter.to_string(), |name| format!("{name}="))
    }

    /// Meaning of the G code of that number, which counts to the tenth.
    #[inline]
    pub fn g_code(&self, number: f64) -> Option<G> {
        let tenths = 10.0 * number;
        if tenths > -0.5 && tenths < 65_535.0 {
            let whole = tenths as u16; // rounded by hand: `round` is a function call for want of SSE4.1
            return (self.g)(whole + u16::from(tenths - f64::from(whole) >= 0.5));
        }
        None
    }

    /// Meaning of the M code of that number.
    #[inline]
    pub fn m_code(&self, number: f64) -> Option<M> {
        let number = number.round();
        (0.0..=9999.0).contains(&number).then(|| (self.m)(number as u16)).flatten()
    }

    /// What a byte means where a word may start.
    #[inline]
    pub fn class(&self, byte: u8) -> Class {
        self.classes[usize::from(byte)]
    }
}
