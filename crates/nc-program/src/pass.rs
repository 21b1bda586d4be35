//! Simple turning cycles: a pass along, a threading pass or a facing pass, and back to where it began.

use crate::finding;
use crate::path::{MoveKind, Turned, INHERITED};
use crate::request::Request;
use crate::run::{Runner, AXES};

/// What a simple cycle cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Down at rapid, along Z at feed, out at feed, back at rapid (G90, G77).
    Along,
    /// Down at rapid, along Z in step with the spindle, out and back at rapid (G92, G78).
    Thread,
    /// Along Z at rapid, to X at feed, back along Z at feed, out at rapid (G94, G79).
    Face,
}

/// Values that stay from pass to pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passes {
    pass: Pass,
    /// End of the cut (x, z), mm; NaN where not given yet.
    end: [f64; 2],
    /// Start less end of the cut, across the direction of cutting: a radius, or for a facing pass a length along Z.
    taper: f64,
}

impl Passes {
    pub const fn new(pass: Pass) -> Self {
        Self { pass, end: [f64::NAN; 2], taper: 0.0 }
    }

    /// The moves of one pass from (x, z), which is where it ends.
    fn steps(&self, [x, z]: [f64; 2]) -> [(MoveKind, [f64; 2]); 4] {
        use MoveKind::{Line, Rapid, Thread};
        let [x_end, z_end] = self.end;
        match self.pass {
            Pass::Along => [(Rapid, [x_end + self.taper, z]), (Line, self.end), (Line, [x, z_end]), (Rapid, [x, z])],
            Pass::Thread => {
                [(Rapid, [x_end + self.taper, z]), (Thread, self.end), (Rapid, [x, z_end]), (Rapid, [x, z])]
            }
            Pass::Face => [(Rapid, [x, z_end + self.taper]), (Line, self.end), (Line, [x_end, z]), (Rapid, [x, z])],
        }
    }
}

impl Runner<'_> {
    /// The moves of a turning cycle to the end that its block's words state.
    pub(crate) fn emit_turned(
        &mut self,
        moves: impl IntoIterator<Item = (MoveKind, [f64; 3])>,
        words: [i32; 3],
        to: [f64; 3],
    ) {
        let first = self.path.len();
        moves.into_iter().for_each(|(kind, position)| self.emit(kind, position, [INHERITED; 3]));
        self.path.turned.push(Turned { first, end: self.path.len(), words, to });
    }

    /// A simple cycle comes into force.
    pub(crate) fn start_passes(&mut self, pass: Pass, word: i32) {
        self.state.passes = Some(Passes::new(pass));
        if pass == Pass::Thread {
            self.note_opaque(word, "how the tool is pulled out at the thread's end is the control's; taken as square");
        }
    }

    /// A block under a simple cycle: what it does not give is that of the pass before.
    pub(crate) fn pass(&mut self, request: &Request) {
        let Some(mut passes) = self.state.passes else { return };
        let (end, words) = self.target(request, false);
        for (place, axis) in [0, 2].into_iter().enumerate() {
            let increment = self.dialect_increments().is_some_and(|letters| request.any(&[letters[axis]]));
            if increment || request.any(&[AXES[axis]]) {
                passes.end[place] = end[axis];
            }
        }
        let older = if passes.pass == Pass::Face { b'K' } else { b'I' };
        let taper = request.get(b'R').or(request.get(older)).map(|taper| taper * self.state.modal.mm());
        passes.taper = taper.unwrap_or(passes.taper);
        self.state.passes = Some(passes);
        let [x, y, z] = self.state.position;
        if passes.end.iter().any(|value| value.is_nan()) {
            let message = "a simple turning cycle without the X and the Z of its end".into();
            return self.refuse(finding::MISPLACED, self.block_start(), message, "write both, or U and W");
        }
        let to = [passes.end[0], y, passes.end[1]];
        let moves = passes.steps([x, z]).map(|(kind, [x, z])| (kind, [x, y, z]));
        self.emit_turned(moves, words, to);
    }
}
