//! A hole of a drilling cycle: what stays in force from one to the next, and what a path tells of each.

use crate::drilling::drill::Drill;
use crate::drilling::milled::Space;

/// Values that stay from hole to hole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    pub drill: Drill,
    /// The axis drilled along, where it is not the third of the plane.
    pub along: Option<usize>,
    /// It was noted that how far its pecks go back is not known.
    pub noted: bool,
    /// P of it is a dwell.
    pub dwells: bool,
    /// Numbers the series of holes that begin at one height.
    pub series: u32,
    /// Heights of Z and R, mm; of LinuxCNC their words. NaN where not given yet.
    pub bottom: f64,
    pub plane: f64,
    pub peck: f64,
    /// Dwell at the bottom, s; NaN where none is given.
    pub dwell: f64,
    /// Height at which the series of holes began.
    pub initial: f64,
}

impl Hole {
    /// Without any value yet; `dwells` where its P is a dwell.
    pub const fn new(drill: Drill, along: Option<usize>, dwells: bool, initial: f64, series: u32) -> Self {
        const NOT_GIVEN: f64 = f64::NAN;
        let (bottom, plane, peck, dwell) = (NOT_GIVEN, NOT_GIVEN, NOT_GIVEN, NOT_GIVEN);
        Self { drill, along, noted: false, dwells, series, bottom, plane, peck, dwell, initial }
    }
}

/// A hole of a path: which moves made it, and what its block says of it.
#[derive(Clone, Copy, Debug)]
pub struct Drilled {
    /// Index of its first move.
    pub first: usize,
    /// Index of the move to its place.
    pub place: usize,
    /// Index of the move that ends at its bottom.
    pub bottom: usize,
    /// One past its last move.
    pub end: usize,
    /// The axis drilled along.
    pub third: usize,
    /// Index of the word R, negative where the block has none.
    pub plane_word: i32,
    /// Index of the word of the depth.
    pub depth_word: i32,
    /// Height of the plane R, mm.
    pub plane: f64,
    /// Height at which its series began, mm.
    pub initial: f64,
    /// An R of its block counts, or would, from the height at which the series began.
    pub plane_from_initial: bool,
    /// The tool ends at the plane R; else at the height at which the series began, where that is higher.
    pub ends_at_plane: bool,
    /// The series.
    pub series: u32,
    /// How many holes its block has drilled before it.
    pub repeat: usize,
    /// Where the heights of a cycle are written that is called; `None` where its own block states them.
    pub said: Option<Said>,
    /// The space that a cycle mills by passes which the path does not have; `None` of a hole.
    pub milled: Option<Space>,
}

/// The bytes, from one to before another, of the height values of a cycle that is called: those that go
/// with the plane R, and those that go with the depth; of what is not said none.
#[derive(Clone, Copy, Debug)]
pub struct Said {
    /// Planes.
    pub plane: [(u32, u32); 2],
    /// Depths.
    pub depth: [(u32, u32); 2],
    /// The heights count from where the tool stands, and none is written.
    relative: bool,
}

impl Said {
    pub(crate) const RELATIVE: Self = Self { plane: [(0, 0); 2], depth: [(0, 0); 2], relative: true };

    pub(crate) fn at(plane: [(u32, u32); 2], depth: [(u32, u32); 2]) -> Self {
        Self { plane, depth, relative: false }
    }

    /// Whether the heights count from where the tool stands.
    pub fn is_relative(&self) -> bool {
        self.relative
    }

    /// The bytes of the heights that are written.
    pub fn spans(&self) -> impl Iterator<Item = (u32, u32)> {
        self.plane.into_iter().chain(self.depth).filter(|(start, end)| end > start)
    }
}
