//! Ways to the place where the position register is set (G50, G92): they end where they did, so that the coordinates
//! after it are those of the program as given, and the next part begins at the same place. The register is set in
//! coordinates that are not turned: positions and displacements here are those of the work frame.

use std::collections::{HashMap, HashSet};

use nc_program::dialect::{FlowStyle, G};
use nc_program::{finding, MoveKind, Program, ToolPath};

use crate::field::Vector;
use crate::refusal::Refused;
use crate::role::{names, Role};
use crate::standing::{is_position, leaves, Saying};

/// Positions nearer than this are one, mm.
const SAME_MM: f64 = 1e-6;

/// The register set last, and whether a cut was made since.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Register {
    /// What it called the place of the tool, mm; NaN along axes that it does not name.
    place: Option<Vector>,
    /// The axes that it names, where no move came after it yet.
    named: Option<[bool; 3]>,
    has_cut: bool,
    /// A cut was made before it.
    cut_before: bool,
}

/// Moves and blocks of a part that stay for the register's sake.
#[derive(Debug, Default)]
pub(crate) struct Ways {
    /// Indices of moves that stay as they are.
    moves: HashSet<usize>,
    /// Those with increments, by index, and the axes along which they end where they did.
    returns: HashMap<usize, [bool; 3]>,
    /// Blocks that set the register from which nothing is cut, or move to where it is set.
    blocks: HashSet<usize>,
}

impl Ways {
    /// Whether a move stays.
    pub fn has(&self, index: usize) -> bool {
        self.moves.contains(&index)
    }

    /// The axes along which a move with increments ends where it did, although it starts displaced.
    pub fn returns(&self, index: usize) -> Option<[bool; 3]> {
        self.returns.get(&index).copied()
    }

    /// Whether a block cannot be run for a parameter that matters nowhere: it says where on the machine the tool goes.
    pub fn excuses(&self, program: &Program, refused: &Refused) -> bool {
        refused.code == finding::PARAMETER && self.blocks.contains(&program.block_at(refused.at))
    }
}

/// Moves from one setting of the register to the next.
struct Section {
    first: usize,
    end: usize,
    /// The block that sets the register at its beginning, and the one at its end.
    registers: [Option<usize>; 2],
}

/// The ways of a part. `last` says that nothing comes after it.
pub(crate) fn ways(
    program: &Program,
    path: &ToolPath,
    roles: &HashMap<usize, Role>,
    known: &mut Register,
    last: bool,
) -> Ways {
    let mut ways = Ways::default();
    let is_set = known.place.is_some() || known.named.is_some();
    let registers = registers(program, roles);
    let Some(sections) = sections(program, path, &registers, is_set) else {
        let place = known.place.or_else(|| first_place(program, path, &registers));
        if let Some(place) = place.filter(|place| last && path.end.last().is_some_and(|end| is_at(end, place))) {
            let named = place.map(|at| !at.is_nan());
            keep_way(program, path, roles, &mut ways, run_in_order(path)..path.len(), (named, Some(place)));
        }
        *known = Register { place, named: None, has_cut: true, cut_before: true };
        return ways;
    };
    if sections.is_empty() {
        known.has_cut |= path.kind.iter().any(|kind| *kind != MoveKind::Rapid);
    }
    for section in sections {
        let Section { first, end, registers: [begins, ends] } = section;
        if let Some(block) = begins {
            let named = [0, 1, 2].map(|axis| names(program, block, axis));
            let cut_before = known.cut_before || known.has_cut;
            *known = Register { place: None, named: Some(named), has_cut: false, cut_before };
        }
        if let Some((named, start)) = known.named.zip(path.start.get(first)) {
            known.place = Some([0, 1, 2].map(|axis| if named[axis] { start[axis] } else { f64::NAN }));
            known.named = None;
        }
        let cuts = (first..end).any(|index| path.kind[index] != MoveKind::Rapid);
        known.has_cut |= cuts;
        let is_set = known.place.is_some() || known.named.is_some() || ends.is_some();
        if is_set && !known.has_cut && (ends.is_some() || last && known.cut_before) {
            ways.moves.extend(first..end);
            ways.blocks.extend((first..end).map(|index| path.block[index] as usize).chain(begins));
            continue;
        }
        match (ends, known.place) {
            (Some(block), place) => {
                let named = [0, 1, 2].map(|axis| names(program, block, axis));
                keep_way(program, path, roles, &mut ways, first..end, (named, place));
            }
            (None, Some(place)) if last && end > first && is_at(&path.end[end - 1], &place) => {
                keep_way(program, path, roles, &mut ways, first..end, (place.map(|at| !at.is_nan()), Some(place)));
            }
            _ => {}
        }
    }
    ways
}

