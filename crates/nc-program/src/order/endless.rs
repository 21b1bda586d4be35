//! Loops without an end: a program that comes back to the state it was in goes the same way for ever.

use crate::finding;
use crate::modes::state::State;
use crate::order::visit::Visit;
use crate::run::Runner;
use crate::values::parameters::Store;

/// Jumps back before the first state is kept: loops that end soon cost nothing.
const JUMPS: usize = 4096;
/// States that are compared as a whole with one that is kept: a loop that ends is alike in its position seldom so often.
const COMPARED: usize = 64;

/// The jumps back of a run, and one state that was met at them (Brent: the next one is kept after twice as many jumps).
#[derive(Debug, Default)]
pub(crate) struct Watch {
    jumps: usize,
    kept: Option<Kept>,
}

#[derive(Debug)]
struct Kept {
    next: usize,
    executed: usize,
    position: [f64; 3],
    turns: u64,
    store: Store,
    /// Index of the numbered parameter that differed last.
    differs: usize,
    compared: usize,
    whole: String,
}

impl Runner<'_> {
    /// Looks, at a jump back, for a loop that never ends: it is refused, and nothing more is run.
    pub(crate) fn watch_loops(&mut self) {
        self.watch.jumps += 1;
        if self.watch.jumps < JUMPS {
            return;
        }
        if self.watch.jumps.is_power_of_two() {
            self.watch.kept = Some(self.kept());
        } else if let Some(blocks) = self.is_back() {
            self.endless = true;
            let why = format!("a loop without an end: all is as it was {blocks} blocks before");
            self.refuse_blocks(&why, "change in the loop what its condition reads, or leave it by a jump");
        }
    }

    /// Refuses to run more blocks; of parameters without a value the first is named, which a loop may wait for.
    pub(crate) fn refuse_blocks(&mut self, why: &str, hint: &str) {
        let name = self.state.undefined.first().map(|key| key.text(self.program.dialect()));
        let (message, hint) = match name {
            Some(name) => (
                format!("{why}, and {name} has no value"),
                format!("if a loop waits for it, give it one: --set '{name}=…'; check what ends the program's loops"),
            ),
            None => (why.to_owned(), hint.to_owned()),
        };
        self.refuse(finding::LIMIT, self.block_start(), message, &hint);
    }

    fn kept(&mut self) -> Kept {
        Kept {
            next: self.next,
            executed: self.executed,
            position: self.state.position,
            turns: self.turns_left(),
            store: self.state.store.clone(),
            differs: 0,
            compared: 0,
            whole: self.whole(),
        }
    }

    /// Blocks since the state that is kept, where this one equals it. What differs most often is compared first.
    fn is_back(&mut self) -> Option<usize> {
        let kept = self.watch.kept.as_ref()?;
        let alike = kept.compared < COMPARED && kept.next == self.next && kept.position == self.state.position;
        if !alike || !self.state.store.agrees_at(&kept.store, kept.differs) || kept.turns != self.turns_left() {
            return None;
        }
        let kept = self.watch.kept.as_mut()?;
        if let Some(differs) = self.state.store.first_difference(&kept.store) {
            kept.differs = differs;
            return None;
        }
        kept.compared += 1;
        let whole = self.whole();
        let kept = self.watch.kept.as_ref()?;
        (kept.whole == whole).then(|| self.executed - kept.executed)
    }

    /// Turns that counted loops and calls have left, summed.
    fn turns_left(&self) -> u64 {
        let counted = self.counters.iter().map(|(_, left)| *left);
        counted.chain(self.visits.iter().map(Visit::left)).fold(0, u64::wrapping_add)
    }

    /// Everything that decides how the run goes on, as a text: NaN equals itself there. How often offsets came into
    /// force is only noted with the moves.
    fn whole(&mut self) -> String {
        let renamed = std::mem::take(&mut self.state.frame.renamed);
        let state: &State = &self.state;
        let whole = format!("{state:?} {:?} {:?} {:?} {}", self.visits, self.returns, self.counters, self.lead_mm);
        self.state.frame.renamed = renamed;
        whole
    }
}
