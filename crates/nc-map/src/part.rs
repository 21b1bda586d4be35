//! One part of a program: displaced, written.

use std::cell::OnceCell;
use std::collections::{HashMap, HashSet};

use nc_program::dialect::{FlowStyle, Letters};
use nc_program::{Drilled, MoveKind, Program, ToolPath};

use crate::again::{is_doubtful, Meant};
use crate::edits::{BlockNumbers, Edits};
use crate::field::{Field, Trouble, Vector, FROM_ELSEWHERE, FROM_REFERENCE};
use crate::geometry::Geometry;
use crate::milled::shared;
use crate::pieces::{pieces, Fault, Piece};
use crate::reader::Part;
use crate::refusal::{self, Refused};
use crate::register::{require_on_position, require_returned, ways, Ways};
use crate::role::{goes_to_reference, names_axis, Role};
use crate::standing::{self, is_position, leaves, Saying, Standing};
use crate::text::Step;
use crate::writer::contour::turns_back;
use crate::writer::pole::Poles;
use crate::writer::Writer;
use crate::Writing;

/// A run may be off what was meant by this, beside rounding, mm.
const SAME_MM: f64 = 1e-6;

/// What becomes of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It stays as it is: to a place of the machine, or a touch.
    Stays,
    /// Back to a place where the program has been, by no word.
    Returns,
    /// Its end is displaced.
    Displaced,
    /// A cut from a place that the program has not said: it goes straight to its displaced end.
    Arrives,
    /// Its increments take the tool from its displaced place to one without displacement along these axes.
    Undisplaced([bool; 3]),
    /// It was refused, and further obstacles are looked for.
    Refused,
}

/// A move on its way through the mapping: what becomes of it, and where the axes stand before it.
pub(crate) struct Course {
    fate: Fate,
    pub standing: [Standing; 3],
    /// Where an axis comes from whose way the path does not tell, else 0.
    from: [i8; 3],
}

impl Course {
    /// Whether the way to its end is not known.
    pub fn arrives(&self) -> bool {
        self.fate == Fate::Arrives
    }
}

