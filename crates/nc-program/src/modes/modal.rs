//! Modal state: what stays in force from block to block.

use crate::modes::tool::{Called, NONE_CALLED};
use crate::shapes::spline::Spline;

/// Motion in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// G00.
    Rapid,
    /// G01.
    Line,
    /// G02: clockwise, seen against the third axis of the plane.
    Clockwise,
    /// G03.
    Counterclockwise,
    /// An arc that leaves as the move before arrives.
    Tangent,
    /// An arc through a point.
    Through,
    /// Toward or away from a touch.
    Probe,
    /// A line synchronised with the spindle.
    Thread,
    /// A drilling cycle.
    Drill,
    /// A simple turning cycle.
    Pass,
    /// A cycle that is not taken apart.
    Opaque,
    /// None: a coordinate alone does nothing.
    None,
    /// A spline.
    Spline(Spline),
}

/// Plane of arcs, named by its first and second axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Plane {
    /// G17.
    Xy = 17,
    /// G18: z to the right, x up.
    Zx = 18,
    /// G19.
    Yz = 19,
}

impl Plane {
    /// Indices of the first, second and third axis (X, Y, Z are 0, 1, 2).
    pub const fn axes(self) -> (usize, usize, usize) {
        match self {
            Self::Xy => (0, 1, 2),
            Self::Zx => (2, 0, 1),
            Self::Yz => (1, 2, 0),
        }
    }
}

/// Unit of feed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FeedMode {
    /// 1/min: the move takes 1/F minutes.
    InverseTime = 93,
    /// mm/min.
    PerMinute = 94,
    /// mm/rev.
    PerRevolution = 95,
}

/// The unit in which F counts lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FeedUnit {
    /// That of lengths.
    OfLengths,
    /// Inch (true) or mm, whatever lengths are in.
    Fixed(bool),
    /// The machine's basic unit, which nobody has said.
    Unknown,
}

/// Unit of spindle speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum SpindleMode {
    /// Constant surface speed.
    SurfaceSpeed = 96,
    /// Revolutions per minute.
    Revolutions = 97,
}

/// Cutter compensation in force. A run's path is the programmed one; `compensated` offsets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Compensation {
    /// None.
    Off = 40,
    /// Tool left of the contour.
    Left = 41,
    /// Tool right of the contour.
    Right = 42,
}

/// The state at a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modal {
    /// Motion.
    pub motion: Motion,
    /// Plane of arcs.
    pub plane: Plane,
    /// Program unit: inch or millimetre.
    pub inch: bool,
    /// X words are diameters.
    pub diameter: bool,
    /// X increments are radii even then.
    pub radius_increments: bool,
    /// Coordinates are increments.
    pub incremental: bool,
    /// Arc centres are absolute.
    pub centre_absolute: bool,
    /// Unit of feed.
    pub feed_mode: FeedMode,
    /// Feed in mm/min or mm/rev; negative before the first F word, or where it is not known.
    pub feed: f64,
    /// What F counts: the unit of lengths, or the machine's own.
    pub feed_unit: FeedUnit,
    /// Unit of spindle speed.
    pub spindle_mode: SpindleMode,
    /// The S word as programmed; negative before the first.
    pub spindle_speed: f64,
    /// The greatest speed that the program allows with constant surface speed, 1/min; negative before the first.
    pub spindle_limit: f64,
    /// The T word as programmed; −1 before the first.
    pub tool: i32,
    /// The T word at the last tool change by M06; −1 before.
    pub spindle_tool: i32,
    /// Cutter compensation.
    pub compensation: Compensation,
    /// What the program said of the tool where it switched compensation on.
    pub called: Called,
    /// Work offset, from 1.
    pub work_offset: u16,
}

impl Modal {
    pub(crate) const INITIAL: Self = Self {
        motion: Motion::None,
        plane: Plane::Xy,
        inch: false,
        diameter: false,
        radius_increments: false,
        incremental: false,
        centre_absolute: false,
        feed_mode: FeedMode::PerMinute,
        feed: -1.0,
        feed_unit: FeedUnit::OfLengths,
        spindle_mode: SpindleMode::Revolutions,
        spindle_speed: -1.0,
        spindle_limit: -1.0,
        tool: -1,
        spindle_tool: -1,
        compensation: Compensation::Off,
        called: NONE_CALLED,
        work_offset: 1,
    };

    /// The T word of the tool in use: the one in the spindle, as far as it is known; −1 before the first.
    pub fn tool_in_use(&self) -> i32 {
        if self.spindle_tool == -1 {
            self.tool
        } else {
            self.spindle_tool
        }
    }

    /// The number by which the radius of the compensation in force was called, of a tool with edges times 1000, and D; 0
    /// where the program gives it, or for none.
    pub fn radius_offset(&self) -> i32 {
        match self.called {
            Called { radius, .. } if radius >= 0.0 => 0,
            Called { number, edge: Some(edge), .. } => number.saturating_mul(1000).saturating_add(edge),
            Called { number, .. } => number,
        }
    }

    /// Millimetres in a program unit.
    pub fn mm(&self) -> f64 {
        if self.inch {
            25.4
        } else {
            1.0
        }
    }

    /// Millimetres of position in one unit of an axis word: half of `mm` for X in diameter mode.
    pub fn axis_mm(&self, axis: usize) -> f64 {
        if axis == 0 && self.diameter {
            self.mm() / 2.0
        } else {
            self.mm()
        }
    }

    /// The same of an increment.
    pub fn increment_mm(&self, axis: usize) -> f64 {
        if self.radius_increments {
            self.mm()
        } else {
            self.axis_mm(axis)
        }
    }
}
