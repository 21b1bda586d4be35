//! The runner: executes blocks in order of flow and gives the tool path.

use crate::arc;
use crate::block::Request;
use crate::cycle::Turning;
use crate::dialect::{G, M};
use crate::expression::{self, Fault, Values};
use crate::finding::{self, Finding, Severity};
use crate::flow::{Flow, Statement, Table};
use crate::frame::Frame;
use crate::modal::{FeedMode, Modal, Motion};
use crate::parameters::{Key, Store};
use crate::path::{Arc, Move, MoveKind, ToolPath, INHERITED};
use crate::program::{Program, Word, WordKind};

/// Axis letters, in order of index.
const AXES: [u8; 3] = *b"XYZ";
/// Offsets of the arc centre, in order of axis index.
const CENTRES: [u8; 3] = *b"IJK";
/// Subroutines may call one another this deep.
const DEPTH: usize = 64;

/// How to run a program.
#[derive(Clone, Debug)]
pub struct Options {
    /// Values of parameters at the start.
    pub parameters: Vec<(Key, f64)>,
    /// Run the blocks that start with a slash.
    pub optional_blocks: bool,
    /// State at the start; the dialect's without one.
    pub initial: Option<Modal>,
    /// Position at the start, mm, X a radius.
    pub position: [f64; 3],
    /// Most blocks to execute, counted with every turn of a loop.
    pub block_limit: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            parameters: Vec::new(),
            optional_blocks: false,
            initial: None,
            position: [0.0; 3],
            block_limit: 10_000_000,
        }
    }
}

/// Runs a program. What could not be run is in the findings; the path is then that of the rest.
pub fn run(program: &Program, options: &Options) -> (ToolPath, Vec<Finding>) {
    let mut findings = Vec::new();
    let table = Table::read(program, &mut findings);
    let mut runner = Runner::new(program, options, &table, findings);
    runner.all();
    (runner.path, runner.findings)
}

/// What a block does besides setting modes.
#[derive(Clone, Copy, PartialEq)]
enum Action {
    Motion,
    SetRegister,
    CancelRegister(bool),
    RestoreRegister,
    SetData,
    ToolOffset,
    Home,
    TurningCycle,
    Nothing,
}

struct Runner<'a> {
    program: &'a Program,
    table: &'a Table,
    options: &'a Options,
    modal: Modal,
    frame: Frame,
    position: [f64; 3],
    store: Store,
    path: ToolPath,
    findings: Vec<Finding>,
    undefined: Vec<(Key, usize)>,
    known_undefined: Vec<Key>,
    returns: Vec<usize>,
    counters: Vec<(usize, u64)>,
    block: usize,
    machine_coordinates: bool,
}

struct Scope<'a> {
    store: &'a Store,
    modal: &'a Modal,
    frame: &'a Frame,
    position: [f64; 3],
    unset_is_zero: bool,
    undefined: &'a mut Vec<(Key, usize)>,
}

impl Values for Scope<'_> {
    fn get(&mut self, key: &Key, at: usize) -> f64 {
        if let Some(value) = self.store.get(key).or_else(|| self.system(key)) {
            return value;
        }
        self.undefined.push((key.clone(), at));
        if self.unset_is_zero && matches!(key, Key::Number(_)) {
            0.0
        } else {
            f64::NAN
        }
    }

    fn exists(&self, key: &Key) -> bool {
        self.store.get(key).or_else(|| self.system(key)).is_some()
    }
}

