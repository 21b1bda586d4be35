//! Drilling cycles that are called: CYCLE81 to CYCLE89 of Sinumerik, at once or by MCALL after each move; of Klartext
//! those that CYCL DEF 200 … define, by CYCL CALL and M99, or by M89 after each move. Milling cycles too, as they are.
//!
//! Their heights are arguments and Q parameters, not words of the block that drills: a path holds where each is written.

use crate::dialect::{Name, G};
use crate::drilling::cycle_arguments::{numbers, Argument};
use crate::drilling::drill::Drill;
use crate::drilling::hole::{Drilled, Said};
use crate::drilling::milled::{has_centre, reach, POSITIONS};
use crate::finding::{Severity, Unseen};
use crate::modes::modal::{FeedMode, SpindleMode};
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::reading::names;
use crate::run::Runner;
use crate::values::parameters::Key;

/// A hole that a cycle drills wherever it is called. Heights in mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CalledHole {
    drill: Drill,
    /// Top of the workpiece.
    surface: f64,
    /// Where feed begins.
    plane: f64,
    bottom: f64,
    /// Where the tool ends.
    retract: f64,
    /// Feeds down and up, mm; NaN for that in force, negative for one that is not known, infinite at rapid.
    feeds: [f64; 2],
    said: Said,
    /// Of a milling cycle: its number, and how far from its place it reaches, mm.
    milled: Option<(u16, f64)>,
    /// Of one that goes to a centre of its own: its coordinates in the plane, mm.
    centre: Option<[f64; 2]>,
}

impl CalledHole {
    /// Where feed begins, its bottom, and where the tool ends.
    pub fn heights(&self) -> [f64; 3] {
        [self.plane, self.bottom, self.retract]
    }

    pub fn said(&self) -> Said {
        self.said
    }

    /// Its heights count from where the tool stands.
    pub fn is_relative(&self) -> bool {
        self.said.is_relative()
    }

    pub fn centre(&self) -> Option<[f64; 2]> {
        self.centre
    }

    pub fn surface(&self) -> f64 {
        self.surface
    }

    pub fn retract(&self) -> f64 {
        self.retract
    }

    /// The hole from which the tool goes no further up than where feed begins.
    pub fn ending_at_plane(self) -> Self {
        Self { retract: self.plane, ..self }
    }

    /// The hole from which the tool goes up to that height at the least.
    pub fn ending_at(self, height: f64) -> Self {
        Self { retract: self.retract.max(height), ..self }
    }

    /// Raises all of it by a height that is written at those bytes.
    pub fn raise(&mut self, by: f64, span: (u32, u32)) {
        for height in [&mut self.surface, &mut self.plane, &mut self.bottom, &mut self.retract] {
            *height += by;
        }
        self.said = Said::at([(0, 0); 2], [span, (0, 0)]);
    }
}

/// A feed of a cycle that is MAX: its moves are at rapid.
pub(crate) const RAPID_FEED: f64 = 99_999.999;

/// Lines of a cycle that is defined by numbered lines: `CYCL DEF 1.0` to `1.5`.
const LINES: usize = 6;

/// What M89 and CYCL CALL run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Defined {
    /// The cycle defined last: its number, and what it drills; `None` where it is not followed.
    pub cycle: Option<(u16, Drill)>,
    /// Every move calls it.
    pub modal: bool,
    /// Where each of [`POSITIONS`] was given last.
    positions: [(u32, u32); POSITIONS.len()],
    /// The values of its numbered lines, program units.
    lines: [Option<f64>; LINES],
}

impl Defined {
    /// A Q parameter was given at those bytes.
    pub fn tell(&mut self, number: u32, span: (u32, u32)) {
        if let Some(index) = POSITIONS.iter().position(|known| *known == number) {
            self.positions[index] = span;
        }
    }

    /// Where one of [`POSITIONS`] was given last.
    pub fn said(&self, number: u32) -> (u32, u32) {
        POSITIONS.iter().position(|known| *known == number).map_or((0, 0), |index| self.positions[index])
    }
}

/// What keeps a cycle from being followed.
type Made<T> = Result<T, String>;

