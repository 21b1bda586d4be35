//! Heidenhain Klartext (TNC 426 to TNC 640): milling.
//!
//! Words and cycles are from memory of the user's manuals, none of it looked up; compared with excerpts of a few public
//! programs, most of them written by CAM systems. No control and no simulator has confirmed a path.
//! A block's function says how its coordinates move: nothing of it stays in force but feed, compensation and the pole.

use super::{
    common_classes, Class, Dialect, FlowStyle, Functions, Name, Names, Naming, Parameters, PoleFrom, Rules, G, M,
};
use crate::flow::Flow;
use crate::modal::{Compensation, Modal, Motion, Plane};

/// The dialect.
pub const HEIDENHAIN: Dialect = Dialect {
    name: "heidenhain",
    names: NAMES,
    formulas: true,
    classes: common_classes(&[
        (b';', Class::LineComment),
        (b'*', Class::LineComment),
        (b'~', Class::Space),
        (b'R', Class::Name),
        (b'M', Class::Name),
        (b'0', Class::Digit),
        (b'1', Class::Digit),
        (b'2', Class::Digit),
        (b'3', Class::Digit),
        (b'4', Class::Digit),
        (b'5', Class::Digit),
        (b'6', Class::Digit),
        (b'7', Class::Digit),
        (b'8', Class::Digit),
        (b'9', Class::Digit),
    ]),
    brackets: (b'(', b')'),
    parameters: Parameters { mark: b'Q', named: Naming::Plain, computed: true, unset_is_zero: false },
    functions: Functions::Klartext,
    spaced_numbers: false,
    decimal_comma: false,
    turns: false,
    about_pole: true,
    flow: FlowStyle::Labels,
    increments: None,
    point_decides: false,
    tool_has_offset: false,
    rules: Rules::USUAL,
    other_axes: b"ABCUVW",
    letters: b"ABCFMNQRSTUVWXYZ",
    g: |_| None,
    m: m_code,
    initial: Modal::INITIAL,
    resolution: (1e-5, 1e-4),
    comment: ("; ", ""),
};

/// M codes not listed are the machine builder's. M89 and M99 run a cycle, whose moves are not known.
fn m_code(number: u16) -> Option<M> {
    match number {
        2 | 30 => Some(M::End),
        89 | 99 => None,
        0..=999 => Some(M::Inert),
        _ => None,
    }
}

const CYCLE: Name = Name::Text(G::OpaqueBlock);
const FRAME: Name = Name::Text(G::OpaqueMode);
const TEXT: Name = Name::Text(G::Inert);

const NAMES: Names = Names::of(&[
    ("APPR\t", CYCLE),
    ("BEGIN PGM", Name::Text(G::Heading)),
    ("BLK FORM", TEXT),
    ("CALL LBL", Name::Flow(Flow::CallLabel)),
    ("CALL PGM", CYCLE),
    ("CC\t", Name::Code(G::Pole(PoleFrom::Coordinates))),
    ("CHF", Name::Address(b'w')),
    ("CP\t", Name::Code(G::Motion(Motion::Counterclockwise))),
    ("CR\t", Name::Code(G::Motion(Motion::Counterclockwise))),
    ("CTP\t", Name::Code(G::Motion(Motion::Tangent))),
    ("CT\t", Name::Code(G::Motion(Motion::Tangent))),
    ("CYCL CALL", CYCLE),
    ("CYCL DEF 7.0", TEXT),
    ("CYCL DEF 7.#", Name::Code(G::OffsetRegister)),
    ("CYCL DEF 8.", FRAME),
    ("CYCL DEF 9.", TEXT),
    ("CYCL DEF 10.", FRAME),
    ("CYCL DEF 11.", FRAME),
    ("CYCL DEF 13.", TEXT),
    ("CYCL DEF 19.", FRAME),
    ("CYCL DEF 26.", FRAME),
    ("CYCL DEF 32.", TEXT),
    ("CYCL DEF 247", FRAME),
    ("CYCL DEF", CYCLE),
    ("C\t", Name::Code(G::Motion(Motion::Counterclockwise))),
    ("DEP\t", CYCLE),
    ("DR+\t", Name::Code(G::Motion(Motion::Counterclockwise))),
    ("DR-\t", Name::Code(G::Motion(Motion::Clockwise))),
    ("DL", Name::Address(b'd')),
    ("DR2", Name::Address(b'e')),
    ("DR", Name::Address(b'g')),
    ("END PGM", Name::Text(G::Inert)),
    ("F MAX\t", Name::Code(G::Fast)),
    ("F AUTO\t", Name::Inert),
    ("FN 9:", Name::Flow(Flow::Compare)),
    ("FN 10:", Name::Flow(Flow::Compare)),
    ("FN 11:", Name::Flow(Flow::Compare)),
    ("FN 12:", Name::Flow(Flow::Compare)),
    ("FN #:", Name::Inert),
    ("FUNCTION", TEXT),
    ("FZ", Name::Address(b'f')),
    ("FU", Name::Address(b'f')),
    ("IPA", Name::Increment(b'q')),
    ("IPR", Name::Increment(b'p')),
    ("IX", Name::Increment(b'X')),
    ("IY", Name::Increment(b'Y')),
    ("IZ", Name::Increment(b'Z')),
    ("IA", Name::Increment(b'A')),
    ("IB", Name::Increment(b'B')),
    ("IC", Name::Increment(b'C')),
    ("LBL", Name::Flow(Flow::Label)),
    ("LP\t", Name::Code(G::Motion(Motion::Line))),
    ("L\t", Name::Code(G::Motion(Motion::Line))),
    ("M91\t", Name::Code(G::MachineCoordinates)),
    ("M140 MB", CYCLE),
    ("M92\t", Name::Code(G::OpaqueBlock)),
    ("PA", Name::Address(b'q')),
    ("PR", Name::Address(b'p')),
    ("PLANE", FRAME),
    ("R0\t", Name::Code(G::Compensation(Compensation::Off))),
    ("RL\t", Name::Code(G::Compensation(Compensation::Left))),
    ("RND R", Name::Address(b'r')),
    ("RND", Name::Address(b'r')),
    ("RR\t", Name::Code(G::Compensation(Compensation::Right))),
    ("STOP", Name::Inert),
    ("TCH PROBE", CYCLE),
    ("TOOL CALL Z\t", Name::Code(G::Plane(Plane::Xy))),
    ("TOOL CALL", Name::Address(b'T')),
    ("TOOL DEF", TEXT),
    ("TRANS DATUM", FRAME),
    ("X\t", Name::Code(G::Plane(Plane::Yz))),
    ("Y\t", Name::Code(G::Plane(Plane::Zx))),
    ("Z\t", Name::Code(G::Plane(Plane::Xy))),
]);