impl Writing {
    /// Displaces the moves of a part and appends its blocks, but for those only looked at, to `out`.
    pub(crate) fn displace(
        &mut self,
        part: &mut Part,
        field: &mut dyn Field,
        out: &mut Vec<u8>,
    ) -> Result<(), Refused> {
        let turned = part.path.origins.iter().any(|origin| origin.linear.is_some()).then(|| part.path.clone().placed());
        let in_work = turned.as_ref().unwrap_or(&part.path);
        let ways = ways(&part.program, in_work, &part.roles, &mut self.register, part.last);
        let mut refused = std::mem::take(&mut part.refused);
        refused.retain(|one| !ways.excuses(&part.program, one));
        let unknown: HashSet<usize> = refused.iter().map(|one| part.program.block_at(one.at)).collect();
        self.refusals.keep_all(refused)?;
        let Part { program, path, roles, .. } = &*part;
        let follows = field.follows();
        self.refusals.keep(require_still_in_cuts(program, path, follows))?;
        let mut courses = self.courses(part, &ways, &unknown, follows)?;
        let stays = |index: &usize| matches!(courses[*index].fate, Fate::Stays | Fate::Refused | Fate::Undisplaced(_));
        let displaced: Vec<usize> = (0..path.len()).filter(|index| !stays(index)).collect();
        let steps = [false, true].map(|inch| Step::new(program.dialect(), inch, self.comma, self.decimals));
        let flat_mm = program.dialect().about_pole.then(|| [steps[0].unit / 2.0, 25.4 * steps[1].unit / 2.0]);
        let in_work = turned.as_ref().unwrap_or(path);
        let from: Vec<_> = courses.iter().map(|course| course.from).collect();
        let placed = Geometry::new(in_work, &mut self.travel, field.knows_travel().then_some(&from), flat_mm);
        let mut found = self.pieces(program, &placed, &displaced, field, &courses)?;
        self.check_limits(program, path, &found)?;
        let shared = shared(path, &placed, field);
        let programmed = turned.is_some().then(|| Geometry::new(path, &mut self.travel, None, flat_mm));
        if programmed.is_some() {
            found.iter_mut().for_each(|piece| piece.take_back(path));
        }
        let geometry = programmed.unwrap_or(placed);
        if self.refusals.gathers {
            refuse_without_pieces(&mut courses, &displaced, &found);
        }
        let edits = Edits::new(program.blocks().len());
        let mut writer = Writer {
            program,
            path,
            geometry: &geometry,
            edits,
            poles: Poles::new(program, path),
            steps,
            carried: self.carried,
            linear: self.linear,
            drilling: self.drilling,
            turning: self.turning,
            numbers: BlockNumbers::default(),
            heights: HashMap::new(),
            shared: Vec::new(),
            milled: HashMap::new(),
            added: 0,
            tolerance_mm: self.limits.tolerance_mm / self.linear.map_or(1.0, |linear| linear.stretch()),
            knows_travel: field.knows_travel(),
            follows,
            whole: self.whole,
            single: part.last && self.summary.blocks == 0,
            free: OnceCell::new(),
        };
        match shared {
            Ok(milled) => writer.milled = milled,
            Err(fault) => drop(self.refusals.keep(Err(told(fault, program, path)))?),
        }
        let ends = self.write(&mut writer, &courses, roles, &found)?;
        if part.last {
            self.refusals.keep(require_returned(&self.register, program, in_work, &writer.off_in_work()))?;
        }
        self.note_not_run(program, &part.moved, part.until, part.ended, roles);
        self.summary.moves += displaced.len();
        self.summary.edits += writer.edits.len();
        self.summary.added += writer.added;
        if let Some(block) = turns_back(program, &writer.shared).filter(|_| self.summary.turns_back == 0) {
            self.summary.turns_back = self.summary.blocks + block + 1;
        }
        (self.carried, self.drilling, self.turning) = (writer.carried, writer.drilling, writer.turning);
        self.linear = writer.linear;
        let stated = path.unit_stated.map(|(block, inch)| (self.summary.blocks + block + 1, inch));
        self.summary.unit_stated = self.summary.unit_stated.or(stated);
        let edits = &mut writer.edits;
        let mut written = Vec::new();
        if self.refusals.is_empty() {
            edits.apply(program.source(), part.end, &mut written);
        } else {
            self.again = None;
        }
        if let Some(again) = self.again.as_mut().filter(|_| is_doubtful(program)) {
            let rounding_mm = steps[0].unit.max(25.4 * steps[1].unit) + SAME_MM;
            let meant = Meant { program, path, ends: &ends, edits, rounding_mm };
            self.refusals.keep(again.require(&written, &meant))?;
        }
        if !self.refusals.gathers {
            out.append(&mut written);
        }
        self.summary.blocks += part.until;
        Ok(())
    }

    /// What becomes of each move. A rapid move while an axis stands at a place of the machine stays as it is: the field
    /// need not reach there. A cut needs to know where every axis stands.
    fn courses(
        &mut self,
        part: &Part,
        ways: &Ways,
        unknown: &HashSet<usize>,
        follows: Letters,
    ) -> Result<Vec<Course>, Refused> {
        let Part { program, path, roles, .. } = part;
        let mut courses = Vec::with_capacity(path.len());
        let known = |hole: &&Drilled| hole.said.is_some() || states_heights(program, hole);
        let mut holes = path.drilled.iter().filter(known).peekable();
        let mut placed = path.placed.iter().peekable();
        for index in 0..path.len() {
            let role = roles.get(&(path.block[index] as usize));
            let saying = Saying::of(path, index);
            let before = standing::before(self.standing, &mut self.renamed, &saying);
            self.standing = standing::after(before, program, &saying, role);
            if let Some(hole) = holes.peek().filter(|hole| hole.first <= index) {
                let height = &mut self.standing[hole.third];
                if hole.said.is_none() && height.is_unknown() {
                    self.begun_at = Some((hole.series, *height));
                }
                if hole.said.is_some() || height.is_unknown() {
                    *height = Standing::Said; // by the cycle
                }
                let named = |axis: usize| axis == hole.third || path.words[hole.place][axis] >= 0;
                if hole.said.is_some() && index == hole.first && !(0..3).all(named) {
                    displace_way(path, &mut courses, roles);
                }
            }
            while let Some(place) = placed.next_if(|place| place.of_move <= index) {
                place.axes.into_iter().for_each(|axis| self.standing[axis] = Standing::Said);
                // by its arguments
            }
            let mut fate = fate(path, index, role, before, self.standing);
            if fate == Fate::Displaced && path.kind[index] == MoveKind::Line && program.leads(path.block[index]) {
                fate = Fate::Arrives;
            }
            if ways.has(index) {
                fate = Fate::Stays;
            } else if let Some(axes) = ways.returns(index) {
                fate = Fate::Undisplaced(axes);
            } else if unknown.contains(&(path.block[index] as usize)) || !unknown.is_empty() && !is_finite(path, index)
            {
                fate = Fate::Refused;
            } else if fate == Fate::Arrives && approaches(program, path, index, self.standing) {
                fate = Fate::Stays;
            } else if matches!(fate, Fate::Displaced | Fate::Arrives) && path.kind[index] != MoveKind::Rapid {
                let said = require_said(program, path, index, before, self.standing);
                if !self.refusals.keep(said.and_then(|()| require_unturned(program, path, index, before, follows)))? {
                    fate = Fate::Refused;
                }
            }
            let from = self.comes_from(part, index, before);
            courses.push(Course { fate, standing: before, from });
            if let Some(hole) = holes.next_if(|hole| hole.end <= index + 1).filter(|hole| !hole.ends_at_plane) {
                // back to where the series began, which no position of the program states
                if let Some((_, height)) =
                    self.begun_at.filter(|(series, _)| *series == hole.series && hole.said.is_none())
                {
                    self.standing[hole.third] = height;
                }
            }
        }
        Ok(courses)
    }

