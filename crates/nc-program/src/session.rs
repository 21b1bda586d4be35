//! A run in parts: a program too large to be held is read some lines at a time, and the state goes on from part to part.

use crate::dialect::{FlowStyle, G, M};
use crate::finding::Finding;
use crate::lint::require_sound;
use crate::modes::modal::Motion;
use crate::modes::state::State;
use crate::order::flow::Table;
use crate::path::ToolPath;
use crate::reading::letters::Letters;
use crate::reading::program::{Block, Program, Word, WordKind};
use crate::run::{Options, Runner};
use crate::shapes::contouring::{CORNERS, EVERY_ROUND};

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

    /// Runs the blocks before `until` of the next part; what comes after them is looked at, not run. The path is not
    /// [`placed`](ToolPath::placed).
    pub fn run(&mut self, part: &Program, until: usize) -> (ToolPath, Vec<Finding>) {
        if self.ended {
            return Default::default();
        }
        let mut findings = Vec::new();
        let table = Table::read(part, &mut findings);
        let mut runner = Runner::new(part, &self.options, &table, findings);
        if let Some(state) = self.state.take() {
            runner.state = state.going_on();
        }
        runner.until = until;
        self.ended = !runner.blocks();
        runner.require_contours_run();
        require_sound(part, &runner.path, &mut runner.findings);
        self.state = Some(runner.state);
        (runner.path, runner.findings)
    }
}

/// Whether a block may send the run elsewhere: loops, calls, contours by number; or looks back.
pub fn jumps(program: &Program) -> bool {
    // A corner shortens the move before, which may be of another part.
    let mut shapes = Letters::of(&CORNERS);
    shapes.add(EVERY_ROUND);
    program.dialect().line_angle.iter().for_each(|letter| shapes.add(*letter));
    let codes = Letters::of(b"GLM");
    let plain = |word: &Word| word.kind == WordKind::Number && !codes.has(word.letter);
    let is_text = |block: &Block| block.first_word > 0 && block.tape_mark; // what comes after it may be no block
    let mut blocks = program.blocks().iter().skip_while(|block| !is_text(block)).skip(1);
    blocks.any(|block| block.end > block.start)
        || program.words().iter().any(|word| {
            let is_value = matches!(word.kind, WordKind::Number | WordKind::Expression);
            is_value && shapes.has(word.letter) || !plain(word) && word_jumps(program, word)
        })
}

fn word_jumps(program: &Program, word: &Word) -> bool {
    let dialect = program.dialect();
    match (word.kind, word.letter) {
        (WordKind::Call, _) => true,
        (WordKind::Number, b'L') => dialect.flow == FlowStyle::Structured,
        // An arc that leaves as the move before arrives, or goes about a pole: either may be of another part.
        (WordKind::Name, _) => match program.code(word) {
            Some(G::Motion(Motion::Tangent) | G::CallNamed | G::CallFile | G::GoToName) => true,
            // The heights of its holes are said where it is defined.
            Some(
                G::HoleCycle(_)
                | G::Pattern(_)
                | G::MillPocket(_)
                | G::ModalCycle
                | G::DefineCycle(Some(_))
                | G::DefinePattern,
            ) => true,
            Some(G::Pole(_)) => dialect.about_pole,
            _ => false,
        },
        (WordKind::Flow, _) | (WordKind::Expression, b'G' | b'M') => true,
        (WordKind::Number, b'G') => {
            let elsewhere = |code| matches!(code, G::FinishContour | G::RoughContour(_) | G::CallMacro | G::ModalMacro);
            program.code(word).is_some_and(elsewhere)
        }
        // A return is the end of a program that nothing calls, unless it names a block.
        (WordKind::Number, b'M') => match dialect.m_code(word.value) {
            Some(M::CallProgram | M::CallBlock) => true,
            Some(M::Return) => program.words_of(program.block_at(word.start as usize)).iter().any(|w| w.letter == b'P'),
            _ => false,
        },
        _ => false,
    }
}
