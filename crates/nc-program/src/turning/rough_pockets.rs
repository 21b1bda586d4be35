//! Roughing of a contour with pockets, which is type II of the control's manuals.
//!
//! At every level there is a cut between each two walls of the contour; below it, all that is deeper between these walls
//! is cut before the tool goes on to the next. It goes down along the wall where a cut begins, and up along the one where
//! it ends, to the level before.

use crate::compensation::offset::minus;
use crate::path::MoveKind;
use crate::shapes::arc::Point;
use crate::turning::rough::{Piece, Roughing, Step, MOST, SAME, SLACK};

/// A straight cut.
#[derive(Clone, Copy)]
struct Level {
    /// How many levels deep.
    number: usize,
    /// The pieces of the contour at which it begins and ends; where the contour itself ends, their number.
    enters: usize,
    leaves: usize,
    /// Where it begins and ends.
    from: f64,
    to: f64,
}

/// The moves made so far.
struct Moves<'a> {
    roughing: &'a Roughing,
    at: Point,
    steps: Vec<Step>,
}

impl Roughing {
    /// Why it cannot be roughed out level by level: the first piece leads to the contour from the start.
    pub fn pockets_refused(&self) -> Option<&'static str> {
        if !self.pieces.iter().all(Piece::runs_on) {
            return Some("its contour turns back along its cuts");
        }
        let mut above = self.pieces.iter().skip_while(|piece| piece.to[1] >= -SLACK);
        above.any(|piece| piece.to[1] > SAME).then_some("its contour stands above its start between two pockets")
    }

    /// Whether the contour goes down again after it has begun.
    pub fn has_pocket(&self) -> bool {
        self.pieces.iter().skip(1).any(|piece| minus(piece.to, piece.from)[1] > SLACK)
    }

    /// The cuts, pocket after pocket, and back to the start. `None` when the depth of cut makes no sense.
    pub fn pocket_cuts(&self) -> Option<Vec<Step>> {
        let deepest = self.pieces.iter().map(|piece| piece.to[1]).fold(0.0, f64::max);
        if !(self.depth_of_cut > 0.0 && deepest / self.depth_of_cut <= MOST) {
            return None;
        }
        let mut moves = Moves { roughing: self, at: [0.0, 0.0], steps: Vec::new() };
        let mut waiting = self.levels(1, 0, self.pieces.len());
        while let Some(level) = waiting.pop() {
            moves.cut(&level);
            if moves.steps.len() as f64 > 10.0 * MOST {
                return None;
            }
            waiting.extend(self.levels(level.number + 1, level.enters, level.leaves));
        }
        moves.go(MoveKind::Rapid, [moves.at[0], moves.at[1].min(0.0)]);
        moves.go(MoveKind::Rapid, [0.0, 0.0]);
        Some(moves.steps)
    }

    /// The cuts of a level between two pieces, the last one first.
    fn levels(&self, number: usize, first: usize, last: usize) -> Vec<Level> {
        let depth = number as f64 * self.depth_of_cut;
        let (mut levels, mut begun) = (Vec::new(), None);
        for (index, piece) in self.pieces.iter().enumerate().take(last.saturating_add(1)).skip(first) {
            let deep = piece.to[1] > depth + SAME;
            match begun {
                None if deep => begun = Some((index, piece.crossing(depth))),
                Some((enters, from)) if !deep => {
                    levels.push(Level { number, enters, leaves: index, from, to: piece.crossing(depth) });
                    begun = None;
                }
                _ => {}
            }
        }
        if let (Some((enters, from)), Some(end)) = (begun, self.pieces.last()) {
            levels.push(Level { number, enters, leaves: self.pieces.len(), from, to: end.to[0] });
        }
        levels.retain(|level| level.to - level.from > SAME);
        levels.reverse();
        levels
    }

    /// Along the wall where a cut begins, from the level above it or the ridge: pieces and how far along each.
    fn wall_down(&self, level: &Level, top: f64) -> (Point, Vec<(usize, Point)>) {
        let mut first = level.enters;
        let at = |index: usize| self.pieces.get(index);
        while at(first).is_some_and(|piece| piece.from[1] > top + SAME)
            && first.checked_sub(1).and_then(at).is_some_and(|before| before.from[1] <= before.to[1] + SAME)
        {
            first -= 1;
        }
        let begin = at(first).map_or([level.from, top], |piece| {
            if piece.from[1] < top {
                [piece.crossing(top), top]
            } else {
                piece.from
            }
        });
        let between = (first..level.enters).filter_map(|index| Some((index, at(index)?.to)));
        let last = (level.enters, [level.from, level.number as f64 * self.depth_of_cut]);
        (begin, between.chain([last]).collect())
    }

    /// Along the wall where a cut ends, to the level above it or to the ridge.
    fn wall_up(&self, level: &Level, top: f64) -> Vec<(usize, Point)> {
        let mut way = Vec::new();
        let mut highest = 0;
        for (index, piece) in self.pieces.iter().enumerate().skip(level.leaves) {
            let rises = piece.from[1] - piece.to[1];
            if rises < -SAME {
                break;
            }
            let comes_out = piece.to[1] <= top;
            way.push((index, if comes_out { [piece.crossing(top), top] } else { piece.to }));
            if rises > SAME {
                highest = way.len();
            }
            if comes_out {
                break;
            }
        }
        way.truncate(highest); // a level ridge is left to what comes after
        way
    }
}