    /// Where the axes come from whose way the path does not tell: it takes them for 0 at the start, and every reference point
    /// for the machine's zero. Turned coordinates mix them.
    fn comes_from(&mut self, part: &Part, index: usize, before: [Standing; 3]) -> [i8; 3] {
        let Part { program, path, roles, .. } = part;
        let (block, saying) = (path.block[index] as usize, Saying::of(path, index));
        if let Some(role) = roles.get(&block).filter(|role| role.is_to_machine()) {
            let from = match role {
                Role::Machine => 0,
                _ if goes_to_reference(program, block) => FROM_REFERENCE,
                _ => FROM_ELSEWHERE,
            };
            (0..3).filter(|axis| leaves(program, &saying, Some(role), *axis)).for_each(|axis| self.left[axis] = from);
            return [0; 3];
        }
        let from = [0, 1, 2].map(|axis| match before[axis] {
            Standing::Unsaid | Standing::Machine if is_position(program, &saying, axis) => self.left[axis],
            _ => 0,
        });
        match path.origins[path.state[index] as usize].linear {
            Some(_) => [from.into_iter().max().unwrap_or(0); 3],
            None => from,
        }
    }

    /// Writes all moves. Gives where each is to end in the written program, `None` within a
    /// cycle, and back by no word.
    fn write(
        &mut self,
        writer: &mut Writer,
        courses: &[Course],
        roles: &HashMap<usize, Role>,
        pieces: &[Piece],
    ) -> Result<Vec<Option<Vector>>, Refused> {
        let (path, program) = (writer.path, writer.program);
        let mut ends = Vec::with_capacity(courses.len());
        let (mut rest, mut holes) = (pieces, path.drilled.iter().peekable());
        let (mut placed, mut turned) = (path.placed.iter().peekable(), path.turned.iter().peekable());
        let mut registers: Vec<usize> =
            roles.iter().filter(|(_, role)| **role == Role::Register).map(|(block, _)| *block).collect();
        registers.sort_unstable();
        let mut registers = registers.into_iter().peekable();
        for (index, course) in courses.iter().enumerate() {
            while let Some(register) = registers.next_if(|block| *block <= path.block[index] as usize) {
                self.refusals.keep(require_on_position(program, register, &writer.off_in_work()))?;
            }
            writer.turn_with(index);
            if let Some(hole) = holes.peek().filter(|hole| hole.first <= index) {
                let ends_here = index + 1 == hole.end;
                if ends_here {
                    let (here, after) = rest.split_at(rest.partition_point(|piece| piece.of_move <= index));
                    rest = after;
                    let refused = courses[hole.first..hole.end].iter().any(|course| course.fate == Fate::Refused);
                    let drilled = match &hole.said {
                        _ if refused => Ok(()),
                        Some(said) if hole.milled.is_some() => {
                            require_unturned(program, path, hole.first, courses[hole.first].standing, writer.follows)
                                .and_then(|()| writer.mill_called(hole, said, courses))
                        }
                        Some(said) => writer.drill_called(hole, said, here, courses),
                        None => writer.drill(hole, here, courses),
                    };
                    if !self.refusals.keep(drilled)? {
                        arrive(writer, index, here);
                    }
                    holes.next();
                }
                ends.push(ends_here.then(|| writer.actual(index)));
                continue;
            }
            if let Some(cycle) = turned.peek().filter(|cycle| cycle.first <= index) {
                let ends_here = index + 1 == cycle.end;
                if ends_here {
                    let (here, after) = rest.split_at(rest.partition_point(|piece| piece.of_move <= index));
                    rest = after;
                    let refused = courses[cycle.first..cycle.end].iter().any(|course| course.fate == Fate::Refused);
                    let standing = courses[cycle.first].standing;
                    let unturned = || require_unturned(program, path, cycle.first, standing, writer.follows);
                    let written = match cycle.milled {
                        _ if refused => Ok(()),
                        Some(_) => unturned().and_then(|()| writer.turn_cycle(cycle, here, courses)),
                        None => writer.turn_cycle(cycle, here, courses),
                    };
                    if !self.refusals.keep(written)? {
                        arrive(writer, index, here);
                    }
                    turned.next();
                }
                ends.push(ends_here.then(|| writer.actual(index)));
                continue;
            }
            let own = rest.iter().take_while(|piece| piece.of_move == index).count();
            let (here, after) = rest.split_at(own);
            rest = after;
            let pattern = placed.next_if(|place| place.of_move == index);
            let written = match course.fate {
                Fate::Displaced | Fate::Arrives | Fate::Returns if pattern.is_some() => {
                    pattern.map_or(Ok(()), |place| writer.place_of_pattern(place, here))
                }
                Fate::Displaced | Fate::Arrives => writer.write(index, here, course),
                Fate::Returns => {
                    arrive(writer, index, here);
                    Ok(())
                }
                Fate::Stays if path.kind[index] == MoveKind::Arc => Err(writer.arc_in_machine(index)),
                Fate::Stays => {
                    stay(writer, index, roles.get(&(path.block[index] as usize)));
                    Ok(())
                }
                Fate::Undisplaced(axes) => writer.write(index, &[undisplaced(writer, index, axes)], course),
                Fate::Refused => Ok(()),
            };
            if !self.refusals.keep(written)? {
                arrive(writer, index, here);
            }
            ends.push((course.fate != Fate::Returns).then(|| writer.actual(index)));
        }
        registers.try_for_each(|register| {
            self.refusals.keep(require_on_position(program, register, &writer.off_in_work())).map(drop)
        })?;
        Ok(ends)
    }

