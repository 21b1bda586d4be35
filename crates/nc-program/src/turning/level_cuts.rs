//! Roughing of LinuxCNC (G71, G72) taken apart: cuts at level after level, then along the contour, pocket after pocket.

use crate::compensation::offset::minus;
use crate::path::MoveKind;
use crate::shapes::arc::Point;
use crate::turning::segment::{length, Segment, Turn, NEAR, SMALL};

/// Which pockets are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pockets {
    /// All (G71).
    All,
    /// None: only what lies above the contour's first way down (G71.1).
    None,
    /// Those that the other leaves (G71.2).
    Rest,
}

/// A move, in the contour's coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub kind: MoveKind,
    pub to: Point,
    pub turn: Option<Turn>,
}

/// More rounds than this do not come to an end.
const MOST: usize = 50_000;
const ENDLESS: &str = "its cuts do not come to an end: give I, the depth of cut, greater than zero";

pub(crate) struct LevelCuts<'a> {
    segments: &'a [Segment],
    depth: f64,
    lift: f64,
    /// Heights from which levels are counted: that of the start, and of the pocket that is cut.
    tops: Vec<f64>,
    at: Point,
    steps: Vec<Step>,
}

/// The moves that rough a contour of which the first segment leads to it, and all run towards lower `along`.
pub(crate) fn level_cuts(
    segments: &[Segment],
    pockets: Pockets,
    depth: f64,
    lift: f64,
) -> Result<Vec<Step>, &'static str> {
    let Some(first) = segments.first() else { return Ok(Vec::new()) };
    if !(depth > 0.0 && lift.is_finite()) {
        return Err(ENDLESS);
    }
    let mut cuts = LevelCuts {
        segments,
        depth: depth.max(2.0 * NEAR),
        lift,
        tops: vec![first.from[1]],
        at: first.from,
        steps: Vec::new(),
    };
    cuts.go(MoveKind::Rapid, first.from);
    cuts.pockets(pockets)?;
    Ok(cuts.steps)
}

