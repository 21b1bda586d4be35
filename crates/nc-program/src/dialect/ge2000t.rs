//! GE Mark Century 2000T, as in the turning programs of NISTIR 6811, Appendix A.
//!
//! X is a diameter, I a radius. Arc centres are signed offsets from the start point, so an arc may turn through more
//! than a quadrant. Parameters P1, P2, … of a cycle are words of its block; others are variables.

use super::{
    common_classes, Blanks, Class, Dialect, FlowStyle, Functions, Letters, Names, Naming, Parameters, ToolOffset, G, M,
};
use crate::controls;
use crate::modal::{Compensation, FeedMode, Modal, Motion, Plane, SpindleMode};

/// The dialect.
pub const GE2000T: Dialect = Dialect {
    name: "ge2000t",
    names: Names::NONE,
    formulas: false,
    classes: common_classes(&[(b'!', Class::LineComment), (b'(', Class::Statement)]),
    brackets: (b'(', b')'),
    parameters: Parameters { mark: b'P', named: Naming::None, computed: false, unset_is_zero: false },
    functions: Functions::None,
    blanks: Blanks::End,
    decimal_comma: true,
    turns: false,
    line_angle: b"",
    about_pole: false,
    flow: FlowStyle::None,
    increments: None,
    tool_offset: ToolOffset::Unknown,
    rules: controls::GE2000T,
    other_axes: Letters::of(b""),
    letters: Letters::of(b"FGIJKMNPQRSTXYZ"),
    g: g_code,
    m: m_code,
    initial: Modal { inch: true, diameter: true, plane: Plane::Zx, ..Modal::INITIAL },
    resolution: (1e-5, 1e-4),
    comment: ("! ", ""),
};

fn g_code(tenths: u16) -> Option<G> {
    Some(match tenths {
        0 => G::Motion(Motion::Rapid),
        10 => G::Motion(Motion::Line),
        20 => G::Motion(Motion::Clockwise),
        30 => G::Motion(Motion::Counterclockwise),
        40 => G::Dwell,
        400 => G::Compensation(Compensation::Off),
        410 => G::Compensation(Compensation::Left),
        420 => G::Compensation(Compensation::Right),
        700 => G::Inch(true),
        710 => G::Inch(false),
        800 => G::NoMotion,
        810 => G::TurningCycle,
        900 => G::Incremental(false),
        910 => G::Incremental(true),
        920 => G::SetRegister,
        940 => G::Feed(FeedMode::PerMinute),
        950 => G::Feed(FeedMode::PerRevolution),
        960 => G::Spindle(SpindleMode::SurfaceSpeed),
        970 => G::Spindle(SpindleMode::Revolutions),
        _ => return None,
    })
}

fn m_code(number: u16) -> Option<M> {
    match number {
        2 | 30 => Some(M::End),
        0..=99 => Some(M::Inert),
        _ => None,
    }
}