    /// Refuses displacements that are too large, then those that change too much over a cut, wherever it was looked at.
    fn check_limits(&mut self, program: &Program, path: &ToolPath, pieces: &[Piece]) -> Result<(), Refused> {
        let refused = |piece: &Piece, code, said: &str, hint| {
            let block = path.block[piece.of_move] as usize;
            let at = program.blocks().get(block).map_or(0, |block| block.start as usize);
            Refused::new(code, at, said.replace("{}", &position(&path.end[piece.of_move])), hint)
        };
        for piece in pieces {
            let size = piece.largest.iter().fold(0.0, |most: f64, value| most.max(*value));
            if piece.end.iter().any(|value| !value.is_finite()) {
                let said = "the field has no displacement at {}";
                self.refusals.keep(Err(refused(piece, refusal::FIELD, said, "look at the field there")))?;
                continue;
            }
            if size > self.limits.size_mm {
                let limit = self.limits.size_mm;
                let own = pieces.iter().filter(|other| other.of_move == piece.of_move).flat_map(|other| other.largest);
                let size = own.fold(size, f64::max);
                let said = format!("the displacement reaches {size:.4} mm on the way to {{}}; the limit is {limit} mm");
                let hint = "check the field's unit and sign first";
                self.refusals.keep(Err(refused(piece, refusal::SIZE, &said, hint)))?;
            }
            let largest = &mut self.summary.largest_mm;
            *largest = [0, 1, 2].map(|axis| largest[axis].max(piece.largest[axis]));
        }
        for piece in pieces.iter().filter(|piece| piece.slope > self.limits.slope) {
            let (slope, limit) = (1e3 * piece.slope, 1e3 * self.limits.slope);
            let said =
                format!("the displacement changes by {slope:.1} µm/mm on the way to {{}}; the limit is {limit} µm/mm");
            self.refusals.keep(Err(refused(piece, refusal::SLOPE, &said, "look for an outlier in the field there")))?;
        }
        Ok(())
    }

