//! Fanuc series 16 to 31 with custom macro B: turning in code systems A and B, milling.
//!
//! Which codes are confirmed, and by what, docs/dialects.md says; they were compared with public shop programs. What the
//! manuals leave to the machine's parameters (numbers without a point, offsets of T) is reported where a program depends on it.

use super::{
    common_classes, modes, shared, Blanks, Class, Dialect, FlowStyle, Functions, Letters, Naming, Parameters,
    ToolOffset, G, M, PLAIN,
};
use crate::controls;
use crate::drilling::drill::Drill;
use crate::modes::modal::{FeedMode, Modal, Motion, Plane};
use crate::turning::pass::Pass;
use crate::turning::rough::Rough;

/// Turning, code system A: X, Z absolute, U, W increments, G98/G99 feed a minute and a revolution.
pub const FANUC_LATHE: Dialect = Dialect {
    name: "fanuc-lathe",
    letters: Letters::of(b"ACDEFGHIJKLMNOPQRSTUVWXYZ"),
    line_angle: b"Aa",
    rules: controls::FANUC_LATHE,
    increments: Some(*b"UVW"),
    tool_offset: ToolOffset::InT,
    other_axes: Letters::of(b"CH"),
    g: |tenths| controls::fanuc_lathe(tenths).or_else(|| lathe_a(tenths)),
    initial: Modal { diameter: true, plane: Plane::Zx, feed_mode: FeedMode::PerRevolution, ..Modal::INITIAL },
    ..FANUC_MILL
};

/// Turning, code system B: G90/G91, G94/G95 as in milling, cycles G77 to G79.
pub const FANUC_LATHE_B: Dialect = Dialect {
    name: "fanuc-lathe-b",
    g: |tenths| controls::fanuc_lathe_b(tenths).or_else(|| lathe_b(tenths)),
    rules: controls::FANUC_LATHE_B,
    increments: None,
    other_axes: Letters::of(b"CHUW"),
    ..FANUC_LATHE
};

/// Milling.
pub const FANUC_MILL: Dialect = Dialect {
    name: "fanuc-mill",
    classes: common_classes(&[
        (b'(', Class::Comment),
        (b'#', Class::Parameter),
        (b',', Class::Comma),
        (b':', Class::Letter),
    ]),
    parameters: Parameters { mark: b'#', named: Naming::None, computed: true, unset_is_zero: false },
    functions: Functions::Macro,
    blanks: Blanks::BeforeNumber,
    flow: FlowStyle::Macro,
    tool_offset: ToolOffset::Code,
    rules: controls::FANUC_MILL,
    other_axes: Letters::of(b"ABC"),
    letters: Letters::of(b"ABCDEFGHIJKLMNOPQRSTXYZ"),
    g: |tenths| controls::fanuc_mill(tenths).or_else(|| mill(tenths)),
    m: m_code,
    ..PLAIN
};

/// High speed and smoothing: look-ahead, contour control, smooth interpolation, high precision. P of G05 from 10001 on
/// calls what is not in the program.
const LOOK_AHEAD: G = G::Setting(b'P', &[0.0, 1.0]);
const CONTOUR_CONTROL: G = G::Setting(b'Q', &[0.0, 1.0, 2.0, 3.0]);
const HIGH_PRECISION: G = G::Setting(b'P', &[0.0, 10000.0]);

