//! Holes at places that a cycle or a call names itself: HOLES1, HOLES2, CYCL DEF 220 and 221, CYCL CALL POS.

use std::f64::consts::TAU;

use crate::drilling::cycle_arguments::numbers;
use crate::finding::Unseen;
use crate::modes::modal::Motion;
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::reading::program::WordKind;
use crate::run::{Runner, AXES};
use crate::values::parameters::Key;

/// More places of a pattern than this are a slip.
pub(crate) const MOST: f64 = 10_000.0;

/// The bytes of two coordinates, from one to before another.
pub(crate) type Spans = [(u32, u32); 2];

/// How a pattern's places lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// On a line: HOLES1 (SPCA, SPCO, STA1, FDIS, DBH, NUM).
    Row,
    /// On a circle: HOLES2 (CPA, CPO, RAD, STA1, INDA, NUM).
    Circle,
    /// On lines, to and fro: CYCLE801 (SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2).
    Grid,
    /// On a circle, by the Q parameters behind CYCL DEF 220.
    DefinedCircle,
    /// On lines, to and fro, by the Q parameters behind CYCL DEF 221.
    DefinedLines,
}

/// Places by the parameters of a pattern, program units.
type Places = fn(&Parameters) -> Result<Vec<[f64; 2]>, String>;

/// The Q parameters of a pattern, and where the coordinates of its reference point are written.
struct Parameters {
    values: Vec<(u32, f64, (u32, u32))>,
}

impl Parameters {
    fn find(&self, number: u32) -> Option<&(u32, f64, (u32, u32))> {
        self.values.iter().rev().find(|(known, ..)| *known == number)
    }

    fn get(&self, number: u32) -> Result<f64, String> {
        let value = self.find(number).map(|(_, value, _)| *value).filter(|value| value.is_finite());
        value.ok_or_else(|| format!("Q{number} is not given"))
    }

    fn count(&self, number: u32) -> Result<usize, String> {
        let count = self.get(number)?;
        let fits = count.fract() == 0.0 && (1.0..=MOST).contains(&count);
        if fits {
            Ok(count as usize)
        } else {
            Err(format!("Q{number} is {count}"))
        }
    }

    fn span(&self, number: u32) -> (u32, u32) {
        self.find(number).map_or((0, 0), |(.., span)| *span)
    }
}

/// A move to a place of a pattern, and where the coordinates are written from which its places count.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Index of the move.
    pub of_move: usize,
    /// The axes of the plane.
    pub axes: [usize; 2],
    /// Where the reference point's coordinates stand.
    pub said: Spans,
}

