//! RS-274 as LinuxCNC 2.9 reads it.

use super::{
    common_classes, usual, Blanks, Class, Dialect, FlowStyle, Functions, Letters, Naming, Parameters, ToolOffset, G, M,
    PLAIN,
};
use crate::controls;
use crate::drilling::drill::Drill;
use crate::modes::modal::{Compensation, FeedMode, Modal, Motion, Plane};
use crate::shapes::spline::Spline;
use crate::turning::level_cuts::Pockets;
use crate::turning::profile_cycle::Profile;

/// The dialect.
pub const LINUXCNC: Dialect = Dialect {
    name: "linuxcnc",
    classes: common_classes(&[
        (b';', Class::LineComment),
        (b'(', Class::Comment),
        (b'#', Class::Parameter),
        (b'@', Class::Letter),
        (b'^', Class::Letter),
    ]),
    parameters: Parameters { mark: b'#', named: Naming::Brackets, computed: true, unset_is_zero: true },
    functions: Functions::Rs274,
    blanks: Blanks::WithinNumber,
    turns: true,
    flow: FlowStyle::OWords,
    tool_offset: ToolOffset::Code,
    rules: controls::LINUXCNC,
    other_axes: Letters::of(b"ABCUVW"),
    letters: Letters::of(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"),
    g: g_code,
    m: m_code,
    initial: Modal { inch: true, diameter: false, plane: Plane::Xy, ..Modal::INITIAL },
    resolution: (1e-6, 1e-5),
    ..PLAIN
};

fn g_code(tenths: u16) -> Option<G> {
    Some(match tenths {
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
        411 => G::CompensationGiven(Compensation::Left),
        421 => G::CompensationGiven(Compensation::Right),
        430 | 432 => G::ToolTableOffset(true),
        431 => G::ToolOffset,
        490 => G::NoToolOffset,
        520 => G::OffsetRegister,
        920 => G::SetRegister,
        530 => G::MachineCoordinates,
        540 | 550 | 560 | 570 | 580 => G::WorkOffset((tenths - 530) / 10),
        590 => G::WorkOffset(6),
        591..=593 => G::WorkOffset(tenths - 584),
        50 => G::Motion(Motion::Spline(Spline::Cubic)),
        51 => G::Motion(Motion::Spline(Spline::Quadratic)),
        52 => G::Motion(Motion::Spline(Spline::Points)),
        53 => G::EndSpline,
        331 => G::OpaqueCycle,
        700 => G::Profile(Profile::Finish),
        710..=712 => G::Profile(Profile::Along(pockets(tenths))),
        720..=722 => G::Profile(Profile::Face(pockets(tenths))),
        760 => G::Thread,
        730 => G::Drill(Drill::Chip),
        810 | 820 | 860 => G::Drill(Drill::Plain),
        830 => G::Drill(Drill::Peck),
        850 => G::Drill(Drill::Ream),
        740 | 840 | 890 => G::Drill(Drill::Bore),
        870 | 880 => G::OpaqueCycle,
        800 => G::NoMotion,
        901 => G::CentreAbsolute(true),
        911 => G::CentreAbsolute(false),
        921 => G::CancelRegister(true),
        922 => G::CancelRegister(false),
        923 => G::RestoreRegister,
        930 => G::Feed(FeedMode::InverseTime),
        980 => G::RetractToPlane(false),
        990 => G::RetractToPlane(true),
        40 => G::Pause,
        610 | 611 | 640 => G::Inert,
        _ => return usual(tenths),
    })
}

/// Which pockets G71 and G72, their .1 and their .2 cut.
fn pockets(tenths: u16) -> Pockets {
    match tenths % 10 {
        0 => Pockets::All,
        1 => Pockets::None,
        _ => Pockets::Rest,
    }
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
