//! The runner: executes blocks in order of flow and gives the tool path.

use std::cell::OnceCell;

use crate::compensation::compensate::compensated;
use crate::controls::Parameter;
use crate::dialect::FlowStyle;
use crate::finding::{self, Finding, Severity, Unseen};
use crate::lint::require_sound;
use crate::modes::modal::Modal;
use crate::modes::request::Request;
use crate::modes::state::State;
use crate::modes::tool::Tool;
use crate::order::endless::Watch;
use crate::order::flow::Table;
use crate::order::labels::Labels;
use crate::order::visit::Visit;
use crate::path::ToolPath;
use crate::reading::letters::Letters;
use crate::reading::program::{Block, Program};
use crate::values::parameters::Key;

/// Axis letters, in order of index.
pub(crate) const AXES: [u8; 3] = *b"XYZ";

/// Blocks that are run beyond those of the program: a second of a loop.
const BLOCKS_AGAIN: usize = 3_000_000;
/// The same where a parameter has no value, for which the loop may wait.
const BLOCKS_IN_DOUBT: usize = 500_000;

/// How to run a program.
#[derive(Clone, Debug)]
pub struct Options {
    /// Values of parameters at the start.
    pub parameters: Vec<(Key<'static>, f64)>,
    /// Run the blocks that start with a slash.
    pub optional_blocks: bool,
    /// State at the start; the dialect's without one.
    pub initial: Option<Modal>,
    /// The unit of the initial state is the one in force at the start, not only the dialect's habit.
    pub unit_is_known: bool,
    /// Whether X is a diameter at the start is known, too.
    pub diameter_is_known: bool,
    /// Letters of the rotary axes that the whole program names; those of the blocks at hand where this is not said.
    pub rotary: Option<Letters>,
    /// Position at the start, mm, X a radius.
    pub position: [f64; 3],
    /// Tools for compensation: with them the path is that of the controlled point, not the contour.
    pub tools: Vec<Tool>,
    /// Work offsets by their number, from 1 (G54): machine position of the zero, mm, X a radius.
    pub work_offsets: Vec<(usize, [f64; 3])>,
    /// Most blocks to execute, every turn of a loop counted, and most moves; 3,000,000 more than the program has are
    /// enough. `usize::MAX`: nothing jumps.
    pub block_limit: usize,
    /// Note every block executed in the path.
    pub trace: bool,
    /// Take roughing cycles apart: their passes follow the contour, of which they say nothing themselves.
    pub roughing: bool,
    /// Where they are left out: run the contour of one that no finishing cycle runs, in its place, and report one whose
    /// contour is not run.
    pub roughed_contours: bool,
}

impl Options {
    /// The value that the user gave a parameter of the machine.
    pub(crate) fn machine_parameter(&self, parameter: Parameter) -> Option<f64> {
        let named = |key: &Key| matches!(key, Key::Name(name) if name.eq_ignore_ascii_case(parameter.name.as_bytes()));
        self.parameters.iter().find(|(key, _)| named(key)).map(|(_, value)| *value)
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            parameters: Vec::new(),
            optional_blocks: false,
            initial: None,
            unit_is_known: false,
            diameter_is_known: false,
            rotary: None,
            position: [0.0; 3],
            tools: Vec::new(),
            work_offsets: Vec::new(),
            block_limit: 10_000_000,
            trace: false,
            roughing: false,
            roughed_contours: false,
        }
    }
}

/// Runs a program. What could not be run is in the findings; the path is then that of the rest. It is not
/// [`placed`](ToolPath::placed).
pub fn run(program: &Program, options: &Options) -> (ToolPath, Vec<Finding>) {
    let mut findings = Vec::new();
    let table = Table::read(program, &mut findings);
    let mut runner = Runner::new(program, options, &table, findings);
    runner.blocks();
    runner.close_contour();
    require_sound(program, &runner.path, &mut runner.findings);
    if options.tools.is_empty() {
        return (runner.path, runner.findings);
    }
    let (path, found) = compensated(&runner.path, program, &options.tools);
    found.into_iter().for_each(|one| finding::add(&mut runner.findings, one));
    (path, runner.findings)
}

/// A program in the course of its run.
pub(crate) struct Runner<'a> {
    pub program: &'a Program,
    pub table: &'a Table,
    pub options: &'a Options,
    /// Index of the block being executed.
    pub block: usize,
    /// Index of the block to be executed after it.
    pub next: usize,
    /// Blocks from this index on are not run.
    pub until: usize,
    /// Calls and contours under way.
    pub visits: Vec<Visit>,
    /// Numbers of blocks and programs, once they are asked for.
    pub labels: OnceCell<Labels>,
    pub state: State,
    pub path: ToolPath,
    pub findings: Vec<Finding>,
    /// Blocks to return to from subroutines.
    pub returns: Vec<usize>,
    /// Repeat loops under way: their first block and the turns left.
    pub counters: Vec<(usize, u64)>,
    /// Lead of the thread being cut, mm; NaN where it is the feed.
    pub lead_mm: f64,
    /// Contours that are roughed: the word of the cycle, their first and last block.
    pub roughed: Vec<(i32, usize, usize)>,
    /// A contour is drawn to look at.
    pub draws: bool,
    /// Blocks executed.
    pub executed: usize,
    /// Most blocks to execute: less from the first parameter without a value on.
    pub most_blocks: usize,
    pub watch: Watch,
    /// A loop without an end was refused: nothing more is run.
    pub endless: bool,
}