impl Runner<'_> {
    /// Goes to the places of a pattern at rapid, and drills at each.
    pub(crate) fn pattern(&mut self, pattern: Pattern, word: i32) {
        let done = match pattern {
            Pattern::Row | Pattern::Circle | Pattern::Grid => self.holes_of_call(pattern, word),
            Pattern::DefinedCircle => self.defined_holes(circle, [216, 217]),
            Pattern::DefinedLines => self.defined_holes(lines, [225, 226]),
        };
        if let Err(why) = done {
            self.not_followed(word, &why);
        }
    }

    /// HOLES1, HOLES2: what MCALL has put in force, at each place.
    fn holes_of_call(&mut self, pattern: Pattern, word: i32) -> Result<(), String> {
        let (places, said) = self.places(pattern, word)?;
        for place in places {
            self.go_to_place(place, said);
            if let Some(hole) = self.state.modal_cycle {
                self.drill_here(&hole);
            }
        }
        Ok(())
    }

    /// At rapid to a place of the plane, mm.
    pub(crate) fn go_to_place(&mut self, place: [f64; 2], said: Spans) {
        let (first, second, _) = self.state.modal.plane.axes();
        let mut end = self.state.position;
        (end[first], end[second]) = (place[0], place[1]);
        self.path.placed.push(Placed { of_move: self.path.len(), axes: [first, second], said });
        self.emit(MoveKind::Rapid, end, [INHERITED; 3]);
    }

    /// CYCL DEF 220, 221: goes to each place, above the workpiece, and runs the cycle defined last there, with Q200, Q203
    /// and Q204 of the pattern. `places` are in program units; `reference` numbers the coordinates from which they count.
    fn defined_holes(&mut self, places: Places, reference: [u32; 2]) -> Result<(), String> {
        let q = self.parameters_behind();
        let places = places(&q)?;
        for number in [200, 203, 204] {
            let value = q.get(number)?;
            self.state.store.set(Key::Number(number), value);
        }
        self.state.defined.tell(203, q.span(203));
        let high = match q.get(301)? {
            0.0 => false,
            1.0 => true,
            other => return Err(format!("Q301 is {other}")),
        };
        let Some((number, drill)) = self.state.defined.cycle else {
            return Err("the moves of the cycle defined last are not in the path".to_owned());
        };
        let hole = self.defined_hole(number, drill)?;
        if hole.is_relative() || hole.centre().is_some() {
            return Err("the cycle defined last begins where the tool stands, or at a centre of its own".to_owned());
        }
        let (mm, third) = (self.state.modal.mm(), self.state.modal.plane.axes().2);
        if self.state.position[third] < hole.retract() {
            self.height(MoveKind::Rapid, self.state.position, third, hole.retract(), INHERITED);
        }
        let between = if high { hole } else { hole.ending_at_plane() };
        for (index, place) in places.iter().enumerate() {
            self.go_to_place(place.map(|coordinate| coordinate * mm), reference.map(|number| q.span(number)));
            self.drill_here(if index + 1 < places.len() { &between } else { &hole });
        }
        Ok(())
    }

    /// The Q parameters of the block and of the lines below it that continue it.
    fn parameters_behind(&mut self) -> Parameters {
        let (program, mut values) = (self.program, Vec::new());
        for block in self.block..program.blocks().len() {
            let text = program.blocks().get(block).and_then(|b| program.source().get(b.start as usize..b.end as usize));
            if block > self.block && text.is_none_or(|text| text.trim_ascii_start().first() != Some(&b'Q')) {
                break;
            }
            for word in program.words_of(block).iter().filter(|word| word.kind == WordKind::Assignment) {
                let span = (program.value_start(word), word.end());
                let key = if word.value.is_nan() { self.key(word.start as usize) } else { Key::numbered(word.value) };
                if let Some(Key::Number(number)) = &key {
                    let value = self.given_value(key.as_ref(), span.0, span.1);
                    values.push((*number, value, (span.0 as u32, span.1 as u32)));
                }
            }
        }
        Parameters { values }
    }

    /// The places in their order, mm, and where the reference point is written.
    fn places(&mut self, pattern: Pattern, word: i32) -> Result<(Vec<[f64; 2]>, Spans), String> {
        let arguments = self.cycle_arguments(word).ok_or("its arguments cannot be read")?;
        let more = |index: usize| {
            let further = arguments.get(index..).unwrap_or(&[]);
            further
                .iter()
                .any(|one| one.value != 0.0 && !one.value.is_nan() || one.text.as_ref().is_some_and(|t| !t.is_empty()))
        };
        if more(if pattern == Pattern::Grid { 7 } else { 6 }) {
            return Err("its arguments behind the number of holes are not followed".to_owned());
        }
        let [Some(x), Some(y), third, fourth, fifth, Some(count), rows] = numbers::<7>(&arguments) else {
            return Err("its reference point or the number of its holes is not given".to_owned());
        };
        let Some(rows) = rows.or((pattern != Pattern::Grid).then_some(1.0)) else {
            return Err("the number of its lines is not given".to_owned());
        };
        if [count, rows].iter().any(|count| count.fract() != 0.0 || *count < 1.0) || count * rows > MOST {
            return Err(format!("it has {count} x {rows} holes"));
        }
        let (count, rows) = (count as usize, rows as usize);
        let (first, second, _) = self.state.modal.plane.axes();
        let mm = self.state.modal.mm();
        if [first, second].iter().any(|axis| self.state.modal.axis_mm(*axis) != mm) {
            return Err("an axis of its plane counts diameters".to_owned());
        }
        let place = |distance: f64, angle_deg: f64| around([x, y], distance, angle_deg).map(|at| at * mm);
        let [third, fourth, fifth] = [third, fourth, fifth].map(|value| value.unwrap_or(0.0));
        let mut places: Vec<[f64; 2]> = match pattern {
            Pattern::Row => (0..count).map(|index| place(fourth + index as f64 * fifth, third)).collect(),
            Pattern::Grid => {
                let at = |(row, column)| to_and_fro([x, y], third, [fourth, fifth], [row, column], count);
                (0..rows * count).map(|index| at((index / count, index % count)).map(|at| at * mm)).collect()
            }
            _ => {
                let step = if fifth == 0.0 { TAU.to_degrees() / count as f64 } else { fifth };
                (0..count).map(|index| place(third, fourth + index as f64 * step)).collect()
            }
        };
        let here = [self.state.position[first], self.state.position[second]];
        let away = |at: Option<&[f64; 2]>| at.map_or(0.0, |at| (at[0] - here[0]).hypot(at[1] - here[1]));
        if pattern == Pattern::Row && away(places.last()) < away(places.first()) {
            places.reverse(); // a row begins at its nearer end
        }
        let span = |index: usize| arguments.get(index).map_or((0, 0), |argument| argument.span);
        Ok((places, [span(0), span(1)]))
    }

    /// CYCL CALL POS: goes to a place of the plane and runs the cycle defined last there, its surface higher by the
    /// coordinate along the tool. F counts for the way there alone.
    pub(crate) fn call_at(&mut self, request: &Request, word: i32) {
        let third = self.state.modal.plane.axes().2;
        let letter = AXES[third];
        let Some((number, drill)) = self.state.defined.cycle else {
            return self.warn_unseen(word, Unseen::Moves, "the moves of the cycle defined last are not in the path");
        };
        if !AXES.iter().all(|letter| request.get(*letter).is_some()) || request.reference(letter) == Some(true) {
            return self.not_followed(word, "X, Y and Z are not all given, that along the tool as a position");
        }
        let mut hole = match self.hole_at_places(number, drill) {
            Ok(hole) => hole,
            Err(why) => return self.not_followed(word, &why),
        };
        let (target, mut words) = self.target(request, false);
        words[third] = INHERITED;
        let value = self.program.words().get(request.word(letter) as usize);
        let span = value.map_or((0, 0), |word| (self.program.value_start(word) as u32, word.end() as u32));
        hole.raise(target[third], span);
        let kind = if self.state.modal.motion == Motion::Rapid { MoveKind::Rapid } else { MoveKind::Line };
        let before = self.state.modal.feed;
        if let Some(feed) = request.get(b'F') {
            self.state.modal.feed = self.feed_mm(request, feed);
        }
        if self.state.position[third] < hole.surface() {
            self.height(kind, self.state.position, third, hole.retract(), INHERITED);
        }
        let mut end = target;
        end[third] = self.state.position[third];
        self.emit(kind, end, words);
        self.state.modal.feed = before;
        self.drill_here(&hole);
    }
}