    /// The pieces of the moves of those indices. Where all obstacles are gathered, the moves that have none are found by
    /// halving.
    fn pieces(
        &mut self,
        program: &Program,
        geometry: &Geometry,
        moves: &[usize],
        field: &mut dyn Field,
        courses: &[Course],
    ) -> Result<Vec<Piece>, Refused> {
        let fault = match pieces(geometry, moves, field, self.limits.tolerance_mm, |index| courses[index].arrives()) {
            Ok(found) => return Ok(found),
            Err(fault) => fault,
        };
        if !self.refusals.gathers || moves.len() < 2 {
            self.refusals.keep(Err(told(fault, program, geometry.path)))?;
            return Ok(Vec::new());
        }
        let (first, rest) = moves.split_at(moves.len() / 2);
        let mut found = self.pieces(program, geometry, first, field, courses)?;
        found.extend(self.pieces(program, geometry, rest, field, courses)?);
        Ok(found)
    }

    /// Counts blocks with coordinates that stay as they are because they were not run: skipped, after the end, in a
    /// branch not taken.
    fn note_not_run(
        &mut self,
        program: &Program,
        moved: &[bool],
        until: usize,
        ended: bool,
        roles: &HashMap<usize, Role>,
    ) {
        let ended_after = ended.then(|| moved.iter().rposition(|moved| *moved));
        for (block, moved) in moved.iter().enumerate().take(until) {
            let optional = program.blocks().get(block).is_some_and(|found| found.optional);
            let after_end = ended_after.is_some_and(|last| last < Some(block));
            let left_out = !moved && (optional || after_end || self.whole);
            if left_out && names_axis(program, block) && !roles.contains_key(&block) {
                self.summary.not_run += 1;
                if self.summary.not_run == 1 {
                    self.summary.first_not_run = self.summary.blocks + block + 1;
                }
            }
        }
    }
}

/// Whether the block of a cycle states the height to which the tool goes before it drills, wherever it stood before.
/// LinuxCNC's way there depends on where the series began.
fn states_heights(program: &Program, hole: &Drilled) -> bool {
    hole.said.is_none() && !hole.plane_from_initial && program.dialect().flow != FlowStyle::OWords
}

/// What becomes of a move, by where its axes stand before it and after.
fn fate(path: &ToolPath, index: usize, role: Option<&Role>, before: [Standing; 3], after: [Standing; 3]) -> Fate {
    if role.is_some_and(Role::is_to_machine) {
        return Fate::Stays;
    }
    let wordless = path.words[index].iter().all(|word| *word < 0);
    match path.kind[index] {
        MoveKind::Probe => Fate::Stays,
        MoveKind::Rapid if after.iter().any(|axis| axis.is_elsewhere()) => Fate::Stays,
        MoveKind::Rapid if wordless => Fate::Returns,
        MoveKind::Line | MoveKind::Thread if before.iter().any(|axis| axis.is_unknown()) => Fate::Arrives,
        _ => Fate::Displaced,
    }
}

/// Whether the tool goes along its axis alone, at feed, before the program first says where it is across: the next other
/// move says it, so that nothing is cut there, and displaces the tool's axis, too.
fn approaches(program: &Program, path: &ToolPath, index: usize, after: [Standing; 3]) -> bool {
    let third = Saying::of(path, index).third;
    let across = |axis: &usize| *axis != third && after[*axis] != Standing::Never;
    let is_along = |index: usize| {
        let words = path.words[index];
        path.kind[index] == MoveKind::Line && (0..3).all(|axis| (words[axis] >= 0) == (axis == third))
    };
    let next = (index..path.len()).find(|index| !is_along(*index));
    let says = |index: usize| {
        let saying = Saying::of(path, index);
        (0..3).filter(across).all(|axis| is_position(program, &saying, axis))
    };
    (0..3).filter(across).all(|axis| after[axis] == Standing::Unsaid) && is_along(index) && next.is_some_and(says)
}

