//! Which blocks were executed, for whoever writes the program anew: all that a block does besides moving hangs on them.

use crate::run::Runner;

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
