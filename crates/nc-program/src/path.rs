//! The tool path: moves with their geometry and where each comes from.

use crate::modal::Modal;
use crate::program::Program;

/// What a move is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum MoveKind {
    /// Positioning: not at feed.
    Rapid,
    /// A straight cut.
    Line,
    /// A circular (or helical) cut.
    Arc,
    /// A straight move that ends at a touch; the end given is the programmed one.
    Probe,
    /// A straight cut synchronised with the spindle.
    Thread,
}

/// No word of this block set the coordinate.
pub const INHERITED: i32 = -1;

/// One move. Positions are program coordinates of the work frame in force, mm, X a radius.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// What it is.
    pub kind: MoveKind,
    /// Where it starts: the end of the move before, but for a change of frame.
    pub start: [f64; 3],
    /// Where it ends.
    pub end: [f64; 3],
    /// Index of the word that set each coordinate of the end, or `INHERITED`.
    pub words: [i32; 3],
    /// Index of the block.
    pub block: u32,
    /// Index into `ToolPath::states`.
    pub state: u32,
    /// Index into `ToolPath::arcs`; −1 when it is none.
    pub arc: i32,
}

impl Move {
    /// Column, from 1, of the first word that set a coordinate; of the block's first word without one.
    pub fn column(&self, program: &Program) -> usize {
        let block = self.block as usize;
        let start = program.blocks().get(block).map_or(0, |found| found.start);
        let own = self.words.iter().filter_map(|word| program.words().get(usize::try_from(*word).ok()?));
        let first = own.map(|word| word.start).min().or(program.words_of(block).first().map(|word| word.start));
        (first.unwrap_or(start) - start) as usize + 1
    }
}

/// The circle of a move.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// Centre, mm; its coordinate along the plane's third axis is the start's.
    pub centre: [f64; 3],
    /// Angle turned, positive clockwise (G02) as seen against the plane's third axis.
    pub sweep: f64,
    /// The programmed radius; NaN when the centre was programmed.
    pub radius: f64,
}

/// A path, in the order of cutting.
#[derive(Debug, Default)]
pub struct ToolPath {
    /// The moves.
    pub moves: Vec<Move>,
    /// Circles of those moves that have one.
    pub arcs: Vec<Arc>,
    /// Modal states, each once for a run of moves that share it.
    pub states: Vec<Modal>,
}

impl ToolPath {
    /// Index of the state, noting it when it is not the last one.
    pub(crate) fn state(&mut self, state: &Modal) -> u32 {
        if self.states.last() != Some(state) {
            self.states.push(*state);
        }
        (self.states.len() - 1) as u32
    }
}