impl Scope<'_> {
    /// Parameters that the control itself keeps, in program units.
    fn system(&self, key: &Key) -> Option<f64> {
        if !self.unset_is_zero {
            return None;
        }
        let mm = self.modal.mm();
        let axis = |first: u32, number: u32| (number - first) as usize;
        match key {
            Key::Number(number @ 5420..=5422) => Some(self.position[axis(5420, *number)] / mm),
            Key::Number(number @ 5401..=5403) => Some(self.frame.tool[axis(5401, *number)] / mm),
            Key::Number(number @ 5211..=5213) => {
                Some(self.frame.register[axis(5211, *number)] / mm)
            }
            Key::Number(5220) => Some(self.frame.active as f64),
            Key::Number(5400) => Some(f64::from(self.modal.tool.max(0))),
            Key::Number(number @ 5221..=5400) => {
                let (system, axis) = ((number - 5221) / 20, (number - 5221) % 20);
                let offsets = self.frame.work.get(system as usize + 1)?;
                Some(offsets.get(axis as usize).map_or(0.0, |offset| offset / mm))
            }
            Key::Number(5061..=5070 | 5161..=5189 | 5210..=5219 | 5404..=5429) => Some(0.0),
            Key::Number(_) => None,
            Key::Name(name) => self.named(name),
        }
    }

    fn named(&self, name: &str) -> Option<f64> {
        let flag = |value: bool| Some(f64::from(u8::from(value)));
        match name {
            "_x" => Some(self.position[0] / self.modal.mm()),
            "_y" => Some(self.position[1] / self.modal.mm()),
            "_z" => Some(self.position[2] / self.modal.mm()),
            "_metric" => flag(!self.modal.inch),
            "_imperial" => flag(self.modal.inch),
            "_absolute" => flag(!self.modal.incremental),
            "_incremental" => flag(self.modal.incremental),
            "_lathe_diameter_mode" => flag(self.modal.diameter),
            "_lathe_radius_mode" => flag(!self.modal.diameter),
            "_feed" => Some(self.modal.feed.max(0.0) / self.modal.mm()),
            "_rpm" => Some(self.modal.spindle_speed.max(0.0)),
            "_current_tool" | "_selected_tool" => Some(f64::from(self.modal.tool.max(0))),
            "_coord_system" => Some(530.0 + 10.0 * self.frame.active as f64),
            "_plane" => Some(f64::from(self.modal.plane as u8) * 10.0),
            "_task" => Some(0.0),
            _ => None,
        }
    }
}

impl<'a> Runner<'a> {
    fn new(
        program: &'a Program,
        options: &'a Options,
        table: &'a Table,
        findings: Vec<Finding>,
    ) -> Self {
        let mut store = Store::default();
        for (key, value) in &options.parameters {
            store.set(key.clone(), *value);
        }
        Self {
            program,
            table,
            options,
            modal: options.initial.unwrap_or(program.dialect().initial),
            frame: Frame::new(),
            position: options.position,
            store,
            path: ToolPath::default(),
            findings,
            undefined: Vec::new(),
            known_undefined: Vec::new(),
            returns: Vec::new(),
            counters: Vec::new(),
            block: 0,
            machine_coordinates: false,
        }
    }

    fn all(&mut self) {
        let mut request = Request::new();
        let mut next = 0;
        let mut tape_marks = 0;
        for _ in 0..self.options.block_limit {
            self.block = next;
            let Some(block) = self.program.blocks().get(next) else {
                return;
            };
            if block.tape_mark {
                tape_marks += 1;
                if tape_marks > 1 && self.program.dialect().flow {
                    return;
                }
            }
            next += 1;
            if block.optional && !self.options.optional_blocks {
                continue;
            }
            if let Some(statement) = self.table.statement(self.block) {
                next = self.follow(statement);
                continue;
            }
            self.gather(&mut request);
            self.execute(&mut request);
            if request.ends {
                return;
            }
        }
        if self.program.blocks().get(next).is_some() {
            let message = format!("stopped after {} blocks", self.options.block_limit);
            self.report(
                Severity::Error,
                finding::LIMIT,
                self.block_start(),
                message,
                "check the loops' conditions",
            );
        }
    }

    fn report(
        &mut self,
        severity: Severity,
        code: &'static str,
        at: usize,
        message: String,
        hint: &str,
    ) {
        finding::add(
            &mut self.findings,
            Finding::new(severity, code, at, message, hint.to_owned()),
        );
    }

    fn block_start(&self) -> usize {
        self.program
            .blocks()
            .get(self.block)
            .map_or(0, |block| block.start as usize)
    }

    fn word_start(&self, word: i32) -> usize {
        let found = usize::try_from(word)
            .ok()
            .and_then(|index| self.program.words().get(index));
        found.map_or(self.block_start(), |word| word.start as usize)
    }

    // Values