/// The blocks that set the register, in order.
fn registers(program: &Program, roles: &HashMap<usize, Role>) -> Vec<usize> {
    let sets = |block: &usize| {
        program.words_of(*block).iter().any(|word| program.code(word) == Some(G::SetRegister))
            && roles.get(block) == Some(&Role::Register)
    };
    let mut registers: Vec<usize> = roles.keys().copied().filter(sets).collect();
    registers.sort_unstable();
    registers
}

/// The first of the moves at the end of a path whose blocks are the main program's and come behind all that ran before.
fn run_in_order(path: &ToolPath) -> usize {
    let mut latest: Vec<usize> = (0..path.len()).map(|index| main_block(path, index)).collect();
    (1..latest.len()).for_each(|index| latest[index] = latest[index].max(latest[index - 1]));
    let in_order = |index: &usize| {
        let before = index.checked_sub(1).map(|before| latest[before]);
        path.call[*index] < 0 && before < Some(path.block[*index] as usize)
    };
    (0..path.len()).rev().take_while(in_order).last().unwrap_or(path.len())
}

/// What the first setting of the register called the place of the tool, in a program whose blocks run in any order.
fn first_place(program: &Program, path: &ToolPath, registers: &[usize]) -> Option<Vector> {
    let block = *registers.first()?;
    let after = (0..path.len()).find(|index| main_block(path, *index) > block)?;
    Some([0, 1, 2].map(|axis| if names(program, block, axis) { path.start[after][axis] } else { f64::NAN }))
}

/// The sections of a part; `None` where blocks run in another order than they are written, so that it is not known when
/// the register is set. None are of interest where it never is; `is_set` says that it was before.
fn sections(program: &Program, path: &ToolPath, registers: &[usize], is_set: bool) -> Option<Vec<Section>> {
    if registers.is_empty() && !is_set {
        return Some(Vec::new());
    }
    let main: Vec<usize> = (0..path.len()).map(|index| main_block(path, index)).collect();
    let elsewhere = registers.last() > main.last() || program.dialect().flow == FlowStyle::OWords;
    if !main.is_sorted() || !path.calls.is_empty() && elsewhere {
        return None;
    }
    let ends = registers.iter().map(|register| main.partition_point(|block| block < register));
    let ends: Vec<usize> = ends.chain([path.len()]).collect();
    let section = |place: usize| Section {
        first: place.checked_sub(1).map_or(0, |before| ends[before]),
        end: ends[place],
        registers: [place.checked_sub(1).map(|before| registers[before]), registers.get(place).copied()],
    };
    Some((0..ends.len()).map(section).collect())
}

/// The block of the main program that makes a move, itself or by what it calls.
fn main_block(path: &ToolPath, index: usize) -> usize {
    let (mut block, mut call) = (path.block[index] as usize, path.call[index]);
    while let Some([from, outer]) = usize::try_from(call).ok().and_then(|call| path.calls.get(call)) {
        (block, call) = (*from as usize, *outer);
    }
    block
}

