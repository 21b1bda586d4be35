//! What a program says of where each axis stands: a run takes an axis for 0 until it is named, the machine does not.

use nc_program::{Program, ToolPath, Word};

use crate::role::{letters, named_axes, names, names_axis, roles, Role};

/// What a move's block says of where it goes.
#[derive(Clone, Copy, Debug)]
pub struct Saying {
    /// Index of the block.
    pub block: usize,
    /// Index of the word that sets each axis, negative where none does.
    pub words: [i32; 3],
    /// Coordinates are increments.
    pub incremental: bool,
    /// How often each axis' positions were renamed before.
    pub renamed: [u32; 3],
    /// The tool's axis.
    pub third: usize,
}

impl Saying {
    pub(crate) fn of(path: &ToolPath, index: usize) -> Self {
        let state = path.state[index] as usize;
        let (incremental, renamed) = (path.states[state].incremental, path.origins[state].renamed);
        let third = path.states[state].plane.axes().2;
        Self { block: path.block[index] as usize, words: path.words[index], incremental, renamed, third }
    }
}

/// Whether X, Y and Z stand where the program said, after each move of the whole program.
pub fn said(program: &Program, moves: impl IntoIterator<Item = Saying>) -> Vec<[bool; 3]> {
    let roles = roles(program);
    let mut standing = at_start(named_axes(&letters(program), program.dialect()));
    let mut renamed = [0; 3];
    let follow = |saying: Saying| {
        standing = before(standing, &mut renamed, &saying);
        standing = after(standing, program, &saying, roles.get(&saying.block));
        standing.map(|axis| axis == Standing::Said)
    };
    moves.into_iter().map(follow).collect()
}

/// What is known of an axis before a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Standing {
    /// Nothing: no position has named it yet.
    Unsaid,
    /// It is at a place of the machine: home, or a machine position.
    Machine,
    /// Another tool, or an offset that only the control knows, came into force since a position named it.
    Renamed,
    /// It is at a position of the program.
    Said,
    /// The program never names it: the machine may not have it.
    Never,
}

impl Standing {
    /// Whether a position of the program is yet to come.
    pub fn is_unknown(self) -> bool {
        matches!(self, Self::Unsaid) || self.is_elsewhere()
    }

    /// Whether it had a position and is at a place now that no position of the program tells.
    pub fn is_elsewhere(self) -> bool {
        matches!(self, Self::Machine | Self::Renamed)
    }
}

/// Before the first block, by the axes that the program names.
pub(crate) fn at_start(named: [bool; 3]) -> [Standing; 3] {
    named.map(|named| if named { Standing::Unsaid } else { Standing::Never })
}

/// Before a move: tool and offsets in force are those of its block. `renamed` is what it was at the move before.
pub(crate) fn before(last: [Standing; 3], renamed: &mut [u32; 3], saying: &Saying) -> [Standing; 3] {
    let since = std::mem::replace(renamed, saying.renamed);
    [0, 1, 2].map(|axis| match last[axis] {
        Standing::Said if since[axis] != renamed[axis] => Standing::Renamed,
        known => known,
    })
}

/// After a move. An increment from an unknown place leads to another.
pub(crate) fn after(from: [Standing; 3], program: &Program, saying: &Saying, role: Option<&Role>) -> [Standing; 3] {
    let to_machine = role.is_some_and(Role::is_to_machine);
    [0, 1, 2].map(|axis| match from[axis] {
        Standing::Never => Standing::Never,
        Standing::Said if !to_machine => Standing::Said,
        _ if to_machine && leaves(program, saying, role, axis) => Standing::Machine,
        _ if !to_machine && is_position(program, saying, axis) => Standing::Said,
        known => known,
    })
}

/// Whether a move to a place of the machine takes that axis there.
pub(crate) fn leaves(program: &Program, saying: &Saying, role: Option<&Role>, axis: usize) -> bool {
    let block = saying.block;
    match role {
        Some(Role::Retract) => axis == saying.third,
        _ => names(program, block, axis) || !names_axis(program, block),
    }
}

/// Whether a word of the move names the axis by where it goes, not by how far.
pub(crate) fn is_position(program: &Program, saying: &Saying, axis: usize) -> bool {
    let word = program.word(saying.words[axis]);
    word.is_some() && !is_increment(program, word, saying.incremental)
}

/// Whether a word is an increment: `U`, `X=IC(5)`, `IX+5`, or any while increments are in force.
pub(crate) fn is_increment(program: &Program, word: Option<&Word>, in_force: bool) -> bool {
    word.and_then(|word| program.reference(word)).unwrap_or(in_force)
}