    /// Computes the value at a byte; faults are reported and read as NaN. Gives the byte after it too.
    fn value(&mut self, at: usize) -> (f64, usize) {
        let (program, dialect) = (self.program, self.program.dialect());
        let mut scope = Scope {
            store: &self.store,
            modal: &self.modal,
            frame: &self.frame,
            position: self.position,
            unset_is_zero: dialect.parameters.unset_is_zero,
            undefined: &mut self.undefined,
        };
        let outcome = expression::value(program.source(), at, dialect, &mut scope);
        self.report_undefined();
        outcome.unwrap_or_else(|fault| {
            self.report_fault(fault);
            (f64::NAN, at)
        })
    }

    fn key(&mut self, at: usize) -> Option<Key> {
        let (program, dialect) = (self.program, self.program.dialect());
        let mut scope = Scope {
            store: &self.store,
            modal: &self.modal,
            frame: &self.frame,
            position: self.position,
            unset_is_zero: dialect.parameters.unset_is_zero,
            undefined: &mut self.undefined,
        };
        let outcome = expression::key(program.source(), at, dialect, &mut scope);
        self.report_undefined();
        outcome
            .map_err(|fault| self.report_fault(fault))
            .ok()
            .map(|(key, _)| key)
    }

    fn report_fault(&mut self, fault: Fault) {
        self.report(
            Severity::Error,
            finding::EXPRESSION,
            fault.at,
            fault.what,
            "mend the expression at this column",
        );
    }

    fn report_undefined(&mut self) {
        for (key, at) in std::mem::take(&mut self.undefined) {
            if self.known_undefined.contains(&key) {
                continue;
            }
            let text = key.text(self.program.dialect());
            let zero =
                self.program.dialect().parameters.unset_is_zero && matches!(key, Key::Number(_));
            let (severity, consequence) = if zero {
                (Severity::Warning, "; the control reads it as 0")
            } else {
                (Severity::Error, "")
            };
            let message = format!("parameter {text} has no value{consequence}");
            self.report(
                severity,
                finding::PARAMETER,
                at,
                message,
                &format!("give it one: --set '{text}=…'"),
            );
            self.known_undefined.push(key);
        }
    }

    // One block

    fn gather(&mut self, request: &mut Request) {
        request.clear();
        let program = self.program;
        for index in program.word_range(self.block) {
            let Some(word) = program.words().get(index) else {
                return;
            };
            let value = match word.kind {
                WordKind::Number => word.value,
                WordKind::Expression => self.value(program.value_start(word)).0,
                WordKind::Assignment => {
                    self.gather_assignment(word, request);
                    continue;
                }
                WordKind::Statement | WordKind::Flow | WordKind::Unknown => continue,
            };
            match word.letter {
                b'G' => self.gather_code(value, index, request),
                b'M' => {
                    let number = value.round();
                    let known = (0.0..=999.0)
                        .contains(&number)
                        .then(|| (program.dialect().m)(number as u16));
                    request.ends |= known.flatten() == Some(M::End);
                }
                letter => request.set(letter, value, index),
            }
        }
    }

    fn gather_code(&mut self, value: f64, index: usize, request: &mut Request) {
        let tenths = (value * 10.0).round();
        if (0.0..=9999.0).contains(&tenths) && !request.add_code(tenths as u16, index) {
            let at = self.word_start(index as i32);
            self.report(
                Severity::Error,
                finding::LIMIT,
                at,
                "more than 16 G codes in a block".into(),
                "split the block",
            );
        }
    }

    fn gather_assignment(&mut self, word: &Word, request: &mut Request) {
        let key = if word.value.is_nan() {
            self.key(word.start as usize)
        } else {
            Key::numbered(word.value)
        };
        let (value, _) = self.value(self.program.value_start(word));
        if let Some(key) = key {
            request.assignments.push((key, value));
        }
    }

