//! The tool path: moves with their geometry and where each comes from.

use crate::drilling::hole::Drilled;
use crate::drilling::hole_places::Placed;
use crate::drilling::milled::Space;
use crate::emit::Executed;
use crate::modes::linear::Linear;
use crate::modes::modal::Modal;
use crate::reading::program::Program;

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

/// The circle of a move.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// Index of the move.
    pub of_move: usize,
    /// Centre, mm; its coordinate along the plane's third axis is the start's.
    pub centre: [f64; 3],
    /// Angle turned, positive clockwise (G02) as seen against the plane's third axis.
    pub sweep: f64,
    /// The programmed radius; NaN when the centre was programmed.
    pub radius: f64,
}

/// What the frame in force adds to program coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// Machine position minus program position: work offset, position register and tool offset together.
    pub total: [f64; 3],
    /// The part of it that G52, G92 or TRANS made.
    pub register: [f64; 3],
    /// That without G92: what makes a position of the program one of the work offset, or of the register set by G92.
    pub shift: [f64; 3],
    /// The part of it that the tool made; `None` where the program calls for an offset that is not known.
    pub tool: Option<[f64; 3]>,
    /// The number that the tool's offset in force was called by: that of T0313 (13), of H, of the tool (on a Sinumerik times
    /// 1000, and D); 0 for none, −1 where the block gave the offset itself.
    pub tool_number: i32,
    /// The tool's offset is subtracted: G44.
    pub tool_is_subtracted: bool,
    /// How often another tool, another offset of it or another work offset came into force, for each axis it is about:
    /// what the axis' position is called then, only the control knows.
    pub renamed: [u32; 3],
    /// Letter of a rotary axis that stands or moves at another angle than 0, or at one that is not known; 0 for none.
    pub turned: u8,
    /// Where A, B, C and numbered rotary axes stand, degrees: `None` where the program has not stated it yet, infinite
    /// where it went to a place that is not known.
    pub rotary: [Option<f64>; 4],
    /// The turned, mirrored or scaled coordinates in force: to the path of the work frame by [`ToolPath::placed`].
    pub linear: Option<Linear>,
    /// Coordinates have other directions, or another scale, than the machine's axes.
    pub is_turned: bool,
}

/// A turning cycle: from where the tool stands to the end that its block states, and back.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    /// Index of its first move.
    pub first: usize,
    /// One past its last move.
    pub end: usize,
    /// The words that set its end along each axis, negative where the block has none.
    pub words: [i32; 3],
    /// The end that they state, mm.
    pub to: [f64; 3],
    /// The space that it cuts by passes which the path does not have; `None` where it has them.
    pub milled: Option<Space>,
}

/// A path, in the order of cutting: a column a property, an entry a move.
///
/// Positions are program coordinates of the work frame in force, mm, X a radius; of turned, mirrored or scaled ones those
/// of their words, until they are [`placed`](Self::placed).
#[derive(Clone, Debug, Default)]
pub struct ToolPath {
    /// What each move is.
    pub kind: Vec<MoveKind>,
    /// Where it starts: the end of the move before, but for a change of frame.
    pub start: Vec<[f64; 3]>,
    /// Where it ends.
    pub end: Vec<[f64; 3]>,
    /// Index of the word that set each coordinate of the end, or `INHERITED`.
    pub words: Vec<[i32; 3]>,
    /// Index of its block.
    pub block: Vec<i32>,
    /// Index into `states` and `origins`.
    pub state: Vec<i32>,
    /// Index into `calls` of the call it is made in, −1 outside any.
    pub call: Vec<i32>,
    /// Circles of those moves that have one, in order.
    pub arcs: Vec<Arc>,
    /// Modal states, each once for a run of moves that share it and its origin.
    pub states: Vec<Modal>,
    /// The origin of each state.
    pub origins: Vec<Origin>,
    /// The blocks executed, where the run was asked to trace them.
    pub executed: Vec<Executed>,
    /// Calls of subprograms and contours, in order: the block that calls, and the call it is in itself.
    pub calls: Vec<[i32; 2]>,
    /// Holes of drilling cycles, in order.
    pub drilled: Vec<Drilled>,
    /// Moves to the places of hole patterns.
    pub placed: Vec<Placed>,
    /// Turning cycles whose moves follow from the words of one block, in order.
    pub turned: Vec<Turned>,
    /// Moves at whose ends the control mills a pocket by passes of its own, and the space of each.
    pub pockets: Vec<(usize, Space)>,
    /// Corners that are moves, and the word of their block that asks for each; negative where an earlier block did.
    pub corners: Vec<(usize, i32)>,
    /// Dwells: the move that comes next, and the time, s; NaN where the program counts revolutions.
    pub dwells: Vec<(usize, f64)>,
    /// The block that states the unit before any length, and whether it is the inch.
    pub unit_stated: Option<(usize, bool)>,
    /// The first block in which a rotary axis turns at feed, and its letter.
    pub turns_in_cut: Option<(usize, u8)>,
    /// The call under way.
    pub(crate) caller: Caller,
}

