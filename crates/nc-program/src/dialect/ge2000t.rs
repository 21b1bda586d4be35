//! GE Mark Century 2000T, as in the turning programs of NISTIR 6811, Appendix A.
//!
//! X is a diameter, I a radius. Arc centres are signed offsets from the start point, so an arc may turn through more
//! than a quadrant. Parameters P1, P2, … of a cycle are words of its block; others are variables.

use super::{common_classes, usual, Class, Dialect, Letters, Naming, Parameters, G, M, PLAIN};
use crate::controls;
use crate::modes::modal::{Modal, Plane};

/// The dialect.
pub const GE2000T: Dialect = Dialect {
    name: "ge2000t",
    classes: common_classes(&[(b'!', Class::LineComment), (b'(', Class::Statement)]),
    brackets: (b'(', b')'),
    parameters: Parameters { mark: b'P', named: Naming::None, computed: false, unset_is_zero: false },
    decimal_comma: true,
    rules: controls::GE2000T,
    letters: Letters::of(b"FGIJKMNPQRSTXYZ"),
    g: g_code,
    m: m_code,
    initial: Modal { inch: true, diameter: true, plane: Plane::Zx, ..Modal::INITIAL },
    resolution: (1e-5, 1e-4),
    comment: ("! ", ""),
    ..PLAIN
};

fn g_code(tenths: u16) -> Option<G> {
    Some(match tenths {
        40 => G::Dwell,
        700 => G::Inch(true),
        710 => G::Inch(false),
        800 => G::NoMotion,
        810 => G::TurningCycle,
        920 => G::SetRegister,
        _ => return usual(tenths),
    })
}

fn m_code(number: u16) -> Option<M> {
    match number {
        2 | 30 => Some(M::End),
        0..=99 => Some(M::Inert),
        _ => None,
    }
}