    fn execute(&mut self, request: &mut Request) {
        let action = self.apply_codes(request);
        self.apply_feed_speed_tool(request, action);
        if action != Action::TurningCycle {
            for (key, value) in request.assignments.drain(..) {
                self.store.set(key, value);
            }
        }
        match action {
            Action::Motion => self.motion(request),
            Action::SetRegister => self.set_register(request),
            Action::CancelRegister(forget) => self.reframe(|frame| {
                frame.set_aside = if forget { [0.0; 3] } else { frame.register };
                frame.register = [0.0; 3];
            }),
            Action::RestoreRegister => self.reframe(|frame| frame.register = frame.set_aside),
            Action::SetData => self.set_data(request),
            Action::ToolOffset => self.tool_offset(request),
            Action::Home => self.home(request),
            Action::TurningCycle => self.turning_cycle(request),
            Action::Nothing => {}
        }
        self.machine_coordinates = false;
    }

    fn apply_codes(&mut self, request: &Request) -> Action {
        let mut action = Action::Motion;
        let (codes, count) = request.codes();
        for (tenths, word) in codes.into_iter().take(count) {
            if let Some(code) = (self.program.dialect().g)(tenths) {
                if let Some(found) = self.apply_code(code, word as i32, tenths) {
                    action = found;
                }
            }
        }
        action
    }

    fn apply_code(&mut self, code: G, word: i32, tenths: u16) -> Option<Action> {
        let modal = &mut self.modal;
        match code {
            G::Motion(motion) => modal.motion = motion,
            G::NoMotion => modal.motion = Motion::None,
            G::Plane(plane) => modal.plane = plane,
            G::Inch(inch) => modal.inch = inch,
            G::Incremental(incremental) => modal.incremental = incremental,
            G::CentreAbsolute(absolute) => modal.centre_absolute = absolute,
            G::Diameter(diameter) => modal.diameter = diameter,
            G::Feed(mode) if mode == modal.feed_mode => {}
            G::Feed(mode) => {
                modal.feed_mode = mode;
                modal.feed = -1.0;
            }
            G::Spindle(mode) => modal.spindle_mode = mode,
            G::Compensation(compensation) => modal.compensation = compensation,
            G::SetRegister => return Some(Action::SetRegister),
            G::CancelRegister(forget) => return Some(Action::CancelRegister(forget)),
            G::RestoreRegister => return Some(Action::RestoreRegister),
            G::WorkOffset(number) => {
                modal.work_offset = number;
                self.reframe(|frame| frame.active = usize::from(number));
            }
            G::MachineCoordinates => self.machine_coordinates = true,
            G::ToolOffset => return Some(Action::ToolOffset),
            G::NoToolOffset => self.reframe(|frame| frame.tool = [0.0; 3]),
            G::SetData => return Some(Action::SetData),
            G::Home => return Some(Action::Home),
            G::TurningCycle => return Some(Action::TurningCycle),
            G::Dwell => return Some(Action::Nothing),
            G::ToolTableOffset => self.report_opaque(
                word,
                tenths,
                "the tool table's length offset is taken as zero",
            ),
            G::OpaqueCycle => {
                modal.motion = Motion::None;
                self.report_opaque(word, tenths, "the cycle's own moves are not in the path");
                return Some(Action::Nothing);
            }
            G::Inert => {}
        }
        None
    }

    fn report_opaque(&mut self, word: i32, tenths: u16, what: &str) {
        let message = format!("G{}: {what}", f64::from(tenths) / 10.0);
        let hint = "nothing to mend; a correction never touches these blocks";
        self.report(
            Severity::Note,
            finding::OPAQUE,
            self.word_start(word),
            message,
            hint,
        );
    }

    fn apply_feed_speed_tool(&mut self, request: &Request, action: Action) {
        if let Some(feed) = request.get(b'F') {
            let unit = if self.modal.feed_mode == FeedMode::InverseTime {
                1.0
            } else {
                self.modal.mm()
            };
            self.modal.feed = feed * unit;
        }
        if let Some(speed) = request.get(b'S').filter(|_| action != Action::SetRegister) {
            self.modal.spindle_speed = speed;
        }
        if let Some(tool) = request.get(b'T') {
            self.modal.tool = tool.round() as i32;
        }
    }

    // Frames

    /// Changes what positions are called: the tool stays where it is.
    fn reframe(&mut self, change: impl FnOnce(&mut Frame)) {
        let before = self.frame.totals();
        change(&mut self.frame);
        let after = self.frame.totals();
        for axis in 0..3 {
            self.position[axis] += before[axis] - after[axis];
        }
    }