/// Codes that turning and milling share.
pub(crate) fn common(tenths: u16) -> Option<G> {
    Some(match tenths {
        310 => G::Motion(Motion::Probe),
        40 => G::Dwell,
        100 => G::SetWorkOffset,
        170 => G::Plane(Plane::Xy),
        180 => G::Plane(Plane::Zx),
        190 => G::Plane(Plane::Yz),
        200 => G::Inch(true),
        210 => G::Inch(false),
        280 => G::HomeNamed(0),
        300 => G::HomeNamed(1),
        520 => G::OffsetRegister,
        530 => G::MachineCoordinates,
        540 | 550 | 560 | 570 | 580 | 590 => G::WorkOffset((tenths - 530) / 10),
        650 => G::CallMacro,
        660 => G::ModalMacro,
        670 => G::EndModalMacro,
        680 | 121 | 1120 => G::OpaqueMode,
        50 => HIGH_PRECISION,
        51 => CONTOUR_CONTROL,
        80 => LOOK_AHEAD,
        90 | 110 | 131 | 220 | 230 | 250 | 260 | 610..=611 | 620 | 630 | 640 | 690 | 1130 => G::Inert,
        _ => return shared(tenths),
    })
}

/// Codes that all turning has.
fn lathe(tenths: u16) -> Option<G> {
    Some(match tenths {
        320 | 330 => G::Motion(Motion::Thread),
        700 => G::FinishContour,
        710 => G::RoughContour(Rough::Along),
        720 => G::RoughContour(Rough::Face),
        730 => G::RoughContour(Rough::Pattern),
        740 => G::Groove(2),
        750 => G::Groove(0),
        760 => G::Thread,
        830 => G::DrillAlong(Drill::Peck, 2),
        840 => G::DrillAlong(Drill::Tap, 2),
        850 => G::DrillAlong(Drill::Ream, 2),
        870 => G::DrillAlong(Drill::Peck, 0),
        880 => G::DrillAlong(Drill::Tap, 0),
        890 => G::DrillAlong(Drill::Ream, 0),
        _ => return common(tenths),
    })
}

pub(crate) fn lathe_a(tenths: u16) -> Option<G> {
    Some(match tenths {
        330 => return None,
        500 => G::SetRegister,
        900 => G::Pass(Pass::Along),
        920 => G::Pass(Pass::Thread),
        940 => G::Pass(Pass::Face),
        980 => G::Feed(FeedMode::PerMinute),
        990 => G::Feed(FeedMode::PerRevolution),
        _ => return lathe(tenths),
    })
}

fn lathe_b(tenths: u16) -> Option<G> {
    Some(match tenths {
        320 => return None,
        770 => G::Pass(Pass::Along),
        780 => G::Pass(Pass::Thread),
        790 => G::Pass(Pass::Face),
        920 => G::SetRegister,
        980 => G::RetractToPlane(false),
        990 => G::RetractToPlane(true),
        _ => return modes(tenths).or_else(|| lathe(tenths)),
    })
}

pub(crate) fn mill(tenths: u16) -> Option<G> {
    Some(match tenths {
        330 => G::Motion(Motion::Thread),
        430 => G::ToolTableOffset(true),
        440 => G::ToolTableOffset(false),
        490 => G::NoToolOffset,
        500 => G::Inert,
        510 | 160 => G::OpaqueMode,
        150 => G::Inert,
        541 => G::ExtendedOffset,
        600 => G::OpaqueBlock,
        730 => G::Drill(Drill::Chip),
        740 | 840 => G::Drill(Drill::Tap),
        810 | 820 | 860 => G::Drill(Drill::Plain),
        830 => G::Drill(Drill::Peck),
        850 | 890 => G::Drill(Drill::Ream),
        760 | 870 | 880 => G::OpaqueMotion,
        920 => G::SetRegister,
        930 => G::Feed(FeedMode::InverseTime),
        980 => G::RetractToPlane(false),
        990 => G::RetractToPlane(true),
        _ => return modes(tenths).or_else(|| common(tenths)),
    })
}

/// Most M codes are the machine builder's: none of them moves an axis of the path.
pub(crate) fn m_code(number: u16) -> Option<M> {
    match number {
        2 | 30 => Some(M::End),
        6 => Some(M::ChangeTool),
        98 => Some(M::CallProgram),
        99 => Some(M::Return),
        0..=999 => Some(M::Inert),
        _ => None,
    }
}
