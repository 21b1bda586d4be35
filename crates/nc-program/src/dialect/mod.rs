//! Dialects: how a control spells its programs and what its codes mean.

mod fanuc;
mod ge2000t;
mod haas;
mod heidenhain;
mod linuxcnc;
mod siemens;

pub use crate::curve::PoleFrom;
pub use crate::letters::Letters;
pub(crate) use crate::names::{Name, Names};

use crate::drill::Drill;
use crate::modal::{Compensation, FeedMode, Modal, Motion, Plane, SpindleMode};
use crate::pass::Pass;
use crate::profile_cycle::Profile;
use crate::rough::Rough;

pub use fanuc::{FANUC_LATHE, FANUC_LATHE_B, FANUC_MILL};
pub use ge2000t::GE2000T;
pub use haas::{HAAS_LATHE, HAAS_MILL};
pub use heidenhain::HEIDENHAIN;
pub use linuxcnc::LINUXCNC;
pub use siemens::SIEMENS;

/// Every dialect there is.
pub const DIALECTS: [&Dialect; 9] =
    [&GE2000T, &LINUXCNC, &FANUC_LATHE, &FANUC_LATHE_B, &FANUC_MILL, &HAAS_LATHE, &HAAS_MILL, &SIEMENS, &HEIDENHAIN];

/// What a byte means where a word may start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// Ends the block.
    LineEnd,
    /// Between words.
    Space,
    /// Starts a word.
    Letter,
    /// Starts a word that may be a name, though it looks like a letter and a number.
    Name,
    /// At a line's start: the block's number, without a letter.
    Digit,
    /// Starts a comment that runs to the line's end.
    LineComment,
    /// Starts a comment that runs to the closing parenthesis.
    Comment,
    /// Starts a statement that runs to the matching parenthesis.
    Statement,
    /// At a line's start: the block is optional.
    Slash,
    /// At a line's start: end of tape.
    Percent,
    /// Starts an assignment.
    Parameter,
    /// Before a letter: a word of its own, `,R0.5`.
    Comma,
    /// Not known here.
    Other,
}

/// What a G code means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum G {
    /// Sets the motion of this and later blocks.
    Motion(Motion),
    /// The head of a program, whose last word is its unit: `BEGIN PGM PLATE MM`.
    Heading,
    /// A line of this block is at rapid.
    Fast,
    /// A drilling cycle, until another motion code.
    Drill(Drill),
    /// A lathe's drilling cycle along that axis (0 is X, 2 is Z), until another motion code.
    DrillAlong(Drill, u8),
    /// A simple turning cycle, until another motion code.
    Pass(Pass),
    /// A thread cut in passes.
    Thread,
    /// Drilling cycles retract to the plane R (true) or to where they began (false).
    RetractToPlane(bool),
    /// No motion until the next motion code.
    NoMotion,
    /// Plane of arcs.
    Plane(Plane),
    /// Inch (true) or metric (false).
    Inch(bool),
    /// Increments (true) or absolute positions (false).
    Incremental(bool),
    /// Arc centres absolute (true) or from the start point (false).
    CentreAbsolute(bool),
    /// X is a diameter (true) or a radius (false).
    Diameter(bool),
    /// X is a diameter in absolute positions, a radius in increments.
    DiameterOfPositions,
    /// Unit of feed.
    Feed(FeedMode),
    /// Unit of spindle speed.
    Spindle(SpindleMode),
    /// Cutter compensation.
    Compensation(Compensation),
    /// The same with the tool's diameter in D and its tip in L.
    CompensationGiven(Compensation),
    /// Sets the position register: what the position is called, the tool does not move.
    SetRegister,
    /// Sets the register's offset itself, axis by axis.
    OffsetRegister,
    /// Sets the register's offset of all axes, zero where none is given; adds to it if true.
    Shift(bool),
    /// Sets the pole of polar coordinates.
    Pole(PoleFrom),
    /// Takes the register setting back; true forgets it, false keeps it for `RestoreRegister`.
    CancelRegister(bool),
    /// Puts a cancelled register setting back.
    RestoreRegister,
    /// Selects a work offset, from 1.
    WorkOffset(u16),
    /// Selects the one of P among the further ones.
    ExtendedOffset,
    /// This block is in machine coordinates.
    MachineCoordinates,
    /// Tool length offset given in this block.
    ToolOffset,
    /// Tool length offset from the tool table, which a program does not carry: added (true) or taken away.
    ToolTableOffset(bool),
    /// No tool length offset.
    NoToolOffset,
    /// Sets offsets by L and P.
    SetData,
    /// Sets work offsets by L2 and P1 to P6; with anything else data that a path does not follow.
    SetWorkOffset,
    /// To a stored machine position: the first or the second.
    Home(u8),
    /// The same, of the axes that the block names only: without one nothing moves.
    HomeNamed(u8),
    /// Stores the present machine position as the first or the second.
    StoreHome(u8),
    /// Longitudinal turning cycle: X, Z, P1 depth of cut, P2 start of the exit taper.
    TurningCycle,
    /// A dwell whose time may be written as a coordinate.
    Dwell,
    /// A dwell of P seconds beside a move.
    Pause,
    /// A cycle that the runner knows but does not take apart: it ends where it began.
    OpaqueCycle,
    /// Such a cycle that stays in force: later coordinates call it again.
    OpaqueMotion,
    /// Such a cycle, or a call of what is not in the program, in this block only.
    OpaqueBlock,
    /// Changes where later positions are in a way that the runner does not follow.
    OpaqueMode,
    /// Calls the program of P with arguments.
    CallMacro,
    /// Calls it after each move that follows.
    ModalMacro,
    /// No macro after moves any more.
    EndModalMacro,
    /// Grooves side by side, in pecks along that axis (0 is X, 2 is Z).
    Groove(u8),
    /// Ends the points of a spline, which is cut.
    EndSpline,
    /// Runs the blocks from N of P to N of Q, then goes back to where it began.
    FinishContour,
    /// Roughs out the contour between N of P and N of Q; these blocks are passed over.
    RoughContour(Rough),
    /// Runs on, or roughs out, the contour of the subroutine that Q names.
    Profile(Profile),
    /// Without influence on the path.
    Inert,
}

