//! Tools as compensation needs them: radius, and on a lathe which way the tip lies from the nose's centre.

use crate::dialect::Dialect;
use crate::modes::modal::{Modal, Plane};

/// A tool that the user tells of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// Number by which the program calls it: D, or that of the offset or tool; without one, whichever is called.
    pub number: Option<i32>,
    /// Radius of nose or cutter, mm.
    pub radius: f64,
    /// The control's number of the tip's orientation, 0 to 9; 0 and 9 are the nose's centre.
    pub tip: Option<u8>,
    /// Length, mm, which G43 adds along Z.
    pub length: Option<f64>,
    /// Offset of the tool table (x, y, z), mm, x a radius: geometry and wear, which T0101 of a lathe adds.
    pub offset: Option<[f64; 3]>,
    /// Which of its edges, D of a Sinumerik; without one, any.
    pub edge: Option<i32>,
}

/// The tool that a program calls by a number, and by its edge where the control has such: the one that has it, or the
/// one that has none.
pub(crate) fn called(tools: &[Tool], number: i32, edge: Option<i32>) -> Option<&Tool> {
    let with = |number, own: Option<i32>| tools.iter().find(|tool| tool.number == number && tool.edge == own);
    match edge {
        None => {
            tools.iter().find(|tool| tool.number == Some(number)).or(tools.iter().find(|tool| tool.number.is_none()))
        }
        edge => [Some(number), None].into_iter().find_map(|number| with(number, edge).or(with(number, None))),
    }
}

/// What the program says of the tool where it switches compensation on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Called {
    /// D, or the number of the offset or tool.
    pub number: i32,
    /// Radius, mm, where the program gives it; else negative.
    pub radius: f64,
    /// Orientation that the program gives.
    pub tip: u8,
    /// The edge, where the control has such.
    pub edge: Option<i32>,
    /// What the call of the tool adds to its radius, mm.
    pub oversize: f64,
}

/// Before any compensation.
pub(crate) const NONE_CALLED: Called = Called { number: 0, radius: -1.0, tip: 0, edge: None, oversize: 0.0 };

/// A tool resolved: radius, and the controlled point less the centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cutter {
    pub radius: f64,
    pub tip: [f64; 3],
}

/// The tool in force; what is not known of it otherwise.
pub(crate) fn cutter(state: &Modal, tools: &[Tool], dialect: &Dialect) -> Result<Cutter, String> {
    let called = state.called;
    let lathe = state.plane == Plane::Zx;
    if called.radius >= 0.0 {
        return Ok(Cutter { radius: called.radius, tip: tip(called.tip, called.radius, dialect) });
    }
    let Some(tool) = self::called(tools, called.number, called.edge) else {
        return Err(format!("the radius of tool {} is not known", called.number));
    };
    match tool.tip {
        None if lathe => Err(format!("the orientation of the tip of tool {} is not known", called.number)),
        number => {
            let number = if lathe { number.unwrap_or(0) } else { 0 };
            Ok(Cutter { radius: tool.radius + called.oversize, tip: tip(number, tool.radius, dialect) })
        }
    }
}

/// From the nose's centre to the imaginary tip.
fn tip(number: u8, radius: f64, dialect: &Dialect) -> [f64; 3] {
    let [x, z] = tip_direction(number, dialect);
    [x * radius, 0.0, z * radius]
}

/// The same (x, z) of a nose of radius 1. LinuxCNC counts as with the turret in front, others with it behind.
pub fn tip_direction(number: u8, dialect: &Dialect) -> [f64; 2] {
    let (x, z) = match number {
        1 => (1.0, 1.0),
        2 => (1.0, -1.0),
        3 => (-1.0, -1.0),
        4 => (-1.0, 1.0),
        5 => (0.0, 1.0),
        6 => (1.0, 0.0),
        7 => (0.0, -1.0),
        8 => (-1.0, 0.0),
        _ => (0.0, 0.0),
    };
    [if dialect.rules.tip_in_front { -x } else { x }, z]
}
