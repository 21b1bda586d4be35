//! Okuma OSP, turning, with its lathe auto-programming (LAP).
//!
//! What a manual confirms docs/dialects.md says; the spelling was compared with one public shop program. Attachments, the
//! second turret and flow control are said and not followed.

use super::{
    common_classes, usual, Class, Dialect, Functions, Letters, Name, Names, Naming, Parameters, ToolOffset, G, M, PLAIN,
};
use crate::controls;
use crate::modes::modal::{FeedMode, Modal, Plane};
use crate::turning::lap::Lap;
use crate::turning::rough::Rough;

/// The dialect.
pub const OKUMA_LATHE: Dialect = Dialect {
    name: "okuma-lathe",
    names: NAMES,
    formulas: true,
    classes: common_classes(&[(b'(', Class::Comment), (b'$', Class::Name)]),
    parameters: Parameters { mark: b'V', named: Naming::Plain, computed: true, unset_is_zero: false },
    functions: Functions::Macro,
    tool_offset: ToolOffset::Edge(b'u'),
    rules: controls::OKUMA_LATHE,
    other_axes: Letters::of(b"CUWY"),
    letters: Letters::of(b"CDEFGHIJKLMNOPQSTUVWXYZ"),
    g: |tenths| controls::okuma_lathe(tenths).or_else(|| g_code(tenths)),
    m: m_code,
    initial: Modal { diameter: true, plane: Plane::Zx, feed_mode: FeedMode::PerRevolution, ..Modal::INITIAL },
    ..PLAIN
};

fn g_code(tenths: u16) -> Option<G> {
    if !tenths.is_multiple_of(10) {
        return None;
    }
    Some(match tenths / 10 {
        4 => G::Dwell,
        17 => G::Plane(Plane::Xy),
        18 => G::Plane(Plane::Zx),
        19 => G::Plane(Plane::Yz),
        50 => G::SetRegister,
        80 => G::Lap(Lap::End),
        81 => G::Lap(Lap::Begin),
        82 => G::Lap(Lap::BeginFacing),
        83 => G::Lap(Lap::Blank),
        85 => G::Lap(Lap::Rough(Rough::Along)),
        86 => G::Lap(Lap::Rough(Rough::Pattern)),
        87 => G::Lap(Lap::Finish),
        20 | 21 | 30..=32 | 71..=74 | 77 | 78 | 88 => G::OpaqueBlock,
        14 | 34 | 35 | 75 | 76 | 84 | 101..=103 | 107 | 136..=138 => G::OpaqueMode,
        13 | 64 | 65 | 110 | 111 | 140 | 141 => G::Inert,
        _ => return usual(tenths),
    })
}

/// M codes are the machine builder's, except those that end a program: none of them moves an axis of the path.
fn m_code(number: u16) -> Option<M> {
    match number {
        2 | 30 => Some(M::End),
        0..=999 => Some(M::Inert),
        _ => None,
    }
}

/// The rest of the line is of no influence on the path: drawing on the screen.
const DRAWING: Name = Name::Text(G::Inert);
/// Flow control: not followed.
const UNFOLLOWED: Name = Name::Text(G::OpaqueMode);

const NAMES: Names = Names::of(&[
    ("$", Name::Text(G::OpaqueBlock)),
    ("CALL", Name::Text(G::CallNamed)),
    ("CLEAR", DRAWING),
    ("DEF", DRAWING),
    ("DRAW", DRAWING),
    ("END", DRAWING),
    ("GOTO", UNFOLLOWED),
    ("HP", Name::Inert),
    ("IF", UNFOLLOWED),
    ("MODIN", UNFOLLOWED),
    ("MODOUT", UNFOLLOWED),
    ("NOEX", UNFOLLOWED),
    ("OG", Name::Address(b'u')),
    ("PT", DRAWING),
    ("QA", Name::Inert),
    ("RTS", Name::Function(M::Return)),
    ("SB", Name::Inert),
    ("TG", Name::Address(b'T')),
    ("TLID", Name::Inert),
]);
