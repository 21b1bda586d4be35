//! Following flow control: which block comes next.

use crate::finding;
use crate::order::flow::{skip_blank, Flow, Statement};
use crate::run::Runner;
use crate::values::parameters::Key;

/// Subroutines may call one another this deep.
const DEPTH: usize = 64;

impl Runner<'_> {
    /// Executes an O-word line; gives the block to go on with.
    pub(crate) fn follow(&mut self, statement: &Statement) -> usize {
        let next = statement.block + 1;
        match statement.flow {
            Flow::Sub => statement.end + 1,
            Flow::EndSub | Flow::Return => self.leave(statement),
            Flow::Call => self.call(statement),
            Flow::If => self.choose(statement),
            Flow::ElseIf | Flow::Else | Flow::Break => {
                if statement.flow == Flow::Break {
                    // LinuxCNC 2.9 notes it until the end of a `do` loop, which it then leaves: this one, or a later one.
                    let starts = self.table.statement(statement.start).map(|start| start.flow);
                    self.state.broke = starts == Some(Flow::While);
                }
                self.counters.retain(|(block, _)| *block != statement.start);
                statement.end + 1
            }
            Flow::EndIf | Flow::Do => next,
            Flow::While if self.holds(statement) => next,
            Flow::While => statement.end + 1,
            Flow::EndWhile => statement.start,
            Flow::DoWhile if !std::mem::take(&mut self.state.broke) && self.holds(statement) => statement.start + 1,
            Flow::DoWhile => next,
            Flow::Repeat => self.repeat(statement),
            Flow::EndRepeat => self.again(statement),
            Flow::Continue => self.continue_loop(statement),
            _ => self.follow_structured(statement),
        }
    }

    pub(crate) fn holds(&mut self, statement: &Statement) -> bool {
        let (value, _) = self.value(statement.arguments);
        value != 0.0 && !value.is_nan()
    }

    /// The first alternative whose condition holds.
    fn choose(&mut self, statement: &Statement) -> usize {
        let mut alternative = statement;
        loop {
            if matches!(alternative.flow, Flow::Else | Flow::EndIf) || self.holds(alternative) {
                return alternative.block + 1;
            }
            match self.table.statement(alternative.next) {
                Some(next) if next.block > alternative.block => alternative = next,
                _ => return statement.end + 1,
            }
        }
    }

    fn repeat(&mut self, statement: &Statement) -> usize {
        let (times, _) = self.value(statement.arguments);
        if times.round() < 1.0 || times.is_nan() {
            return statement.end + 1;
        }
        self.counters.push((statement.block, times.round() as u64));
        statement.block + 1
    }

    fn again(&mut self, statement: &Statement) -> usize {
        let Some(position) = self.counters.iter().rposition(|(block, _)| *block == statement.start) else {
            return statement.block + 1;
        };
        if let Some((_, left)) = self.counters.get_mut(position) {
            *left = left.saturating_sub(1);
            if *left > 0 {
                return statement.start + 1;
            }
        }
        self.counters.remove(position);
        statement.block + 1
    }

    /// LinuxCNC 2.9 leaves a `do` loop here, as with `break`; a `while` loop starts its next turn.
    fn continue_loop(&self, statement: &Statement) -> usize {
        match self.table.statement(statement.start).map(|start| start.flow) {
            Some(Flow::While) => statement.start,
            Some(Flow::Do) => statement.end + 1,
            _ => statement.end,
        }
    }

    fn call(&mut self, statement: &Statement) -> usize {
        let next = statement.block + 1;
        let label = self.label(statement);
        let Some(block) = self.table.subroutine(&label) else {
            let message = format!("subroutine \"o{label}\" is not in this program");
            let hint = "put the subroutine into the program's own file: what it does is not in the path";
            self.refuse(finding::FLOW, statement.at, message, hint);
            return next;
        };
        if self.returns.len() >= DEPTH {
            let message = format!("subroutines call one another more than {DEPTH} deep");
            self.refuse(finding::LIMIT, statement.at, message, "check what ends the recursion");
            return next;
        }
        let arguments = self.arguments(statement.arguments);
        self.state.store.enter(&arguments);
        self.returns.push(next);
        self.path.enter_call(self.block);
        block + 1
    }

    /// The label, computed where it is an expression.
    fn label(&mut self, statement: &Statement) -> String {
        if !statement.label.starts_with(['[', '#']) {
            return statement.label.clone();
        }
        let (value, _) = self.value(statement.at + 1);
        format!("{}", value.round())
    }

    fn arguments(&mut self, mut at: usize) -> Vec<f64> {
        let mut values = Vec::new();
        let source = self.program.source();
        loop {
            at = skip_blank(source, at);
            if source.get(at) != Some(&b'[') {
                return values;
            }
            let (value, end) = self.value(at);
            if end == at {
                return values;
            }
            values.push(value);
            at = end;
        }
    }

    /// Ends a subroutine: the caller's parameters, and the state it asked to keep, come back.
    fn leave(&mut self, statement: &Statement) -> usize {
        let result = self.arguments(statement.arguments).first().copied();
        let depth = self.returns.len();
        let Some(next) = self.returns.pop() else { return statement.block + 1 };
        while self.state.saved.last().is_some_and(|(_, kept)| *kept == Some(depth)) {
            self.state.restore_saved();
        }
        self.state.store.leave();
        self.path.leave_call();
        self.state.store.set(Key::named(b"_value"), result.unwrap_or(0.0));
        self.state.store.set(Key::named(b"_value_returned"), f64::from(u8::from(result.is_some())));
        next
    }
}
