//! RS-274 as LinuxCNC 2.9 reads it.

use super::{common_classes, Class, Dialect, FlowStyle, Functions, Parameters, Rules, G, M};
use crate::modal::{Compensation, FeedMode, Modal, Motion, Plane, SpindleMode};

/// The dialect.
pub const LINUXCNC: Dialect = Dialect {
    name: "linuxcnc",
    classes: common_classes(&[(b';', Class::LineComment), (b'(', Class::Comment), (b'#', Class::Parameter)]),
    brackets: (b'[', b']'),
    parameters: Parameters { mark: b'#', named: true, computed: true, unset_is_zero: true },
    functions: Functions::Rs274,
    spaced_numbers: true,
    decimal_comma: false,
    turns: true,
    flow: FlowStyle::OWords,
    increments: None,
    point_decides: false,
    tool_has_offset: false,
    rules: Rules { tip_in_front: true, enters_beside_next: false },
    other_axes: b"",
    letters: b"ABCDEFGHIJKLMNOPQRSTUVWXYZ",
    g: g_code,
    m: m_code,
    initial: Modal { inch: true, diameter: false, plane: Plane::Xy, ..Modal::INITIAL },
    resolution: (1e-6, 1e-5),
    comment: ("(", ")"),
};

fn g_code(tenths: u16) -> Option<G> {
    Some(match tenths {
        0 => G::Motion(Motion::Rapid),
        10 => G::Motion(Motion::Line),
        20 => G::Motion(Motion::Clockwise),
        30 => G::Motion(Motion::Counterclockwise),
        330 => G::Motion(Motion::Thread),
        382..=385 => G::Motion(Motion::Probe),
        70 => G::Diameter(true),
        80 => G::Diameter(false),
        100 => G::SetData,
        170 => G::Plane(Plane::Xy),
        180 => G::Plane(Plane::Zx),
        190 => G::Plane(Plane::Yz),
        200 => G::Inch(true),
        210 => G::Inch(false),
        280 => G::Home(0),
        281 => G::StoreHome(0),
        300 => G::Home(1),
        301 => G::StoreHome(1),
        400 => G::Compensation(Compensation::Off),
        410 => G::Compensation(Compensation::Left),
        411 => G::CompensationGiven(Compensation::Left),
        420 => G::Compensation(Compensation::Right),
        421 => G::CompensationGiven(Compensation::Right),
        430 | 432 => G::ToolTableOffset,
        431 => G::ToolOffset,
        490 => G::NoToolOffset,
        520 => G::OffsetRegister,
        920 => G::SetRegister,
        530 => G::MachineCoordinates,
        540 | 550 | 560 | 570 | 580 => G::WorkOffset(((tenths - 530) / 10) as u8),
        590 => G::WorkOffset(6),
        591..=593 => G::WorkOffset((tenths - 584) as u8),
        50 | 51 | 52 | 53 | 331 | 700..=702 | 710..=712 | 720..=722 | 730 | 740 | 760 => G::OpaqueCycle,
        810 | 820 | 830 | 840 | 850 | 860 | 870 | 880 | 890 => G::OpaqueCycle,
        800 => G::NoMotion,
        900 => G::Incremental(false),
        901 => G::CentreAbsolute(true),
        910 => G::Incremental(true),
        911 => G::CentreAbsolute(false),
        921 => G::CancelRegister(true),
        922 => G::CancelRegister(false),
        923 => G::RestoreRegister,
        930 => G::Feed(FeedMode::InverseTime),
        940 => G::Feed(FeedMode::PerMinute),
        950 => G::Feed(FeedMode::PerRevolution),
        960 => G::Spindle(SpindleMode::SurfaceSpeed),
        970 => G::Spindle(SpindleMode::Revolutions),
        40 | 610 | 611 | 640 | 980 | 990 => G::Inert,
        _ => return None,
    })
}

fn m_code(number: u16) -> Option<M> {
    match number {
        2 | 30 => Some(M::End),
        6 => Some(M::ChangeTool),
        70 => Some(M::SaveState),
        72 => Some(M::RestoreState),
        73 => Some(M::SaveStateUntilReturn),
        0..=9 | 19 | 48..=53 | 60..=71 | 100..=199 => Some(M::Inert),
        _ => None,
    }
}