/// The call in which the next move is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caller(pub i32);

impl Default for Caller {
    fn default() -> Self {
        Self(INHERITED)
    }
}

impl ToolPath {
    /// An empty one with room for so many moves.
    pub(crate) fn with_room(moves: usize) -> Self {
        Self {
            kind: Vec::with_capacity(moves),
            start: Vec::with_capacity(moves),
            end: Vec::with_capacity(moves),
            words: Vec::with_capacity(moves),
            block: Vec::with_capacity(moves),
            state: Vec::with_capacity(moves),
            call: Vec::with_capacity(moves),
            ..Self::default()
        }
    }

    /// Number of moves.
    pub fn len(&self) -> usize {
        self.kind.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kind.is_empty()
    }

    /// Column, from 1, of the byte that [`Self::at`] gives.
    pub fn column(&self, index: usize, program: &Program) -> usize {
        let start = self.block.get(index).and_then(|block| program.blocks().get(*block as usize));
        self.at(index, program) - start.map_or(0, |found| found.start as usize) + 1
    }

    /// First byte of the first word that set a coordinate of a move; of its block's first word without one.
    pub(crate) fn at(&self, index: usize, program: &Program) -> usize {
        let block = self.block.get(index).map_or(0, |block| *block as usize);
        let start = program.blocks().get(block).map_or(0, |found| found.start);
        let own = self.words.get(index).into_iter().flatten().filter_map(|word| usize::try_from(*word).ok());
        let first = own.min().and_then(|word| program.words().get(word)).or(program.words_of(block).first());
        first.map_or(start, |word| word.start) as usize
    }

    /// Adds a move but for its circle.
    pub(crate) fn push(
        &mut self,
        kind: MoveKind,
        start: [f64; 3],
        end: [f64; 3],
        words: [i32; 3],
        block: i32,
        state: i32,
    ) {
        self.kind.push(kind);
        self.start.push(start);
        self.end.push(end);
        self.words.push(words);
        self.block.push(block);
        self.state.push(state);
        self.call.push(self.caller.0);
    }

    /// Forgets the moves from that one on.
    pub(crate) fn truncate(&mut self, moves: usize) {
        self.kind.truncate(moves);
        self.start.truncate(moves);
        self.end.truncate(moves);
        self.words.truncate(moves);
        self.block.truncate(moves);
        self.state.truncate(moves);
        self.call.truncate(moves);
        self.arcs.truncate(self.arcs.partition_point(|arc| arc.of_move < moves));
        self.drilled.truncate(self.drilled.partition_point(|hole| hole.end <= moves));
        self.placed.truncate(self.placed.partition_point(|placed| placed.of_move < moves));
        self.turned.truncate(self.turned.partition_point(|turned| turned.end <= moves));
        self.pockets.truncate(self.pockets.partition_point(|(of_move, _)| *of_move < moves));
        self.corners.truncate(self.corners.partition_point(|(of_move, _)| *of_move < moves));
    }

    /// A block calls others.
    pub(crate) fn enter_call(&mut self, block: usize) {
        self.calls.push([block as i32, self.caller.0]);
        self.caller = Caller(self.calls.len() as i32 - 1);
    }

    /// The call is over.
    pub(crate) fn leave_call(&mut self) {
        let call = usize::try_from(self.caller.0).ok().and_then(|call| self.calls.get(call));
        self.caller = Caller(call.map_or(INHERITED, |call| call[1]));
    }

    /// Index of the state, noting it when it is not the last one.
    pub(crate) fn state_index(&mut self, state: &Modal, origin: Origin) -> i32 {
        if self.states.last() != Some(state) || self.origins.last() != Some(&origin) {
            self.states.push(*state);
            self.origins.push(origin);
        }
        self.states.len() as i32 - 1
    }
}