impl LevelCuts<'_> {
    fn go(&mut self, kind: MoveKind, to: Point) {
        self.steps.push(Step { kind, to, turn: None });
        self.at = to;
    }

    fn turn(&mut self, turn: Turn, to: Point) {
        if length(minus(self.at, to)) > SMALL {
            self.steps.push(Step { kind: MoveKind::Arc, to, turn: Some(turn) });
        }
        self.at = to;
    }

    fn pockets(&mut self, pockets: Pockets) -> Result<(), &'static str> {
        let mut next = 0;
        if pockets == Pockets::Rest {
            while next < self.segments.len() && !self.dive(next, f64::NEG_INFINITY)? {
                next += 1;
            }
        }
        for _ in 0..MOST {
            let Some(lowest) = self.cut_down(next)? else { return Ok(()) };
            if pockets == Pockets::None {
                (lowest..self.segments.len()).for_each(|index| self.rise_from_level(index));
                return Ok(());
            }
            next = lowest;
            while next < self.segments.len() && !self.climb(next)? {
                next += 1;
            }
            if next == self.segments.len() {
                return Ok(());
            }
            if pockets == Pockets::Rest {
                self.count_from_here();
            }
        }
        Err(ENDLESS)
    }

    /// The levels of a pocket are counted from its edge, until the contour has come out above that.
    fn count_from_here(&mut self) {
        if self.tops.len() > 1 && self.tops.last().is_some_and(|top| self.at[1] > *top) {
            self.tops.pop();
        }
        if self.tops.len() == 1 {
            self.tops.push(self.at[1]);
        }
    }

    /// Cuts level after level until the contour goes down no further; the segment where that is.
    fn cut_down(&mut self, from: usize) -> Result<Option<usize>, &'static str> {
        let mut level = self.tops.last().copied().unwrap_or(0.0);
        let (mut index, mut rounds) = (from, 0);
        while index < self.segments.len() {
            while level - NEAR > self.at[1] && rounds < MOST {
                level -= self.depth;
                rounds += 1;
            }
            rounds += 1;
            if rounds > MOST || self.steps.len() > MOST {
                return Err(ENDLESS);
            }
            if self.dive(index, level)? {
                return Ok(Some(index));
            }
            if (self.at[1] - level).abs() > NEAR {
                index += 1;
            } else {
                index = self.cut_level(index, &mut level);
            }
        }
        Ok(None)
    }

    /// One cut to the first segment in the way, and back. The segment to go on from.
    fn cut_level(&mut self, from: usize, level: &mut f64) -> usize {
        let start = self.at;
        for (index, segment) in self.segments.iter().enumerate().skip(from) {
            let Some([first, last]) = segment.at_height(start[1]) else { continue };
            let end = if index == from { last } else { first };
            let reach = (end - start[0]).abs();
            if end - NEAR > start[0] || reach < NEAR && index == from {
                continue; // it begins on this one
            }
            if reach < NEAR && length(minus(start, segment.from)) < NEAR {
                return index;
            }
            if reach < NEAR {
                *level -= self.depth;
                return from;
            }
            let lift = self.lift * (reach / 2.0 / self.lift).min(1.0);
            self.go(MoveKind::Line, [end, start[1]]);
            self.go(MoveKind::Rapid, [end + lift, start[1] + lift]);
            self.go(MoveKind::Rapid, [start[0] - lift, start[1] + lift]);
            self.go(if from == 0 { MoveKind::Rapid } else { MoveKind::Line }, start);
            *level -= self.depth;
            return from;
        }
        from
    }

    /// Along a segment down to a level, or to its end. True where it does not go down.
    fn dive(&mut self, index: usize, level: f64) -> Result<bool, &'static str> {
        let Some(segment) = self.segments.get(index) else { return Ok(true) };
        if let Some(turn) = segment.turn {
            return Ok(self.dive_arc(segment, turn, level));
        }
        if segment.from[1] <= segment.to[1] + NEAR {
            return Ok(true);
        }
        let to = if level < segment.to[1] {
            segment.to
        } else {
            let [along, _] = segment.at_height(level).ok_or("its start lies below its contour")?;
            [along, level]
        };
        self.go(if index == 0 { MoveKind::Rapid } else { MoveKind::Line }, to);
        Ok(false)
    }

    fn dive_arc(&mut self, segment: &Segment, turn: Turn, level: f64) -> bool {
        if self.at[0] - segment.to[0] <= NEAR {
            self.at = segment.to;
            return false;
        }
        let (middle, here) = (turn.centre[0], self.at[0]);
        if if turn.left { here - NEAR > middle } else { here <= middle } {
            return true; // it goes up from here
        }
        let found = segment.at_height(level).or_else(|| segment.at_height(level - NEAR));
        let to = match found {
            Some([_, last]) if turn.left && last <= middle => [last, level],
            Some([first, _]) if !turn.left && first >= middle => [first, level],
            // The level meets the arc behind its lowest point only: the next one is looked for.
            Some(_) if !turn.left => return false,
            _ => segment.to,
        };
        self.steps.push(Step { kind: MoveKind::Arc, to, turn: Some(turn) });
        self.at = to;
        false
    }

    /// Along a segment up. True where it goes down, or goes down again.
    fn climb(&mut self, index: usize) -> Result<bool, &'static str> {
        let Some(segment) = self.segments.get(index) else { return Ok(false) };
        let Some(turn) = segment.turn else {
            if segment.to[1] + NEAR < segment.from[1] {
                return Ok(true);
            }
            if length(minus(self.at, segment.from)) > NEAR {
                return Err("its cuts lose the contour");
            }
            self.go(MoveKind::Line, segment.to);
            return Ok(false);
        };
        if turn.left {
            if self.at[0] >= turn.centre[0] {
                self.turn(turn, top(segment, turn));
            }
            return Ok(true);
        }
        if self.at[0] > turn.centre[0] {
            return Ok(true);
        }
        self.turn(turn, segment.to);
        Ok(false)
    }

    /// At the height where the tool is to a segment that goes up, and along it.
    fn rise_from_level(&mut self, index: usize) {
        let Some(segment) = self.segments.get(index) else { return };
        let Some([first, last]) = segment.at_height(self.at[1]) else { return };
        match segment.turn {
            None if segment.to[1] < segment.from[1] => {}
            None => {
                self.go(MoveKind::Line, [first, self.at[1]]);
                self.go(MoveKind::Line, segment.to);
            }
            Some(turn) if !turn.left && last <= turn.centre[0] => {
                self.go(MoveKind::Line, [last, self.at[1]]);
                self.turn(turn, segment.to);
            }
            Some(turn) if turn.left && first >= turn.centre[0] => {
                self.go(MoveKind::Line, [first, self.at[1]]);
                self.turn(turn, top(segment, turn));
            }
            Some(_) => {}
        }
    }
}

/// Where an arc that turns left is highest.
fn top(segment: &Segment, turn: Turn) -> Point {
    if segment.to[0] < turn.centre[0] {
        [turn.centre[0], turn.centre[1] + length(minus(segment.from, turn.centre))]
    } else {
        segment.to
    }
}
