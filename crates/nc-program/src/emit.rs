//! Moves are added to the path, and blocks that were executed noted for whoever writes the program anew: all that a block
//! does besides moving depends on them.

use crate::finding;
use crate::modes::modal::{FeedMode, Modal, Plane};
use crate::path::{Arc, MoveKind, INHERITED};
use crate::run::Runner;
use crate::shapes::arc::Circle;
use crate::shapes::contouring::Turn;

impl Runner<'_> {
    /// A straight move.
    pub(crate) fn emit(&mut self, kind: MoveKind, end: [f64; 3], words: [i32; 3]) {
        let leads = std::mem::take(&mut self.state.comes_at_rapid) && kind == MoveKind::Line;
        self.emit_move(if leads { MoveKind::Rapid } else { kind }, end, words, None);
    }

    pub(crate) fn emit_arc(&mut self, circle: Circle, sweep: f64, radius: f64, end: [f64; 3], words: [i32; 3]) {
        self.emit_move(MoveKind::Arc, end, words, Some(Turn { centre: circle.centre, sweep, radius }));
    }

    fn emit_move(&mut self, kind: MoveKind, end: [f64; 3], words: [i32; 3], turn: Option<Turn>) {
        if !self.state.unit.is_used {
            self.use_unit(words.into_iter().find(|word| *word >= 0).unwrap_or(INHERITED));
        }
        if !self.state.diameter_is_known && words[0] >= 0 && self.state.modal.plane == Plane::Zx && !self.mills() {
            self.warn_diameter(words[0]);
        }
        self.state.xy_is_milled |= self.state.xy_is_stated && self.state.modal.plane == Plane::Xy && words[1] >= 0;
        if let Some(turn) = self.put_corner(kind, end, turn) {
            let (first, second, _) = self.state.modal.plane.axes();
            let mut centre = self.state.position;
            (centre[first], centre[second]) = (turn.centre[0], turn.centre[1]);
            self.path.arcs.push(Arc { of_move: self.path.len(), centre, sweep: turn.sweep, radius: turn.radius });
        }
        if kind == MoveKind::Arc {
            self.require_circles();
        }
        let origin = self.state.frame.origin();
        let state = if kind == MoveKind::Thread {
            let feed = if self.lead_mm.is_nan() { self.state.modal.feed } else { self.lead_mm };
            self.path.state_index(&Modal { feed, feed_mode: FeedMode::PerRevolution, ..self.state.modal }, origin)
        } else if self.state.steady_feed {
            self.path.state_index(&self.state.modal, origin)
        } else {
            self.path.state_index(&Modal { feed: -1.0, ..self.state.modal }, origin)
        };
        let from = self.state.position;
        if kind == MoveKind::Probe {
            self.state.touched = [0, 1, 2].map(|axis| if end[axis] == from[axis] { from[axis] } else { f64::NAN });
        }
        self.path.push(kind, from, end, words, self.block as i32, state);
        self.state.position = end;
    }

    /// Whether a move in G18 is a mill's, as a lead-in by an arc: the program has stated G17 and moved Y in it, where X was
    /// a radius, and feeds by the minute. Turning feeds by the revolution.
    fn mills(&self) -> bool {
        self.state.xy_is_milled && self.state.modal.feed_mode == FeedMode::PerMinute
    }

    fn warn_diameter(&mut self, word: i32) {
        self.state.diameter_is_known = true;
        let message = format!(
            "the program does not say whether X is a diameter, which depends on machine data; {} is read as a radius",
            self.word_text(word)
        );
        self.warn(finding::DIAMETER, self.word_start(word), message, "write DIAMON or DIAMOF at the start");
    }
}

/// A block that was executed, in the order of execution.
#[derive(Clone, Copy, Debug)]
pub struct Executed {
    /// Its index.
    pub block: i32,
    /// Number of moves when it was done.
    pub moves: i32,
    /// Index into the path's states: what was in force then.
    pub state: i32,
}

impl Runner<'_> {
    /// Notes the block being executed, where the run was asked to.
    pub(crate) fn trace(&mut self) {
        if !self.options.trace {
            return;
        }
        let (block, moves) = (self.block as i32, self.path.len() as i32);
        let state = self.path.state_index(&self.state.modal, self.state.frame.origin());
        self.path.executed.push(Executed { block, moves, state });
    }

    /// Counts a move made after its block was noted as that block's.
    pub(crate) fn trace_return(&mut self) {
        let moves = self.path.len() as i32;
        if let Some(last) = self.path.executed.last_mut() {
            last.moves = moves;
        }
    }
}