/// A cut ends at a position of the program along every axis, and an arc starts at one too.
pub(crate) fn require_said(
    program: &Program,
    path: &ToolPath,
    index: usize,
    before: [Standing; 3],
    after: [Standing; 3],
) -> Result<(), Refused> {
    let needed = if path.kind[index] == MoveKind::Arc { before } else { after };
    let Some(axis) = (0..3).find(|axis| needed[*axis].is_unknown()) else { return Ok(()) };
    let letter = ["X", "Y", "Z"][axis];
    let why = match needed[axis] {
        Standing::Machine => "stands at a place of the machine",
        Standing::Renamed => "has no position since tool or offset changed",
        _ => "has no position yet",
    };
    let at = program.blocks().get(path.block[index] as usize).map_or(0, |block| block.start as usize);
    let end = position(&path.end[index]);
    let message = format!("{letter} {why} in the cut to {end}: how far it is displaced there is not known");
    Err(Refused::block(
        at,
        message,
        "name X, Y and Z by absolute positions before the first cut, and after each way home and change of tool or offset",
    ))
}

/// A displacement along X, Y and Z does not describe a part that a rotary axis has turned, unless the field follows it. C of
/// a lathe turns it about the axis from which X is counted: along the radius and Z the tool goes the same way at every
/// angle, where nothing names Y.
fn require_unturned(
    program: &Program,
    path: &ToolPath,
    index: usize,
    standing: [Standing; 3],
    follows: Letters,
) -> Result<(), Refused> {
    let state = path.state[index] as usize;
    let origin = &path.origins[state];
    let away = |angle: Option<f64>| angle.is_none_or(|degrees| degrees % 360.0 != 0.0); // true of infinity
    let others = b"ABCo".iter().zip(origin.rotary).filter(|(letter, _)| !follows.has(**letter));
    let of_others = others.filter(|(_, angle)| away(*angle)).map(|(letter, _)| *letter).next();
    let letter = if follows.has(origin.turned) { of_others.unwrap_or(0) } else { origin.turned };
    let beside = b"ABo".iter().zip([0, 1, 3]).find(|(of, index)| !follows.has(**of) && away(origin.rotary[*index]));
    let letter = beside.filter(|_| letter == b'C').map_or(letter, |(of, _)| *of);
    let about_axis = letter == b'C' && path.states[state].diameter && standing[1] == Standing::Never;
    if letter == 0 || about_axis {
        return Ok(());
    }
    let axis = if letter == b'o' { "a rotary axis".to_owned() } else { char::from(letter).to_string() };
    let block = path.block[index] as usize;
    let at = program.blocks().get(block).map_or(0, |block| block.start as usize);
    let end = position(&path.end[index]);
    let message = format!(
        "{axis} does not stand at 0 degrees, or is not known to, in the cut to {end}: the displacement is not turned with it"
    );
    let hint =
        "displace what is cut with rotary axes at 0, said by a position before the first cut, in a program of its own";
    Err(Refused::block(at, message, hint))
}

/// Refuses a rotary axis that turns in a cut: linear words alone do not follow the work then.
fn require_still_in_cuts(program: &Program, path: &ToolPath, follows: Letters) -> Result<(), Refused> {
    let Some((block, letter)) = path.turns_in_cut.filter(|_| !follows.is_empty()) else {
        return Ok(());
    };
    let at = program.blocks().get(block).map_or(0, |found| found.start as usize);
    let axis = if letter == b'o' { "a rotary axis".to_owned() } else { char::from(letter).to_string() };
    let message = format!("{axis} turns at feed: the work turns under the tool, which X, Y and Z do not follow");
    let hint = "position rotary axes at rapid, in blocks of their own, and cut while they stand";
    Err(Refused::block(at, message, hint))
}

/// Refuses the moves that have no pieces, or some that are not known.
fn refuse_without_pieces(courses: &mut [Course], displaced: &[usize], pieces: &[Piece]) {
    let known = |piece: &&Piece| piece.end.iter().all(|value| value.is_finite());
    let with: HashSet<usize> = pieces.iter().filter(known).map(|piece| piece.of_move).collect();
    for index in displaced.iter().filter(|index| !with.contains(index)) {
        courses[*index].fate = Fate::Refused;
    }
}