impl Runner<'_> {
    /// CYCLE81 and its like: drills where the tool stands.
    pub(crate) fn cycle_here(&mut self, drill: Drill, word: i32) {
        match self.argued_hole(drill, word) {
            Ok(hole) => self.drill_here(&hole),
            Err(why) => self.not_followed(word, &why),
        }
    }

    /// MCALL: the cycle behind it runs after each move from here on; without one none does.
    pub(crate) fn modal_cycle(&mut self, word: i32) {
        self.state.modal_cycle = None;
        let Some((start, end)) = self.program.word(word).map(|word| (word.start as usize, word.end())) else { return };
        let source = self.program.source();
        let at = names::skip_blank(source, start + b"MCALL".len());
        if at >= end {
            return;
        }
        match names::meaning(source, at, self.program.dialect()) {
            Some((Name::Text(G::HoleCycle(drill)), _)) => match self.argued_hole(drill, word) {
                Ok(hole) => self.state.modal_cycle = Some(hole),
                Err(why) => self.not_followed(word, &why),
            },
            _ => self.warn_unseen(word, Unseen::Moves, "what it runs after each move is not in the path"),
        }
    }

    /// After a block's move: what MCALL, M89 and M99 run.
    pub(crate) fn call_cycle(&mut self, request: &Request, moved: bool) {
        if let Some(hole) = self.state.modal_cycle.filter(|_| moved) {
            self.drill_here(&hole);
        }
        if let Some((word, always)) = request.cycle_call {
            self.state.defined.modal = always;
            self.call_defined(word);
        } else if self.state.defined.modal && moved {
            self.call_defined(INHERITED);
        }
    }

    /// The cycle defined last: by CYCL CALL, M99 and M89.
    pub(crate) fn call_defined(&mut self, word: i32) {
        match self.state.defined.cycle {
            Some((_, Drill::Face)) => {
                if let Err(why) = self.mill_face() {
                    self.not_followed(word, &why);
                }
            }
            Some((number, Drill::Contour)) => {
                if let Err(why) = self.mill_contours(number) {
                    self.not_followed(word, &why);
                }
            }
            Some((number, drill)) => match self.defined_hole(number, drill) {
                Ok(hole) => {
                    if drill != Drill::Mill && hole.milled.is_some() {
                        self.note_opaque(word, "its passes are not in the path");
                    }
                    self.drill_here(&hole)
                }
                Err(why) => self.not_followed(word, &why),
            },
            None => self.note_unseen(word, Unseen::Moves, "the moves of the cycle defined last are not in the path"),
        }
    }

    /// CYCL DEF: what M89 calls from here on is none any more.
    pub(crate) fn define_cycle(&mut self, cycle: Option<(u16, Drill)>, word: i32) {
        (self.state.defined.cycle, self.state.defined.modal) = (cycle, false);
        self.state.defined.lines = [None; LINES];
        match cycle {
            None => self.note_unseen(word, Unseen::Block, "what it does is not in the path"),
            Some((_, Drill::Mill | Drill::Face | Drill::Contour)) => {
                self.note_opaque(word, "its passes are not in the path")
            }
            Some(_) => {}
        }
    }

    /// A numbered line of the cycle being defined: `CYCL DEF 1.2 DEPTH -15`.
    pub(crate) fn cycle_line(&mut self, word: i32) {
        let text = self.word_text(word);
        let Some((head, rest)) = text.split_once('.') else { return };
        let line = rest.bytes().next().filter(u8::is_ascii_digit).map_or(0, |digit| usize::from(digit - b'0'));
        let starts = |(index, byte): (usize, char)| {
            let next = rest.as_bytes().get(index + 1);
            let before_digit = next.is_some_and(u8::is_ascii_digit);
            let signed =
                matches!(byte, '+' | '-') && next.is_some_and(|next| matches!(next, b' ' | b'.' | b'Q' | b'q'));
            let begins = byte.is_ascii_digit() || matches!(byte, '+' | '-' | '.') && before_digit || signed;
            (index > 0 && begins || byte == 'Q' && before_digit).then_some(index)
        };
        let Some(from) = rest.char_indices().find_map(starts) else { return };
        let written = rest.get(from..).unwrap_or("").trim().replace(',', ".");
        let value = written.parse().unwrap_or_else(|_| self.value(self.word_start(word) + head.len() + 1 + from).0);
        if let Some(slot) = self.state.defined.lines.get_mut(line) {
            *slot = Some(value).filter(|value: &f64| value.is_finite());
        }
        let [_, _, depth, peck, ..] = self.state.defined.lines;
        let is_pecking = self.state.defined.cycle.is_some_and(|(number, _)| number == 1) && line == 3;
        if is_pecking && peck.zip(depth).is_some_and(|(peck, depth)| peck.abs() < depth.abs()) {
            self.note_opaque(word, "its pecks are not in the path");
        }
    }

    /// By the numbered lines of cycles 1 (pecking), 2 and 17 (tapping): their heights count from where the tool stands.
    fn hole_of_lines(&self, number: u16, drill: Drill) -> Made<CalledHole> {
        let [_, Some(clearance), Some(depth), third, fourth, fifth] = self.state.defined.lines else {
            return Err(format!("the lines {number}.1 and {number}.2 are not both given"));
        };
        if depth >= 0.0 {
            return Err(format!("its depth is {depth}"));
        }
        let mm = self.state.modal.mm();
        let here = self.state.position[self.state.modal.plane.axes().2];
        let surface = here - clearance.abs() * mm;
        let feed = if number == 1 { fifth } else { fourth };
        let feed = feed.filter(|feed| *feed > 0.0).map_or(f64::NAN, |feed| feed * self.unit_of_feeds());
        let pitch = third.filter(|pitch| number == 17 && *pitch != 0.0);
        let feed = pitch.map_or(feed, |pitch| self.feed_of_pitch(pitch, None, true) * mm);
        fitting(CalledHole {
            drill,
            surface,
            plane: here,
            bottom: surface + depth * mm,
            retract: here,
            feeds: [feed; 2],
            said: Said::RELATIVE,
            milled: self.reach_of(number, drill)?,
            centre: None,
        })
    }

    /// By the arguments `(RTP, RFP, SDIS, DP, DPR, …)`, with which all of these cycles begin.
    fn argued_hole(&mut self, drill: Drill, word: i32) -> Made<CalledHole> {
        let arguments = self.cycle_arguments(word).ok_or("its arguments cannot be read")?;
        let [retract, reference, clearance, depth, by] = numbers(&arguments);
        let text = self.word_text(word).to_ascii_uppercase();
        let (feeds, first) = self.of_cycle(word, &text, &arguments)?;
        if text.contains("CYCLE83(") {
            self.note_opaque(word, "its pecks are not in the path");
        }
        let (Some(retract), Some(reference)) = (retract, reference) else {
            return Err("its planes RTP and RFP are not given".to_owned());
        };
        let by = by.filter(|by| *by != 0.0 || depth.is_none());
        let bottom = match (depth, by) {
            (Some(depth), Some(by)) if (reference - by.abs() - depth).abs() > 1e-6 => {
                return Err("its depth is given twice, by DP and by DPR".to_owned())
            }
            (Some(depth), _) => depth,
            (None, Some(by)) => reference - by.abs(),
            _ => return Err("its depth is not given".to_owned()),
        };
        let mm = self.state.modal.mm();
        let span = |index: usize| arguments.get(index).map_or((0, 0), |argument| argument.span);
        let said = if depth.is_some() && by.is_none() {
            Said::at([span(0), span(1)], [span(3), first])
        } else {
            Said::at([span(0), (0, 0)], [span(1), if depth.is_some() { span(3) } else { first }])
        };
        fitting(CalledHole {
            drill,
            surface: reference * mm,
            plane: (reference + clearance.unwrap_or(0.0).abs()) * mm,
            bottom: bottom * mm,
            retract: retract * mm,
            feeds: feeds.map(|feed| feed * mm),
            said,
            milled: None,
            centre: None,
        })
    }

    /// Of a cycle's further arguments: its feeds, in program units, and where its first depth stands (CYCLE83).
    fn of_cycle(&mut self, word: i32, text: &str, arguments: &[Argument]) -> Made<([f64; 2], (u32, u32))> {
        let given = |index: usize| arguments.get(index).map(|argument| argument.value).filter(|value| !value.is_nan());
        let is = |number: &str| text.contains(&format!("CYCLE{number}("));
        let sideways = [("83", 12), ("84", 12), ("840", 11)];
        if sideways
            .iter()
            .any(|(number, axis)| is(number) && given(*axis).is_some_and(|axis| ![0.0, 3.0].contains(&axis)))
        {
            return Err("it drills along another axis than the plane's third".to_owned());
        }
        if (is("81") || is("82")) && given(6).is_some_and(|mode| mode >= 10.0) {
            return Err("its depth is that of a diameter or of the shank, which the tool decides".to_owned());
        }
        if is("86") && [7, 8].iter().any(|index| given(*index).is_some_and(|way| way != 0.0)) {
            self.note_opaque(word, "its step aside at the bottom is not in the path");
        }
        let in_program_units = |index: usize| given(index).is_none_or(|unit| unit == 0.0);
        let feeds = match (given(8), given(10)) {
            _ if is("85") => [6, 7].map(|index| given(index).unwrap_or(f64::NAN)),
            (Some(pitch), _) if is("84") && pitch != 0.0 => [10, 11].map(|index| {
                let mut speeds = [given(index), given(10)].into_iter().flatten();
                self.feed_of_pitch(pitch, speeds.find(|speed| *speed != 0.0), in_program_units(13))
            }),
            (encoder, Some(pitch)) if is("840") && pitch != 0.0 && encoder != Some(1.0) => {
                [self.feed_of_pitch(pitch, None, in_program_units(12)); 2]
            }
            _ => [f64::NAN; 2],
        };
        let first =
            arguments.get(5).filter(|first| is("83") && !first.value.is_nan()).map_or((0, 0), |first| first.span);
        Ok((feeds, first))
    }

    /// The feed of a tap of that pitch at a speed, that in force where none is named; negative where it is not known.
    fn feed_of_pitch(&self, pitch: f64, speed: Option<f64>, unit_is_known: bool) -> f64 {
        let modal = &self.state.modal;
        let speed = speed.unwrap_or(modal.spindle_speed);
        match modal.feed_mode {
            _ if !unit_is_known => -1.0,
            FeedMode::PerRevolution => pitch.abs(),
            FeedMode::PerMinute if modal.spindle_mode == SpindleMode::Revolutions && speed > 0.0 => pitch.abs() * speed,
            _ => -1.0,
        }
    }

    /// A feed of a cycle of 1 in mm.
    pub(crate) fn unit_of_feeds(&self) -> f64 {
        self.state.modal.mm() * if self.state.modal.inch { self.program.dialect().rules.inch_feed } else { 1.0 }
    }

    /// The cycle defined last as it is run at places: one that begins at none of its own.
    pub(crate) fn hole_at_places(&self, number: u16, drill: Drill) -> Made<CalledHole> {
        let hole = self.defined_hole(number, drill)?;
        if hole.is_relative() || hole.centre().is_some() {
            return Err("the cycle defined last begins where the tool stands, or at a centre of its own".to_owned());
        }
        Ok(hole)
    }

    /// By the Q parameters of a cycle that CYCL DEF defines.
    pub(crate) fn defined_hole(&self, number: u16, drill: Drill) -> Made<CalledHole> {
        if self.scales_depth(self.state.modal.plane.axes().2) {
            return Err("its depth is scaled or mirrored".to_owned());
        }
        if matches!(drill, Drill::Face | Drill::Contour) {
            return Err("it mills at coordinates of its own".to_owned());
        }
        if number < 6 || number == 17 {
            return self.hole_of_lines(number, drill);
        }
        let mm = self.state.modal.mm();
        let q = |number: u32| self.state.store.get(&Key::Number(number)).filter(|value| value.is_finite());
        // The tool decides the depth of a diameter; the passes of cycle 202 have a step sideways, of 240 no deeper end.
        let of_diameter = number == 240 && q(343).is_some_and(|by| by != 0.0);
        let sideways = number == 202 && q(214).is_none_or(|way| way != 0.0);
        let drill = if of_diameter || sideways { Drill::Mill } else { drill };
        let ([surface, depth], names) = match number {
            233 => ([q(227), q(386).zip(q(227)).map(|(bottom, top)| bottom - top)], "Q200, Q227 and Q386"),
            240 if of_diameter => ([q(203), q(344).map(|diameter| -diameter.abs() / 2.0)], "Q200, Q203 and Q344"),
            _ => ([q(203), q(201)], "Q200, Q201 and Q203"),
        };
        let (Some(clearance), Some(depth), Some(surface)) = (q(200), depth, surface) else {
            return Err(format!("{names} are not all given"));
        };
        let centre = has_centre(number, q).then(|| q(216).zip(q(217)).map(|(x, y)| [x * mm, y * mm]));
        if centre == Some(None) {
            return Err("Q216 and Q217 are not both given".to_owned());
        }
        if depth >= 0.0 {
            return Err(format!("its depth is {depth}"));
        }
        if self.state.store.get(&Key::Number(204)).is_some_and(f64::is_nan) {
            return Err("the value of Q204 is not known".to_owned());
        }
        let feed = |number: u32| match self.state.store.get(&Key::Number(number)) {
            Some(RAPID_FEED) => f64::INFINITY,
            Some(feed) if feed.is_nan() => -1.0,
            Some(feed) if feed > 0.0 => feed * self.unit_of_feeds(),
            _ => f64::NAN,
        };
        // A tap comes out as it goes in: a Q208 is that of a cycle before it.
        let pitch = q(239).filter(|pitch| matches!(number, 207 | 209) && *pitch != 0.0);
        let of_pitch = pitch.map(|pitch| self.feed_of_pitch(pitch, None, true) * mm);
        let (down, out) =
            (of_pitch.unwrap_or_else(|| feed(206)), if drill == Drill::Tap { f64::NAN } else { feed(208) });
        if down.is_infinite() && drill != Drill::Mill {
            return Err("its feed down Q206 is MAX".to_owned());
        }
        fitting(CalledHole {
            drill,
            surface: surface * mm,
            plane: (surface + clearance) * mm,
            bottom: (surface + depth) * mm,
            retract: (surface + clearance.max(q(204).unwrap_or(0.0))) * mm,
            feeds: [down, if out.is_nan() { down } else { out }],
            said: match number {
                233 => Said::at([self.state.defined.said(227), (0, 0)], [self.state.defined.said(386), (0, 0)]),
                _ => Said::at([(0, 0); 2], [self.state.defined.said(203), (0, 0)]),
            },
            milled: self.reach_of(number, drill)?,
            centre: centre.flatten(),
        })
    }

    /// Down from where the tool stands, and out again.
    pub(crate) fn drill_here(&mut self, hole: &CalledHole) {
        if let Some((number, reach)) = hole.milled {
            return self.mill_here(hole, number, reach);
        }
        let third = self.state.modal.plane.axes().2;
        let (at, feed, first) = (self.state.position, self.state.modal.feed, self.path.len());
        if at[third] != hole.plane {
            self.height(MoveKind::Rapid, at, third, hole.plane, INHERITED);
        }
        let [down, up] = hole.feeds.map(|own| if own.is_nan() { feed } else { own });
        let bottom = self.path.len();
        self.state.modal.feed = down;
        self.height(MoveKind::Line, at, third, hole.bottom, INHERITED);
        if matches!(hole.drill, Drill::Ream | Drill::Tap | Drill::Bore) && up.is_finite() {
            self.state.modal.feed = up;
            self.height(MoveKind::Line, at, third, hole.plane, INHERITED);
        }
        self.state.modal.feed = feed;
        if self.state.position[third] != hole.retract {
            self.height(MoveKind::Rapid, at, third, hole.retract, INHERITED);
        }
        self.path.drilled.push(Drilled {
            first,
            place: first,
            bottom,
            end: self.path.len(),
            third,
            plane_word: INHERITED,
            depth_word: INHERITED,
            plane: hole.plane,
            initial: hole.retract,
            plane_from_initial: false,
            ends_at_plane: false,
            series: 0,
            repeat: 0,
            said: Some(hole.said),
            milled: None,
        });
    }

    /// Of a milling cycle its number and how far it reaches, mm.
    fn reach_of(&self, number: u16, drill: Drill) -> Made<Option<(u16, f64)>> {
        if drill != Drill::Mill {
            return Ok(None);
        }
        self.require_plain_frame()?;
        let q = |number: u32| self.state.store.get(&Key::Number(number));
        let mm = self.state.modal.mm();
        Ok(Some((number, reach(number, q, &self.state.defined.lines, mm)? * mm)))
    }

    pub(crate) fn not_followed(&mut self, word: i32, why: &str) {
        self.warn_unseen(word, Unseen::Block, &format!("what it does is not in the path: {why}"));
    }

    pub(crate) fn warn_unseen(&mut self, word: i32, unseen: Unseen, what: &str) {
        let hint = "write the holes out as moves, or as a cycle that is followed";
        self.report_unseen(Severity::Warning, unseen, word, what, hint);
    }
}

/// A hole that can be drilled.
fn fitting(hole: CalledHole) -> Made<CalledHole> {
    let CalledHole { plane, bottom, retract, .. } = hole;
    if plane <= bottom || retract < plane || (plane + bottom + retract).is_nan() {
        return Err(format!("it drills from {plane:.4} mm to {bottom:.4} mm and ends at {retract:.4} mm"));
    }
    Ok(hole)
}
