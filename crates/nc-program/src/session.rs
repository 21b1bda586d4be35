//! A run in parts: a program too large to be held is read some lines at a time, and the state goes on from part to part.

use crate::dialect::{FlowStyle, Name, G, M};
use crate::drill::Hole;
use crate::finding::Finding;
use crate::flow::Table;
use crate::frame::Frame;
use crate::modal::{Modal, Motion};
use crate::parameters::{Key, Store};
use crate::path::ToolPath;
use crate::program::{Program, Word, WordKind};
use crate::run::{Options, Runner};

/// What goes on from part to part.
#[derive(Debug)]
struct State {
    modal: Modal,
    saved: Vec<(Modal, Option<usize>)>,
    unit_is_known: bool,
    diameter_is_known: bool,
    frame: Frame,
    position: [f64; 3],
    pole: [f64; 3],
    store: Store,
    undefined: Vec<Key>,
    tape_marks: usize,
    spindle_tool: i32,
    hole: Option<Hole>,
    retracts_to_plane: bool,
    in_program: bool,
}

/// A run in parts. Only of programs of which no block [`jumps`]: a part knows nothing of the others' blocks.
#[derive(Debug)]
pub struct Session {
    options: Options,
    state: Option<State>,
    ended: bool,
}

impl Session {
    /// Before the first part.
    pub fn new(options: Options) -> Self {
        Self { options, state: None, ended: false }
    }

    /// Whether the program's end was reached: what follows is never run.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Runs the blocks before `until` of the next part; what comes after them is looked at, not run.
    pub fn run(&mut self, part: &Program, until: usize) -> (ToolPath, Vec<Finding>) {
        if self.ended {
            return Default::default();
        }
        let mut findings = Vec::new();
        let table = Table::read(part, &mut findings);
        let mut runner = Runner::new(part, &self.options, &table, findings);
        if let Some(state) = self.state.take() {
            resume(&mut runner, state);
        }
        runner.until = until;
        self.ended = !runner.blocks();
        let (state, path, findings) = put_away(runner);
        self.state = Some(state);
        (path, findings)
    }
}

fn resume(runner: &mut Runner, state: State) {
    runner.modal = state.modal;
    runner.saved = state.saved;
    runner.unit_is_known = state.unit_is_known;
    runner.diameter_is_known = state.diameter_is_known;
    runner.frame = state.frame;
    runner.position = state.position;
    runner.pole = state.pole;
    runner.store = state.store;
    runner.undefined = state.undefined;
    runner.tape_marks = state.tape_marks;
    runner.spindle_tool = state.spindle_tool;
    runner.hole = state.hole;
    runner.retracts_to_plane = state.retracts_to_plane;
    // No block of a later part is the program's own O number.
    runner.program_start = state.in_program.then_some(usize::MAX);
}

/// Names every field: one that is new must be thought of here.
fn put_away(runner: Runner) -> (State, ToolPath, Vec<Finding>) {
    let Runner {
        program: _,
        table: _,
        options: _,
        block: _,
        next: _,
        until: _,
        visits: _,
        labels: _,
        returns: _,
        counters: _,
        program_start,
        modal,
        saved,
        unit_is_known,
        diameter_is_known,
        frame,
        position,
        pole,
        store,
        path,
        findings,
        undefined,
        tape_marks,
        spindle_tool,
        hole,
        retracts_to_plane,
    } = runner;
    let in_program = program_start.is_some();
    let state = State {
        modal,
        saved,
        unit_is_known,
        diameter_is_known,
        frame,
        position,
        pole,
        store,
        undefined,
        tape_marks,
        spindle_tool,
        hole,
        retracts_to_plane,
        in_program,
    };
    (state, path, findings)
}

/// Whether a block may send the run elsewhere: loops, calls, contours by number; or looks back.
pub fn jumps(program: &Program) -> bool {
    program.words().iter().any(|word| word_jumps(program, word))
}

fn word_jumps(program: &Program, word: &Word) -> bool {
    let dialect = program.dialect();
    match (word.kind, word.letter) {
        (WordKind::Call, _) => true,
        (WordKind::Number, b'L') => dialect.flow == FlowStyle::Structured,
        // An arc that leaves as the move before arrives, which may be of another part.
        (WordKind::Name, _) => dialect.names.get(word.value as usize) == Some(Name::Code(G::Motion(Motion::Tangent))),
        (WordKind::Flow, _) | (WordKind::Expression, b'G' | b'M') => true,
        (WordKind::Number, b'G') => {
            matches!((dialect.g)((word.value * 10.0).round() as u16), Some(G::FinishContour | G::RoughContour))
        }
        // A return is the end of a program that nothing calls, unless it names a block.
        (WordKind::Number, b'M') => match (dialect.m)(word.value.round() as u16) {
            Some(M::CallProgram | M::CallBlock) => true,
            Some(M::Return) => program.words_of(program.block_at(word.start as usize)).iter().any(|w| w.letter == b'P'),
            _ => false,
        },
        _ => false,
    }
}