/// What an M code means to the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum M {
    /// Ends the program.
    End,
    /// Runs the program of the number P, L times.
    CallProgram,
    /// Runs the blocks from N of P, L times.
    CallBlock,
    /// Goes back from a call; to N of P where that is given.
    Return,
    /// Puts the modal state away.
    SaveState,
    /// Puts it away and brings it back when the subroutine ends.
    SaveStateUntilReturn,
    /// Brings it back.
    RestoreState,
    /// Puts the tool of T into the spindle.
    ChangeTool,
    /// Without influence on the path.
    Inert,
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
    /// By T and D: an edge of the tool, whose lengths go to the axes that the plane says.
    Edge,
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

/// What controls do differently with the same codes.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Orientations of a lathe tool's tip are counted with the turret in front of the axis, as LinuxCNC does.
    pub tip_in_front: bool,
    /// Compensation begins square to the second move's start; else square to the first move's end.
    pub enters_beside_next: bool,
    /// R of a drilling cycle counts from where the cycle begins, and one without Q makes no pecks.
    pub drills_from_start: bool,
    /// Drilling cycles retract to the plane R (G99) from the start on; else to where they began (G98).
    pub retracts_to_plane: bool,
    /// Whether X is a diameter at the start is machine data: a turning program has to say it.
    pub diameter_is_machine_data: bool,
}

impl Rules {
    /// Those of most controls.
    pub const USUAL: Self = Self {
        tip_in_front: false,
        enters_beside_next: true,
        drills_from_start: false,
        retracts_to_plane: false,
        diameter_is_machine_data: false,
    };
}

/// A dialect's rules.
#[derive(Debug)]
pub struct Dialect {
    /// The name by which users ask for it.
    pub name: &'static str,
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
    /// White space within a number does not end it.
    pub spaced_numbers: bool,
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
    /// A coordinate without decimal point may count least increments: it is reported.
    pub point_decides: bool,
    /// How the offset of a tool comes into force.
    pub tool_offset: ToolOffset,
    /// What codes do beyond their meaning.
    pub rules: Rules,
    /// Address letters of moves that are not in the path.
    pub other_axes: Letters,
    /// Address letters that mean something.
    pub letters: Letters,
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
        DIALECTS.into_iter().find(|dialect| dialect.name == name)
    }

    /// How the radius of an arc is written, up to its value: `R`, `CR=`.
    pub fn radius_address(&self) -> String {
        self.names.spelt(Name::Address(b'R')).map_or_else(|| "R".to_owned(), |name| format!("{name}="))
    }

    /// Meaning of the G code of that number, which counts to the tenth.
    #[inline]
    pub fn g_code(&self, number: f64) -> Option<G> {
        let tenths = 10.0 * number;
        if tenths > -0.5 && tenths < 9999.5 {
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

/// Byte classes that all dialects share: letters, white space and NUL, line end, percent sign.
pub(crate) const fn common_classes(own: &[(u8, Class)]) -> [Class; 256] {
    let mut classes = [Class::Other; 256];
    let mut byte = 0;
    while byte < 256 {
        classes[byte] = match byte as u8 {
            b'\n' => Class::LineEnd,
            b' ' | b'\t' | b'\r' | 0x0b | 0x0c | 0 => Class::Space,
            b'A'..=b'Z' | b'a'..=b'z' => Class::Letter,
            b'%' => Class::Percent,
            b'/' => Class::Slash,
            _ => Class::Other,
        };
        byte += 1;
    }
    let mut index = 0;
    while index < own.len() {
        classes[own[index].0 as usize] = own[index].1;
        index += 1;
    }
    classes
}