    fn given(&self, request: &Request) -> [Option<f64>; 3] {
        [0, 1, 2].map(|axis| {
            request
                .get(AXES[axis])
                .map(|value| value * self.modal.axis_mm(axis))
        })
    }

    fn set_register(&mut self, request: &Request) {
        let (given, position) = (self.given(request), self.position);
        let reached = [0, 1, 2].map(|axis| given[axis].unwrap_or(position[axis]));
        self.reframe(|frame| {
            frame.register =
                [0, 1, 2].map(|axis| frame.register[axis] + position[axis] - reached[axis]);
            frame.set_aside = frame.register;
        });
        self.position = reached;
    }

    /// G10: L2 sets a work offset, L20 so that the present position gets the values given.
    fn set_data(&mut self, request: &Request) {
        let level = request.get(b'L').unwrap_or(0.0).round() as i64;
        let system = match request.get(b'P').unwrap_or(0.0).round() as i64 {
            0 => self.frame.active,
            number => usize::try_from(number).unwrap_or(usize::MAX),
        };
        let rotated = request.get(b'R').is_some_and(|angle| angle != 0.0);
        if !matches!(level, 2 | 20) || !(1..=9).contains(&system) || rotated {
            let what = format!("G10 L{level}: only work offsets without rotation are followed");
            let hint = "nothing to mend; the path is given as if this block were not there";
            return self.report(
                Severity::Warning,
                finding::OPAQUE,
                self.block_start(),
                what,
                hint,
            );
        }
        let (given, position, totals) = (self.given(request), self.position, self.frame.totals());
        self.reframe(|frame| {
            let others = [0, 1, 2].map(|axis| frame.register[axis] + frame.tool[axis]);
            let Some(offsets) = frame.work.get_mut(system) else {
                return;
            };
            *offsets = [0, 1, 2].map(|axis| match given[axis] {
                Some(value) if level == 2 => value,
                Some(value) => position[axis] + totals[axis] - others[axis] - value,
                None => offsets[axis],
            });
        });
    }

    fn tool_offset(&mut self, request: &Request) {
        let given = self.given(request);
        self.reframe(|frame| {
            frame.tool = [0, 1, 2].map(|axis| given[axis].unwrap_or(frame.tool[axis]))
        });
    }

    // Motion

    /// End of the move that the block asks for, and the words that set it.
    fn target(&self, request: &Request) -> ([f64; 3], [i32; 3]) {
        let (mut end, mut words) = (self.position, [INHERITED; 3]);
        for axis in 0..3 {
            let Some(value) = request.get(AXES[axis]) else {
                continue;
            };
            let value = value * self.modal.axis_mm(axis);
            end[axis] = if self.machine_coordinates {
                value - self.frame.total(axis)
            } else if self.modal.incremental {
                self.position[axis] + value
            } else {
                value
            };
            words[axis] = request.word(AXES[axis]);
        }
        (end, words)
    }

    fn motion(&mut self, request: &Request) {
        let to_somewhere = request.any(&AXES);
        let circular = matches!(
            self.modal.motion,
            Motion::Clockwise | Motion::Counterclockwise
        );
        if !(to_somewhere || circular && request.any(&CENTRES)) {
            return self.report_no_target(request, circular);
        }
        let (end, words) = self.target(request);
        match self.modal.motion {
            Motion::Rapid => self.straight(MoveKind::Rapid, end, words),
            Motion::Line => self.straight(MoveKind::Line, end, words),
            Motion::Probe => self.straight(MoveKind::Probe, end, words),
            Motion::Thread => self.straight(MoveKind::Thread, end, words),
            Motion::Clockwise | Motion::Counterclockwise => return self.arc(request, end, words),
            Motion::None => self.report_no_motion(request),
        }
        if request.any(b"R") {
            let message = format!(
                "R{} on a straight move has no meaning",
                request.get(b'R').unwrap_or(0.0)
            );
            let hint = "a block may have lost its G02 or G03";
            self.report(
                Severity::Warning,
                finding::MISPLACED,
                self.word_start(request.word(b'R')),
                message,
                hint,
            );
        }
    }