/// Whether a move goes to a place that is known.
fn is_finite(path: &ToolPath, index: usize) -> bool {
    path.end[index].iter().all(|value| value.is_finite())
}

/// The way at rapid to the first hole of a cycle that itself says its height: displaced although the tool's axis stands at
/// no position of the program yet.
fn displace_way(path: &ToolPath, courses: &mut [Course], roles: &HashMap<usize, Role>) {
    let stays = |index: usize, course: &Course| {
        let block = path.block[index] as usize;
        let named = path.words[index].iter().any(|word| *word >= 0);
        course.fate == Fate::Stays && path.kind[index] == MoveKind::Rapid && named && !roles.contains_key(&block)
    };
    let way = courses.iter_mut().enumerate().rev().take_while(|(index, course)| stays(*index, course));
    way.for_each(|(_, course)| course.fate = Fate::Displaced);
}

/// A straight move that ends without displacement along some axes, and as far off as it starts along the others.
fn undisplaced(writer: &Writer, index: usize, axes: [bool; 3]) -> Piece {
    let (from, to, carried) = (writer.path.start[index], writer.path.end[index], writer.carried);
    let end = [0, 1, 2].map(|axis| if axes[axis] { to[axis] } else { to[axis] + carried[axis] });
    let start = [0, 1, 2].map(|axis| from[axis] + carried[axis]);
    Piece { of_move: index, share: 1.0, start, end, centre: None, largest: [0.0; 3], slope: 0.0 }
}

/// The tool is where the last piece ends.
fn arrive(writer: &mut Writer, index: usize, pieces: &[Piece]) {
    let end = writer.path.end[index];
    let displaced = pieces.last().map_or(end, |piece| piece.end);
    writer.carried = [0, 1, 2].map(|axis| displaced[axis] - end[axis]);
}

/// A move that stays: the axes it takes to a place of the machine, or to a position, are there without displacement.
fn stay(writer: &mut Writer, index: usize, role: Option<&Role>) {
    let (path, saying) = (writer.path, Saying::of(writer.path, index));
    // The machine's axes are not turned with the program's.
    let linear = writer.linear.filter(|_| role.is_some_and(Role::is_to_machine));
    let mut carried = linear.map_or(writer.carried, |linear| linear.vector(writer.carried));
    let wordless = path.words[index].iter().all(|word| *word < 0);
    for (axis, off) in carried.iter_mut().enumerate() {
        let goes = is_position(writer.program, &saying, axis);
        if goes || wordless && leaves(writer.program, &saying, role, axis) {
            *off = 0.0;
        }
    }
    writer.carried = linear.map_or(carried, |linear| linear.inverse().vector(carried));
}

/// A fault by what it means for the program.
fn told(fault: Fault, program: &Program, path: &ToolPath) -> Refused {
    let block = |index: usize| path.block.get(index).and_then(|block| program.blocks().get(*block as usize));
    let at = |index: usize| block(index).map_or(0, |block| block.start as usize);
    match fault {
        Fault::Field(Trouble::Outside(point), owners) => {
            let index = owners.get(point).copied().unwrap_or(0);
            let (start, end) = (position(&path.start[index]), position(&path.end[index]));
            let message = format!("the field is not known on the whole way from {start} to {end}");
            let hint = "extend the table: there is no extrapolation";
            Refused::new(refusal::FIELD, at(index), message, hint)
        }
        Fault::Field(Trouble::Failed(cause), owners) => {
            let message = format!("the field failed: {cause}");
            let at = at(owners.first().copied().unwrap_or(0));
            Refused { cause: Some(cause), ..Refused::new(refusal::FIELD, at, message, "mend the field") }
        }
        Fault::Jump(index) => {
            let message = "the move would need more than 4096 pieces to follow the field".to_owned();
            Refused::block(at(index), message, "the field jumps along it, or the tolerance is too small")
        }
        Fault::Turns(index) => {
            let message = "an arc of more than 1 turn would have to become several".to_owned();
            Refused::block(at(index), message, "write it turn by turn")
        }
    }
}

fn position(point: &Vector) -> String {
    format!("X {:.3} Y {:.3} Z {:.3} mm", point[0], point[1], point[2])
}
