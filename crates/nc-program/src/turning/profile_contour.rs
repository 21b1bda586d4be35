//! The contour of LinuxCNC's turning cycles: the lines of an O-word subroutine, read but not run.

use crate::compensation::offset::plus;
use crate::dialect::G;
use crate::modes::modal::Motion;
use crate::modes::request::Request;
use crate::path::INHERITED;
use crate::run::Runner;
use crate::shapes::arc::{with_radius, Point};
use crate::turning::segment::{Segment, Turn};

/// More segments than this are a slip.
const MOST: usize = 10_000;
const WIDE: &str = "an arc of its contour is wider than its diameter";

/// A segment of the contour, (z, x) in program units, and what it was read from.
#[derive(Clone, Copy)]
pub(crate) struct Drawn {
    pub segment: Segment,
    pub block: usize,
    pub words: [i32; 3],
}

impl Runner<'_> {
    /// The contour from where the tool stands: of its lines only flow control and assignments are executed.
    pub(crate) fn read_profile(&mut self, sub: usize) -> Result<Vec<Drawn>, &'static str> {
        let (mut state, counters, depth) = (self.state.clone(), self.counters.clone(), self.returns.len());
        let (path, here) = (std::mem::take(&mut self.path), (self.block, self.next));
        self.draws = true;
        if self.state.modal.motion != Motion::Rapid {
            self.state.modal.motion = Motion::Line; // whatever was in force before the cycle
        }
        self.state.store.enter(&[]);
        self.returns.push(self.next);
        self.next = sub + 1;
        let mut drawn = Vec::new();
        let mut made = Ok(());
        let mut request = Request::new();
        while made.is_ok() && self.returns.len() > depth {
            made = self.read_line(&mut request, &mut drawn);
        }
        self.draws = false;
        while self.returns.len() > depth {
            self.returns.pop();
            self.state.store.leave();
        }
        (self.block, self.next) = here;
        (self.counters, self.path) = (counters, path);
        std::mem::swap(&mut state.store, &mut self.state.store);
        std::mem::swap(&mut state.undefined, &mut self.state.undefined);
        self.state = state;
        made.map(|()| drawn)
    }

    fn read_line(&mut self, request: &mut Request, drawn: &mut Vec<Drawn>) -> Result<(), &'static str> {
        let ended = self.executed >= self.most_blocks || drawn.len() > MOST;
        let Some(block) = self.program.blocks().get(self.next).filter(|_| !ended) else {
            return Err("its contour does not come to an end");
        };
        self.executed += 1;
        self.block = self.next;
        self.next += 1;
        if block.optional && !self.options.optional_blocks {
            return Ok(());
        }
        if let Some(statement) = self.table.statement(self.block) {
            self.next = self.follow(statement);
            return Ok(());
        }
        self.gather(request);
        for (key, value) in request.assignments.drain(..) {
            self.state.store.set(key, value);
        }
        self.read_segment(request, drawn)
    }

    /// The line or arc of a block, and the corner after it: A rounds it, C chamfers it.
    fn read_segment(&mut self, request: &Request, drawn: &mut Vec<Drawn>) -> Result<(), &'static str> {
        self.state.modal.motion = motion_code(request).unwrap_or(self.state.modal.motion);
        // In program units all along: where it touches, the root makes 1e-8 of a converted position's last bit.
        let from = drawn.last().map_or_else(|| self.in_units(self.state.position), |last| last.segment.to);
        let to = self.profile_end(request, from)?;
        if from == to || !is_cut(self.state.modal.motion) {
            return Ok(());
        }
        let turn = self.profile_turn(request, from, to)?;
        let (block, words) = (self.block, words_of(request));
        drawn.push(Drawn { segment: Segment { turn, ..Segment::line(from, to) }, block, words });
        let corner = match (request.get(b'A'), request.get(b'C')) {
            (Some(_), Some(_)) => return Err("a corner of its contour has both A and C"),
            (Some(radius), None) => Some((radius, Some(Turn { centre: to, left: false }))),
            (None, Some(leg)) => Some((leg, None)),
            (None, None) => None,
        };
        if let Some((corner, turn)) = corner {
            drawn.push(Drawn { segment: Segment { from: to, to, turn, corner }, block, words: [INHERITED; 3] });
        }
        let mm = self.state.modal.mm();
        self.state.position = [to[1] * mm, self.state.position[1], to[0] * mm];
        Ok(())
    }

    /// Where a block's line ends: U and W are increments there.
    fn profile_end(&self, request: &Request, from: Point) -> Result<Point, &'static str> {
        let mut to = from;
        for (index, position, increment, axis) in [(0, b'Z', b'W', 2), (1, b'X', b'U', 0)] {
            let share = self.state.modal.axis_mm(axis) / self.state.modal.mm();
            let own = request.get(position).map(|value| value * share);
            let by = request.get(increment).map(|value| value * share);
            let incremental = self.state.modal.incremental;
            to[index] = match (own, by) {
                (_, Some(_)) if incremental || own.is_some() => {
                    return Err("its contour has an increment beside a position, or under G91")
                }
                (_, Some(by)) => from[index] + by,
                (Some(own), None) if incremental => from[index] + own,
                (own, None) => own.unwrap_or(from[index]),
            };
        }
        Ok(to)
    }

    /// A position as (z, x) in program units.
    fn in_units(&self, position: [f64; 3]) -> Point {
        [position[2] / self.state.modal.mm(), position[0] / self.state.modal.mm()]
    }

    fn profile_turn(&self, request: &Request, from: Point, to: Point) -> Result<Option<Turn>, &'static str> {
        let left = match self.state.modal.motion {
            Motion::Clockwise => false,
            Motion::Counterclockwise => true,
            _ => return Ok(None),
        };
        let centre = match (request.get(b'R'), request.any(b"IK")) {
            (Some(_), true) => return Err("an arc of its contour has both R and a centre"),
            (None, false) => return Err("an arc of its contour has no centre"),
            (Some(radius), false) => with_radius(from, to, radius.abs(), !left, 0.0).ok_or(WIDE)?.centre,
            (None, true) => {
                let origin = if self.state.modal.centre_absolute { [0.0; 2] } else { from };
                plus(origin, [request.get(b'K').unwrap_or(0.0), request.get(b'I').unwrap_or(0.0)], 1.0)
            }
        };
        Ok(Some(Turn { centre, left }))
    }
}

/// Whether a block's coordinates are a line or arc of the contour: without a code in force (G80) they are a line.
fn is_cut(motion: Motion) -> bool {
    let arc = matches!(motion, Motion::Clockwise | Motion::Counterclockwise);
    arc || matches!(motion, Motion::Rapid | Motion::Line | Motion::None)
}

fn motion_code(request: &Request) -> Option<Motion> {
    request.codes().iter().rev().find_map(|(code, _)| match code {
        G::Motion(motion) => Some(*motion),
        G::NoMotion => Some(Motion::None),
        _ => None,
    })
}

fn words_of(request: &Request) -> [i32; 3] {
    [b'X', b'Y', b'Z'].map(|letter| request.word(letter))
}