    fn report_no_target(&mut self, request: &Request, circular: bool) {
        let (codes, count) = request.codes();
        let arc_code = codes
            .iter()
            .take(count)
            .find(|(tenths, _)| matches!(tenths, 20 | 30))
            .map(|(_, word)| *word);
        if let Some(word) = arc_code.filter(|_| circular) {
            let message = "an arc without coordinates: nothing moves".to_owned();
            let at = self.word_start(word as i32);
            let hint = "its coordinates may have slipped into the line before";
            self.report(Severity::Warning, finding::MISPLACED, at, message, hint);
        }
    }

    fn report_no_motion(&mut self, request: &Request) {
        let word = AXES
            .iter()
            .map(|letter| request.word(*letter))
            .find(|word| *word >= 0)
            .unwrap_or(-1);
        let message = "coordinates, but no motion code is in force: nothing moves".to_owned();
        self.report(
            Severity::Warning,
            finding::MISPLACED,
            self.word_start(word),
            message,
            "write G00 or G01 before it",
        );
    }

    fn straight(&mut self, kind: MoveKind, end: [f64; 3], words: [i32; 3]) {
        self.emit(kind, end, words, -1);
    }

    fn emit(&mut self, kind: MoveKind, end: [f64; 3], words: [i32; 3], arc: i32) {
        let state = self.path.state(&self.modal);
        self.path.moves.push(Move {
            kind,
            start: self.position,
            end,
            words,
            block: self.block as u32,
            state,
            arc,
        });
        self.position = end;
    }

    fn arc(&mut self, request: &Request, end: [f64; 3], words: [i32; 3]) {
        let Some((mut arc, radius)) = self.circle(request, end) else {
            let message = "an arc that cannot exist: no centre, no length, or a chord longer than twice its radius";
            let hint = "check the end point and R, or I, J, K; the path goes straight to the end";
            self.report(
                Severity::Error,
                finding::ARC,
                self.block_start(),
                message.to_owned(),
                hint,
            );
            return self.straight(MoveKind::Line, end, words);
        };
        if let Some(turns) = request
            .get(b'P')
            .map(f64::round)
            .filter(|turns| (2.0..=1e6).contains(turns))
        {
            arc.sweep += std::f64::consts::TAU.copysign(arc.sweep) * (turns - 1.0);
        }
        let (first, second, _) = self.modal.plane.axes();
        let mut centre = self.position;
        centre[first] = arc.centre[0];
        centre[second] = arc.centre[1];
        let index = self.path.arcs.len() as i32;
        self.path.arcs.push(Arc {
            centre,
            sweep: arc.sweep,
            radius,
        });
        self.emit(MoveKind::Arc, end, words, index);
    }

    /// The circle of an arc block, and its R in mm (NaN without one). I, J, K are radius values.
    fn circle(&self, request: &Request, end: [f64; 3]) -> Option<(arc::Circle, f64)> {
        let (first, second, _) = self.modal.plane.axes();
        let clockwise = self.modal.motion == Motion::Clockwise;
        let (from, to) = (
            [self.position[first], self.position[second]],
            [end[first], end[second]],
        );
        let mm = self.modal.mm();
        if let Some(radius) = request.get(b'R').map(|radius| radius * mm) {
            let slack = self.resolution_mm() * 10.0;
            return arc::with_radius(from, to, radius, clockwise, slack)
                .map(|circle| (circle, radius.abs()));
        }
        let given = [request.get(CENTRES[first]), request.get(CENTRES[second])];
        if given == [None, None] {
            return None;
        }
        let offset = given.map(|value| value.unwrap_or(0.0) * mm);
        let centre = if self.modal.centre_absolute {
            offset
        } else {
            [from[0] + offset[0], from[1] + offset[1]]
        };
        arc::about(from, to, centre, clockwise).map(|circle| (circle, f64::NAN))
    }

    fn resolution_mm(&self) -> f64 {
        let (inch, millimetre) = self.program.dialect().resolution;
        if self.modal.inch {
            inch * 25.4
        } else {
            millimetre
        }
    }

