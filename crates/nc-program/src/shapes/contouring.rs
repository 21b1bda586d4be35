//! Contours drawn with less than every point: corners between two moves, and a point where two lines meet.

use crate::compensation::offset::{meeting, Piece};
use crate::dialect::FlowStyle;
use crate::finding;
use crate::modes::modal::{Modal, Motion};
use crate::modes::request::Request;
use crate::path::{Arc, MoveKind, INHERITED};
use crate::run::Runner;
use crate::shapes::arc::Point;
use crate::shapes::rounding::{cut, Corner, Cut, Way};

/// Addresses of a rounding, of a chamfer's leg and of its length.
pub(crate) const CORNERS: [u8; 3] = [ROUND, LEG, FACE];
const ROUND: u8 = b'r';
const LEG: u8 = b'c';
const FACE: u8 = b'w';
/// Addresses of the feed of a corner, and of every corner that follows.
const CORNER_FEED: u8 = b'y';
const EVERY_FEED: u8 = b'v';
/// Address of the rounding of every corner that follows.
pub(crate) const EVERY_ROUND: u8 = b's';

/// What waits for the next move.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Contouring {
    corner: Option<Asked>,
    /// Radius of every corner's rounding, mm; zero without one.
    every_mm: f64,
    line: Option<Line>,
    /// Moves of the path when a contour was left on a way that is not in it (DEP LT).
    pub left_at: Option<usize>,
}

/// A corner asked for by a block.
#[derive(Clone, Copy, Debug)]
struct Asked {
    corner: Corner,
    block: usize,
    word: i32,
    /// The sign of I or K that breaks it: which way the next move has to go.
    towards: Option<f64>,
    /// Feed of its own, where its block has one.
    feed: Option<f64>,
}

/// A line of which only the angle is known.
#[derive(Clone, Copy, Debug)]
struct Line {
    angle: f64,
    block: usize,
    word: i32,
    /// What its block asks for at its end.
    corner: Option<Asked>,
}

/// The circle of a move: centre in the plane, angle turned, and the programmed radius.
#[derive(Clone, Copy)]
pub(crate) struct Turn {
    pub centre: Point,
    pub sweep: f64,
    pub radius: f64,
}