impl Moves<'_> {
    /// Whether a move to a place leads anywhere.
    fn leads(&self, to: Point) -> bool {
        let way = minus(to, self.at);
        way[0].hypot(way[1]) > SAME
    }

    fn go(&mut self, kind: MoveKind, to: Point) {
        if self.leads(to) {
            self.steps.push(Step::straight(kind, to));
            self.at = to;
        }
    }

    /// Along pieces of the contour; its first one as its block says.
    fn follow(&mut self, way: &[(usize, Point)]) {
        for (index, to) in way {
            match self.centre(*index) {
                Some(centre) if self.leads(*to) => {
                    self.steps.push(Step { kind: MoveKind::Arc, to: *to, centre: Some(centre) });
                    self.at = *to;
                }
                _ => self.go(self.kind(*index), *to),
            }
        }
    }

    fn centre(&self, piece: usize) -> Option<Point> {
        self.roughing.pieces.get(piece)?.centre
    }

    fn kind(&self, piece: usize) -> MoveKind {
        if piece == 0 {
            self.roughing.way_down()
        } else {
            MoveKind::Line
        }
    }

    /// One cut, from wherever the tool is, and off the wall.
    fn cut(&mut self, level: &Level) {
        let depth = level.number as f64 * self.roughing.depth_of_cut;
        let top = (level.number - 1) as f64 * self.roughing.depth_of_cut;
        let (begin, down) = self.roughing.wall_down(level, top);
        self.come_to(begin, top, &down);
        self.follow(&down);
        self.go(MoveKind::Line, [level.to, depth]);
        let up = self.roughing.wall_up(level, top);
        self.follow(&up);
        // No further back than where the cut began: there is the other wall.
        let lift = self.roughing.escape.min(self.at[0] - level.from);
        self.go(MoveKind::Rapid, minus(self.at, [lift, lift]));
    }

    /// Over what stands between to where a wall begins, and down to it.
    fn come_to(&mut self, begin: Point, top: f64, down: &[(usize, Point)]) {
        if self.at[0] != begin[0] {
            let clear = top - self.roughing.escape;
            if self.at[1] > clear {
                self.go(MoveKind::Rapid, [self.at[0], clear]);
            }
            self.go(MoveKind::Rapid, [begin[0], self.at[1]]);
        }
        let Some((piece, next)) = down.first() else { return };
        let square = next[0] == begin[0] && self.centre(*piece).is_none();
        if !square {
            self.go(self.kind(*piece), begin); // down a square wall it goes in one move
        }
    }
}