    /// Through the given point to the stored machine position of the axes given (all axes when none is).
    fn home(&mut self, request: &Request) {
        if request.any(&AXES) {
            let (through, words) = self.target(request);
            self.straight(MoveKind::Rapid, through, words);
        }
        let mut end = self.position;
        for axis in 0..3 {
            if !request.any(&AXES) || request.get(AXES[axis]).is_some() {
                end[axis] = -self.frame.total(axis);
            }
        }
        self.straight(MoveKind::Rapid, end, [INHERITED; 3]);
    }

    fn turning_cycle(&mut self, request: &Request) {
        let (end, _) = self.target(request);
        let mm = self.modal.mm();
        let cycle = Turning {
            start: [self.position[0], self.position[2]],
            end: [end[0], end[2]],
            depth_of_cut: request.cycle_parameter(1).unwrap_or(0.0) * mm,
            taper_start_z: request
                .cycle_parameter(2)
                .map_or(end[2], |value| value * mm),
        };
        let Some(steps) = cycle.steps() else {
            let message = format!(
                "a turning cycle with depth of cut {} mm",
                cycle.depth_of_cut
            );
            let hint = "give P1=, the depth of cut on the radius, and an X other than the start's";
            return self.report(
                Severity::Error,
                finding::MISPLACED,
                self.block_start(),
                message,
                hint,
            );
        };
        for (at_feed, [x, z]) in steps {
            let kind = if at_feed {
                MoveKind::Line
            } else {
                MoveKind::Rapid
            };
            self.straight(kind, [x, self.position[1], z], [INHERITED; 3]);
        }
    }

    // Flow

    /// Executes an O-word line; gives the block to go on with.
    fn follow(&mut self, statement: &Statement) -> usize {
        let next = statement.block + 1;
        match statement.flow {
            Flow::Sub => statement.end + 1,
            Flow::EndSub | Flow::Return => self.leave(statement),
            Flow::Call => self.call(statement),
            Flow::If => self.choose(statement),
            Flow::ElseIf | Flow::Else | Flow::Break => {
                self.counters.retain(|(block, _)| *block != statement.start);
                statement.end + 1
            }
            Flow::EndIf | Flow::Do => next,
            Flow::While if self.holds(statement) => next,
            Flow::While => statement.end + 1,
            Flow::EndWhile => statement.start,
            Flow::DoWhile if self.holds(statement) => statement.start + 1,
            Flow::DoWhile => next,
            Flow::Repeat => self.repeat(statement),
            Flow::EndRepeat => self.again(statement),
            Flow::Continue => self.continue_loop(statement),
        }
    }

    fn holds(&mut self, statement: &Statement) -> bool {
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
        let Some(position) = self
            .counters
            .iter()
            .rposition(|(block, _)| *block == statement.start)
        else {
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

    fn continue_loop(&mut self, statement: &Statement) -> usize {
        match self
            .table
            .statement(statement.start)
            .map(|start| start.flow)
        {
            Some(Flow::While) => statement.start,
            _ => statement.end,
        }
    }

    fn call(&mut self, statement: &Statement) -> usize {
        let next = statement.block + 1;
        let label = self.label(statement);
        let Some(block) = self.table.subroutine(&label) else {
            let message = format!("subroutine o{label} is not in this program");
            let hint =
                "what it does is not in the path; put the subroutine into the program's own file";
            self.report(Severity::Error, finding::FLOW, statement.at, message, hint);
            return next;
        };
        if self.returns.len() >= DEPTH {
            let message = format!("subroutines call one another more than {DEPTH} deep");
            self.report(
                Severity::Error,
                finding::LIMIT,
                statement.at,
                message,
                "check what ends the recursion",
            );
            return next;
        }
        let arguments = self.arguments(statement.arguments);
        self.store.enter(&arguments);
        self.returns.push(next);
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
            while matches!(source.get(at), Some(b' ' | b'\t')) {
                at += 1;
            }
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

    fn leave(&mut self, statement: &Statement) -> usize {
        let result = self.arguments(statement.arguments).first().copied();
        let Some(next) = self.returns.pop() else {
            return statement.block + 1;
        };
        self.store.leave();
        self.store
            .set(Key::Name("_value".into()), result.unwrap_or(0.0));
        self.store.set(
            Key::Name("_value_returned".into()),
            f64::from(u8::from(result.is_some())),
        );
        next
    }
}