impl Runner<'_> {
    /// Notes the corner that a block asks for at the end of its move, or of the last one where it has none itself.
    pub(crate) fn ask_corner(&mut self, request: &Request) {
        let mm = self.state.modal.mm();
        if let Some(radius) = request.get(EVERY_ROUND) {
            self.state.contouring.every_mm = radius * mm;
        }
        let letter = CORNERS.into_iter().find(|letter| request.get(*letter).is_some());
        let size = letter.and_then(|letter| request.get(letter)).unwrap_or(0.0) * mm;
        let word = letter.map_or(INHERITED, |letter| request.word(letter));
        let plain = self.program.word(word).map(|word| word.letter).filter(u8::is_ascii_uppercase);
        let signed = matches!(plain, Some(b'I' | b'K')) || plain == Some(b'C') && size < 0.0;
        let towards = signed.then(|| size.signum());
        let size = if plain.is_some() { size.abs() } else { size };
        let corner = match letter {
            Some(LEG) => Corner::Leg(size),
            Some(FACE) => Corner::Face(size),
            Some(_) => Corner::Round(size),
            None if self.state.contouring.every_mm > 0.0 && self.has_cut() => {
                Corner::Round(self.state.contouring.every_mm)
            }
            None => return,
        };
        if let Some(feed) = request.get(EVERY_FEED) {
            self.state.corner_feed = feed;
        }
        let every = Some(self.state.corner_feed).filter(|feed| *feed > 0.0);
        let own = request.get(b'F').filter(|_| self.is_corner(request));
        let feed = own.or(request.get(CORNER_FEED)).or(every).map(|feed| self.feed_mm(request, feed));
        let asked = Asked { corner, block: self.block, word, towards, feed };
        let follows = self.has_cut() || self.is_corner(request);
        match &mut self.state.contouring.line {
            Some(line) if line.block == self.block => line.corner = Some(asked),
            _ if follows => self.state.contouring.corner = Some(asked),
            _ => self.warn_corner(&asked, "its block makes no move".into()),
        }
    }

    /// Whether the block is a corner and nothing else, between two moves.
    pub(crate) fn is_corner(&self, request: &Request) -> bool {
        let alone = self.program.dialect().flow == FlowStyle::Labels;
        alone && request.any(&CORNERS) && !self.names_axis(request)
    }

    /// Whether the block being run has made a move.
    fn has_cut(&self) -> bool {
        self.path.block.last() == Some(&(self.block as i32))
    }

    /// Puts the corner that waits between the last move and the one to come, which then begins later.
    pub(crate) fn put_corner(&mut self, kind: MoveKind, end: [f64; 3], turn: Option<Turn>) -> Option<Turn> {
        let Some(asked) = self.state.contouring.corner.take() else { return turn };
        match self.corner_before(&asked, kind, end, turn) {
            Ok(None) => turn,
            Ok(Some(cut)) => {
                self.cut_corner(&asked, &cut);
                turn.map(|turn| Turn { sweep: turn.sweep * (1.0 - cut.enters), ..turn })
            }
            Err(why) => {
                self.warn_corner(&asked, why);
                turn
            }
        }
    }

    /// Whether the last move, or what came after it without one, is a way of the control's own to or from a contour: the
    /// direction in which it arrives is not known.
    pub(crate) fn follows_way(&self) -> bool {
        let led = self.path.block.last().is_some_and(|block| self.program.leads(*block));
        led || self.state.contouring.left_at == Some(self.path.len())
    }

    /// A corner after which no move comes.
    pub(crate) fn close_contour(&mut self) {
        self.state.contouring.corner.take_if(|asked| asked.word < 0);
        self.drop_contouring("no move comes after it");
    }

    /// Reports the corner and the line that wait: the next move does not end them.
    pub(crate) fn drop_contouring(&mut self, why: &str) {
        if let Some(asked) = self.state.contouring.corner.take() {
            self.warn_corner(&asked, why.into());
        }
        self.drop_line();
    }

    fn warn_corner(&mut self, asked: &Asked, why: String) {
        let at = self.program.blocks().get(asked.block).map_or(0, |block| block.start as usize);
        let at = if asked.word >= 0 { self.word_start(asked.word) } else { at };
        let hint = "the path goes to the sharp corner; write the corner as a line or an arc of its own";
        self.warn(finding::OPAQUE, at, format!("a corner that is not cut: {why}"), hint);
    }

    fn corner_before(
        &self,
        asked: &Asked,
        kind: MoveKind,
        end: [f64; 3],
        turn: Option<Turn>,
    ) -> Result<Option<Cut>, String> {
        let (first, second, third) = self.state.modal.plane.axes();
        let Some(last) = self.path.len().checked_sub(1) else { return Err("no move comes before it".into()) };
        let (Some(from), Some(to)) = (self.path.start.get(last), self.path.end.get(last)) else { return Ok(None) };
        if self.follows_way() || self.program.leads(self.block as i32) {
            return Err("a way to or from the contour is beside it (APPR, DEP)".into());
        }
        let cuts = |kind: Option<&MoveKind>| matches!(kind, Some(MoveKind::Line | MoveKind::Arc));
        if !(cuts(self.path.kind.get(last)) && cuts(Some(&kind))) {
            return Err("it is not between two cuts".into());
        }
        if *to != self.state.position || from[third] != to[third] || end[third] != to[third] {
            return Err("the moves beside it do not lie in the plane of arcs".into());
        }
        let point = |position: &[f64; 3]| [position[first], position[second]];
        let (along, across) = if from[first] == to[first] { (first, second) } else { (second, first) };
        let turns_off = from[along] != to[along] || turn.is_some() || end[across] != to[across];
        if asked.towards.is_some_and(|sign| turns_off || (end[along] - to[along]) * sign <= 0.0) {
            return Err(
                "it is not between moves along one axis each, or the next one goes the other way than its sign".into(),
            );
        }
        let arc = self.last_arc().ok_or("the arc before it is of another plane")?;
        let before = Way { from: point(from), to: point(to), turn: arc.map(|arc| (point(&arc.centre), arc.sweep)) };
        let after = Way { from: point(to), to: point(&end), turn: turn.map(|turn| (turn.centre, turn.sweep)) };
        cut(asked.corner, &before, &after)
    }

    /// The last move's arc; `None` for one of another plane than that in force.
    pub(crate) fn last_arc(&self) -> Option<Option<&Arc>> {
        let arc = self.path.arcs.last().filter(|arc| arc.of_move + 1 == self.path.len());
        let plane =
            self.path.state.last().and_then(|state| self.path.states.get(*state as usize)).map(|modal| modal.plane);
        (arc.is_none() || plane == Some(self.state.modal.plane)).then_some(arc)
    }

    /// Ends the last move where the corner begins, and adds the corner's own.
    fn cut_corner(&mut self, asked: &Asked, cut: &Cut) {
        let (first, second, _) = self.state.modal.plane.axes();
        let set = |position: &mut [f64; 3], point: Point| (position[first], position[second]) = (point[0], point[1]);
        let last = self.path.len() - 1;
        if let Some(end) = self.path.end.last_mut() {
            set(end, cut.way.from);
        }
        if let Some(arc) = self.path.arcs.last_mut().filter(|arc| arc.of_move == last) {
            arc.sweep *= cut.leaves;
        }
        let mut centre = self.state.position;
        if let Some((about, sweep)) = cut.way.turn {
            set(&mut centre, about);
            self.path.arcs.push(Arc { of_move: last + 1, centre, sweep, radius: f64::NAN });
            let here = std::mem::replace(&mut self.block, asked.block);
            self.require_circles();
            self.block = here;
        }
        let kind = if cut.way.turn.is_some() { MoveKind::Arc } else { MoveKind::Line };
        let state = self.path.state.last().copied().unwrap_or(0);
        let before = self.path.states.get(state as usize).copied().zip(self.path.origins.get(state as usize).copied());
        // By default a Sinumerik takes the feed of the block that leads away from the corner.
        let leads_away = self.program.dialect().flow == FlowStyle::Structured;
        let feed = asked.feed.or(leads_away.then_some(self.state.modal.feed));
        let plane = self.state.modal.plane;
        let own = |modal: Modal| Modal { feed: feed.unwrap_or(modal.feed), plane, ..modal };
        let state = before.map_or(state, |(modal, origin)| self.path.state_index(&own(modal), origin));
        let start = self.path.end.last().copied().unwrap_or(self.state.position);
        set(&mut self.state.position, cut.way.to);
        self.path.corners.push((self.path.len(), asked.word));
        self.path.push(kind, start, self.state.position, [INHERITED; 3], asked.block as i32, state);
    }

    /// The line of a block that says its angle but no end: it waits for the next one. Whether it is such.
    pub(crate) fn wait_with_line(&mut self, request: &Request) -> bool {
        let (Some(letter), Motion::Line) = (self.angle_letter(request), self.state.modal.motion) else { return false };
        if self.names_axis(request) {
            return false;
        }
        let angle = request.get(letter).map_or(f64::NAN, f64::to_radians);
        self.drop_line();
        self.state.contouring.line = Some(Line { angle, block: self.block, word: request.word(letter), corner: None });
        true
    }

    /// The address of a line's angle that the block has.
    pub(crate) fn angle_letter(&self, request: &Request) -> Option<u8> {
        self.program.dialect().line_angle.iter().copied().find(|letter| request.get(*letter).is_some())
    }

    /// The line that waits ends where it meets the one to come, of that angle and end. False where none waits.
    pub(crate) fn end_line(&mut self, angle: f64, end: [f64; 3]) -> bool {
        let Some(line) = self.state.contouring.line.take() else { return false };
        let (first, second, _) = self.state.modal.plane.axes();
        let along = |angle: f64| [angle.cos(), angle.sin()];
        let before = Piece::Line([self.state.position[first], self.state.position[second]], along(line.angle));
        let found = meeting(before, Piece::Line([end[first], end[second]], along(angle)));
        let Some(point) = found else {
            self.state.contouring.line = Some(line);
            self.drop_line();
            return true;
        };
        let mut meets = self.state.position;
        (meets[first], meets[second]) = (point[0], point[1]);
        let mut words = [INHERITED; 3];
        (words[first], words[second]) = (line.word, line.word);
        let here = std::mem::replace(&mut self.block, line.block);
        self.emit(MoveKind::Line, meets, words);
        self.block = here;
        self.state.contouring.corner = line.corner;
        true
    }

    /// Reports a line whose end no block says.
    pub(crate) fn drop_line(&mut self) {
        let Some(line) = self.state.contouring.line.take() else { return };
        let message =
            format!("{}: a line without an end, which the next block does not give", self.word_text(line.word));
        let hint = "write the coordinates of its end; the path goes on as if the block were not there";
        self.warn(finding::OPAQUE, self.word_start(line.word), message, hint);
    }
}