/// Places of CYCL DEF 220, program units. A step of 0 divides the way from the first angle to the last, and a whole circle
/// by the number of holes.
fn circle(q: &Parameters) -> Result<Vec<[f64; 2]>, String> {
    if q.find(365).is_some_and(|(_, way, _)| *way != 0.0) {
        return Err("it goes from hole to hole by arcs (Q365)".to_owned());
    }
    let (x, y, radius, start) = (q.get(216)?, q.get(217)?, q.get(244)? / 2.0, q.get(245)?);
    let count = q.count(241)?;
    let way = q.get(246)? - start;
    let parts = if way.abs() == 360.0 { count } else { count.saturating_sub(1).max(1) };
    let step = Some(q.get(247)?).filter(|step| *step != 0.0).unwrap_or(way / parts as f64);
    if step == 0.0 && count > 1 {
        return Err("its angles of start (Q245) and stop (Q246) are equal, without a step (Q247)".to_owned());
    }
    let place = |index: usize| around([x, y], radius, start + index as f64 * step);
    Ok((0..count).map(place).collect())
}

/// Places of CYCL DEF 221, program units: every second line is run back.
fn lines(q: &Parameters) -> Result<Vec<[f64; 2]>, String> {
    let (x, y, along, across) = (q.get(225)?, q.get(226)?, q.get(237)?, q.get(238)?);
    let (columns, rows, turn) = (q.count(242)?, q.count(243)?, q.get(224)?);
    if columns.saturating_mul(rows) as f64 > MOST {
        return Err(format!("it has {columns} x {rows} holes"));
    }
    let place = |index: usize| to_and_fro([x, y], turn, [along, across], [index / columns, index % columns], columns);
    Ok((0..columns * rows).map(place).collect())
}

/// A place of a grid that is turned about its first one: row and column of steps across and along; odd rows run back.
pub(crate) fn to_and_fro(
    first: [f64; 2],
    turn_deg: f64,
    [along, across]: [f64; 2],
    [row, column]: [usize; 2],
    columns: usize,
) -> [f64; 2] {
    let column = if row % 2 == 0 { column } else { columns - 1 - column };
    around(around(first, column as f64 * along, turn_deg), row as f64 * across, turn_deg + 90.0)
}

/// The point at a distance from another, in a direction in degrees from the first axis towards the second.
pub(crate) fn around(centre: [f64; 2], distance: f64, angle_deg: f64) -> [f64; 2] {
    let angle = angle_deg.to_radians();
    [centre[0] + distance * angle.cos(), centre[1] + distance * angle.sin()]
}