/// The straight moves that last take each of some axes (`open`) to where the section ends: at rapid, or at feed to the
/// place of the register itself, where nothing is cut. An axis that goes to a place of the machine is not displaced there.
fn keep_way(
    program: &Program,
    path: &ToolPath,
    roles: &HashMap<usize, Role>,
    ways: &mut Ways,
    moves: std::ops::Range<usize>,
    (mut open, place): ([bool; 3], Option<Vector>),
) {
    let mut way = Vec::new();
    for index in moves.rev() {
        let returns = place.is_some_and(|place| is_at(&path.end[index], &place));
        let straight = path.kind[index] == MoveKind::Rapid || path.kind[index] == MoveKind::Line && returns;
        // A word of turned coordinates takes more than its own axis along.
        let turned = path.origins[path.state[index] as usize].linear.is_some();
        if !straight || turned || open == [false; 3] {
            break;
        }
        let (saying, role) = (Saying::of(path, index), roles.get(&(path.block[index] as usize)));
        if role.is_some_and(Role::is_to_machine) {
            open = [0, 1, 2].map(|axis| open[axis] && !leaves(program, &saying, role, axis));
            continue;
        }
        let takes = [0, 1, 2].map(|axis| open[axis] && path.words[index][axis] >= 0);
        open = [0, 1, 2].map(|axis| open[axis] && !takes[axis]);
        way.push((index, takes));
    }
    let mut arrived = [false; 3];
    for (index, takes) in way.into_iter().rev().skip_while(|(_, takes)| *takes == [false; 3]) {
        arrived = [0, 1, 2].map(|axis| arrived[axis] || takes[axis]);
        let saying = Saying::of(path, index);
        let goes = [0, 1, 2].map(|axis| is_position(program, &saying, axis));
        if takes != [false; 3] && (0..3).all(|axis| path.words[index][axis] < 0 || goes[axis]) {
            ways.moves.insert(index);
        } else {
            ways.returns.insert(index, [0, 1, 2].map(|axis| arrived[axis] || goes[axis]));
        }
        ways.blocks.insert(path.block[index] as usize);
    }
}

/// Whether a position is a place along the axes that it names, one at least.
fn is_at(position: &Vector, place: &Vector) -> bool {
    let named = || (0..3).filter(|axis| !place[*axis].is_nan());
    named().next().is_some() && named().all(|axis| (position[axis] - place[axis]).abs() <= SAME_MM)
}

/// The register may only be set where the tool is not displaced along the axes that it names: the positions after it
/// would be, twice.
pub(crate) fn require_on_position(program: &Program, block: usize, carried: &Vector) -> Result<(), Refused> {
    let named = (0..3).filter(|axis| names(program, block, *axis));
    let off = named.map(|axis| carried[axis].abs()).fold(0.0, f64::max);
    if off <= 1e-3 {
        return Ok(());
    }
    let at = program.blocks().get(block).map_or(0, |found| found.start as usize);
    let message = format!("coordinates are set anew where the tool is {off:.5} mm off its programmed position");
    let hint = "set them at the start of the program, or after rapid moves to positions of the axes that are set";
    Err(Refused::block(at, message, hint))
}

/// A program that ends at the place of its register ends there undisplaced: the next part begins where it ends.
pub(crate) fn require_returned(
    known: &Register,
    program: &Program,
    path: &ToolPath,
    carried: &Vector,
) -> Result<(), Refused> {
    let Some((place, last)) = known.place.zip(path.len().checked_sub(1)) else { return Ok(()) };
    let named = (0..3).filter(|axis| !place[*axis].is_nan());
    let off = named.map(|axis| carried[axis].abs()).fold(0.0, f64::max);
    if off <= 1e-3 || !is_at(&path.end[last], &place) {
        return Ok(());
    }
    let at = program.blocks().get(path.block[last] as usize).map_or(0, |found| found.start as usize);
    let message = format!(
        "the program ends {off:.5} mm off the place at which it sets its coordinates: the next part would begin there"
    );
    let hint = "go back to that place by rapid moves to positions, behind all cuts of the main program";
    Err(Refused::block(at, message, hint))
}