impl<'a> Runner<'a> {
    pub(crate) fn new(program: &'a Program, options: &'a Options, table: &'a Table, findings: Vec<Finding>) -> Self {
        Self {
            program,
            table,
            options,
            block: 0,
            next: 0,
            until: usize::MAX,
            visits: Vec::new(),
            labels: OnceCell::new(),
            state: State::new(program, options),
            path: ToolPath::with_room(program.blocks().len().min(program.words().len()).min(options.block_limit)),
            findings,
            returns: Vec::new(),
            counters: Vec::new(),
            lead_mm: f64::NAN,
            roughed: Vec::new(),
            draws: false,
            executed: 0,
            most_blocks: match options.block_limit {
                usize::MAX => usize::MAX,
                limit => limit.min(program.blocks().len() + BLOCKS_AGAIN),
            },
            watch: Watch::default(),
            endless: false,
        }
    }

    /// A parameter has no value, and a loop may wait for ever for it: the rest of the program is run, and loops that end soon.
    pub(crate) fn expect_endless_loops(&mut self) {
        if self.options.block_limit < usize::MAX {
            let rest = self.program.blocks().len() + BLOCKS_IN_DOUBT;
            self.most_blocks = self.most_blocks.min(self.executed + rest);
        }
    }

    /// The next block to be run, if there is one.
    fn upcoming(&self) -> Option<Block> {
        self.program.blocks().get(self.next).filter(|_| self.next < self.until).copied()
    }

    /// Runs the blocks; false when the program ended before the last of them.
    pub(crate) fn blocks(&mut self) -> bool {
        let mut request = Request::new();
        while !self.endless && self.executed < self.most_blocks && self.path.len() <= self.most_blocks {
            if self.upcoming().is_none() {
                return true;
            }
            if !self.step(&mut request) {
                return false;
            }
        }
        if self.upcoming().is_some() && !self.endless {
            self.refuse_blocks(
                &format!("stopped after {} blocks or moves", self.most_blocks),
                "check what ends the program's loops",
            );
        }
        true
    }

    /// Runs the next block; false when there is none, or the program ends with it.
    pub(crate) fn step(&mut self, request: &mut Request) -> bool {
        let may_run = !self.endless && self.executed < self.most_blocks;
        let Some(block) = self.upcoming().filter(|_| may_run) else { return false };
        self.executed += 1;
        self.block = self.next;
        self.next += 1;
        self.state.tape_marks += usize::from(block.tape_mark && self.program.dialect().flow != FlowStyle::Structured);
        if self.state.tape_marks > 1 || self.leaves_program() {
            return false;
        }
        if (self.options.optional_blocks || !block.optional) && self.one(request) {
            return false;
        }
        self.end_contour();
        if self.next <= self.block {
            self.watch_loops();
        }
        true
    }

    /// Executes a block; whether the program ends with it.
    fn one(&mut self, request: &mut Request) -> bool {
        if let Some(statement) = self.table.statement(self.block) {
            self.next = self.follow(statement);
            return false;
        }
        if let Some((start, end)) = self.table.macros.statement(self.block) {
            self.follow_macro(start, end);
            return false;
        }
        self.gather(request);
        self.execute(request);
        self.trace();
        request.ends
    }

    /// Reports what keeps the program from being run as it stands.
    pub fn refuse(&mut self, code: &'static str, at: usize, message: String, hint: &str) {
        self.report(Severity::Error, code, at, message, hint);
    }

    /// Reports what is likely a slip.
    pub fn warn(&mut self, code: &'static str, at: usize, message: String, hint: &str) {
        self.report(Severity::Warning, code, at, message, hint);
    }

    pub fn report(&mut self, severity: Severity, code: &'static str, at: usize, message: String, hint: &str) {
        let unseen = Unseen::Nothing;
        finding::add(&mut self.findings, Finding { severity, code, message, hint: hint.to_owned(), at, unseen });
    }

    /// Reports at a word what of it is missing from the path.
    pub(crate) fn report_unseen(&mut self, severity: Severity, unseen: Unseen, word: i32, what: &str, hint: &str) {
        let (message, at) = (format!("{}: {what}", self.word_text(word)), self.word_start(word));
        let hint = hint.to_owned();
        finding::add(&mut self.findings, Finding { severity, code: finding::OPAQUE, message, hint, at, unseen });
    }

    /// First byte of the block being executed.
    pub fn block_start(&self) -> usize {
        self.program.blocks().get(self.block).map_or(0, |block| block.start as usize)
    }

    /// First byte of a word; of the block when there is no such word.
    pub fn word_start(&self, word: i32) -> usize {
        self.program.word(word).map_or(self.block_start(), |word| word.start as usize)
    }

    /// Text of a word, for messages.
    pub fn word_text(&self, word: i32) -> String {
        self.program.word(word).map_or(String::new(), |word| finding::excerpt(self.program.text(word)))
    }

    /// All of a word's text, in capitals.
    pub fn whole_text(&self, word: i32) -> String {
        let text = self.program.word(word).map_or(&[][..], |word| self.program.text(word));
        String::from_utf8_lossy(text).to_ascii_uppercase()
    }
}
