//! Blocks whose coordinates are no positions of the path: found by their codes.

use std::collections::HashMap;

use nc_program::dialect::{Letters, G};
use nc_program::{calls_touch, Dialect, Motion, Program, Word, WordKind};

/// Letters of positions and increments.
const COORDINATES: Letters = Letters::of(b"XYZUVWl");

/// The letters that name X, Y and Z: U, V, W where the control reads them as increments, else they are other axes or,
/// as V of an Okuma, variables; polar ones of G16, under whose letters its X and Y are kept.
fn axis_letters(dialect: &Dialect) -> [Letters; 3] {
    let [u, v, w] = dialect.increments.unwrap_or(*b"XYZ");
    let mut letters = [Letters::of(&[b'X', u]), Letters::of(&[b'Y', v]), Letters::of(&[b'Z', w])];
    if dialect.g_code(16.0) == Some(G::Polar(true)) {
        letters[..2].iter_mut().for_each(|own| b"pq".iter().for_each(|letter| own.add(*letter)));
    }
    letters
}

/// What such a block's coordinates are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Positions of the machine: G53.
    Machine,
    /// A way home through a point: G28.
    Home,
    /// The tool's axis to the limit of its travel.
    Retract,
    /// A new name for the place where the tool stands.
    Register,
    /// Offsets, a time, places that are touched, the depth of cut and the allowance of a roughing cycle.
    Data,
    /// Those of a cycle that the path does not follow.
    Cycle,
}

impl Role {
    /// Whether the block goes to a place of the machine.
    pub fn is_to_machine(&self) -> bool {
        matches!(self, Self::Machine | Self::Home | Self::Retract)
    }
}

/// The blocks of a part that have a role, with their index.
pub(crate) fn roles(program: &Program) -> HashMap<usize, Role> {
    let mut roles = HashMap::new();
    for word in program.words() {
        let role = match program.code(word) {
            Some(G::MachineCoordinates | G::BuilderCoordinates) => Role::Machine,
            Some(G::Home(_) | G::HomeNamed(_) | G::StoreHome(_) | G::FixedPoint) => Role::Home,
            Some(G::Retract | G::Swivel) => Role::Retract,
            Some(G::SetRegister | G::SetData) => Role::Register,
            Some(
                G::OffsetRegister
                | G::SetWorkOffset
                | G::Shift(_)
                | G::ToolOffset
                | G::Dwell
                | G::Rotate
                | G::Scale
                | G::Mirror(_)
                | G::EndMirror
                | G::Pole(_)
                | G::Setting(..)
                | G::RoughContour(_)
                | G::Lap(_)
                | G::Removal(_)
                | G::DiameterByWord,
            ) => Role::Data,
            Some(G::OpaqueCycle | G::DefineCycle(None) | G::OpaqueMotion | G::CallNamed) => Role::Cycle,
            Some(G::OpaqueBlock | G::OpaqueCut) => Role::Cycle,
            Some(G::CallMacro) if calls_touch(program, program.block_at(word.start as usize)) => Role::Data,
            _ => continue,
        };
        let block = program.block_at(word.start as usize);
        let cuts_unseen =
            role == Role::Cycle && (word.kind == WordKind::Name || program.code(word) == Some(G::OpaqueCut));
        if names_axis(program, block) || matches!(role, Role::Home | Role::Retract) || cuts_unseen {
            roles.insert(block, role);
        }
    }
    roles
}

/// Whether a block returns to the reference point or the end of travel, not to another place that the control stores.
pub(crate) fn goes_to_reference(program: &Program, block: usize) -> bool {
    let returns = |word: &Word| match program.code(word) {
        Some(G::Home(0) | G::HomeNamed(0) | G::Retract | G::Swivel) => true,
        Some(G::FixedPoint) => word.value == 74.0,
        _ => false,
    };
    program.words_of(block).iter().any(returns)
}

/// Whether a block names an axis.
pub(crate) fn names_axis(program: &Program, block: usize) -> bool {
    let coordinate = |word: &Word| COORDINATES.has(word.letter) && word.kind != WordKind::Assignment;
    program.words_of(block).iter().any(coordinate)
}

/// Whether a block names that axis, by position or increment.
pub(crate) fn names(program: &Program, block: usize, axis: usize) -> bool {
    let letters = axis_letters(program.dialect())[axis];
    let own = |word: &Word| program.text(word).first().map_or(0, u8::to_ascii_uppercase) == b"XYZ"[axis];
    let named = |word: &Word| letters.has(word.letter) || word.letter == b'l' && own(word);
    program.words_of(block).iter().any(named)
}

/// The blocks in which a code first sets a work offset or a tool's data (G10), first sets the position register, first
/// goes to a place of the machine, and first makes a curve that its own words do not tell: a spline, a tangent arc.
pub fn first_blocks(program: &Program) -> [Option<usize>; 4] {
    let mut first = [None; 4];
    for word in program.words() {
        let what = match program.code(word) {
            Some(G::SetData | G::SetWorkOffset | G::Probe) => 0,
            Some(G::SetRegister) => 1,
            Some(G::MachineCoordinates | G::BuilderCoordinates | G::Home(_) | G::HomeNamed(_)) => 2,
            Some(G::Retract | G::FixedPoint | G::Swivel) => 2,
            Some(G::Motion(Motion::Spline(_) | Motion::Tangent) | G::EndSpline) => 3,
            _ => continue,
        };
        let block = program.block_at(word.start as usize);
        // The same code sets the limit of the spindle.
        if what != 1 || names_axis(program, block) {
            first[what].get_or_insert(block);
        }
    }
    first
}

/// Whether roughing cycles read contours that finishing cycles run, too.
pub(crate) fn roughs(program: &Program) -> bool {
    let roughs = |code| matches!(code, G::RoughContour(_)) || matches!(code, G::Profile(profile) if profile.roughs());
    program.words().iter().any(|word| program.code(word).is_some_and(roughs))
}

/// The letters of a program's words in alphabetical order, each with the block in which it is first met.
pub fn letters(program: &Program) -> Vec<(u8, usize)> {
    let mut first = [None; 256];
    for word in program.words() {
        first[usize::from(word.letter)].get_or_insert(word.start as usize);
    }
    (1..=255).filter_map(|letter| Some((letter, program.block_at(first[usize::from(letter)]?)))).collect()
}

/// Which of X, Y, Z a program of these letters names.
pub fn named_axes(letters: &[(u8, usize)], dialect: &Dialect) -> [bool; 3] {
    axis_letters(dialect).map(|own| letters.iter().any(|(letter, _)| own.has(*letter)))
}
