//! Gathering: the words of a block become values by letter and codes.

use crate::dialect::{Dialect, FlowStyle, Name, G, M};
use crate::drilling::called_cycle::RAPID_FEED;
use crate::finding::{self, Severity};
use crate::lint::runs_on;
use crate::modes::codes::acts;
use crate::modes::home::MACHINE_AXIS;
use crate::modes::request::{Jump, Request};
use crate::reading::program::{Word, WordKind};
use crate::run::Runner;
use crate::values::expression::{self, is_vacant, Fault, Values};
use crate::values::parameters::Key;
use crate::values::scope::{is_kept, is_numbered, is_zero, Scope};

/// Feeds of Klartext's cycles: plunging, milling, retraction, pre-positioning, counterboring, finishing, turning.
const FEEDS: [u32; 12] = [11, 12, 206, 207, 208, 253, 254, 309, 385, 478, 488, 505];

/// The parameter to which a macro gives a value to stop the run.
pub(crate) const ALARM: u32 = 3000;

/// A way to compute the value at a byte.
type Compute = fn(&[u8], usize, &Dialect, &mut dyn Values) -> Result<(f64, usize), Box<Fault>>;

/// Whether the block so far calls a macro: what follows are its arguments, M among them.
fn calls_macro(request: &Request) -> bool {
    request.codes().iter().any(|(code, _)| matches!(code, G::CallMacro | G::ModalMacro))
}

impl Runner<'_> {
    /// Reads the block being executed into the request, which is cleared first.
    pub(crate) fn gather(&mut self, request: &mut Request) {
        request.clear();
        let program = self.program;
        let counts = program.dialect().rules.point.is_some();
        for index in program.word_range(self.block) {
            let Some(word) = program.words().get(index) else { return };
            let value = match word.kind {
                WordKind::Number => word.value,
                WordKind::Expression if self.is_null(word) => continue,
                WordKind::Expression => {
                    if self.program.dialect().flow == FlowStyle::Structured {
                        self.check_reference(word);
                    }
                    let start = program.value_start(word);
                    let value = self.value(start).0;
                    if is_vacant(value) {
                        continue;
                    }
                    self.require_value(value, start);
                    value
                }
                WordKind::Assignment => {
                    self.gather_assignment(word, request);
                    continue;
                }
                WordKind::Name => {
                    self.gather_name(word.value as usize, index, request);
                    continue;
                }
                WordKind::Call => {
                    request.jump = Jump::Named(index);
                    continue;
                }
                WordKind::Unknown if !self.options.optional_blocks && program.begins_skip(word) => return,
                WordKind::Unknown => {
                    runs_on(program, word).into_iter().for_each(|found| finding::add(&mut self.findings, found));
                    continue;
                }
                WordKind::Statement | WordKind::Flow | WordKind::Label => continue,
            };
            match word.letter {
                b'G' => self.gather_g(value, index, request),
                b'M' if !calls_macro(request) => self.gather_m(value, index, request),
                b'L' if self.program.dialect().flow == FlowStyle::Structured => request.jump = Jump::Named(index),
                letter => {
                    request.set(letter, value, index);
                    if counts && !program.text(word).iter().any(|byte| b".#[".contains(byte)) {
                        request.pointless.add(letter);
                    }
                    if let Some(increment) = self.program.reference(word) {
                        request.refer(letter, increment);
                    }
                    self.note_other_axis(letter, index, request);
                }
            }
        }
    }

    /// Says once of every axis that the path is without it; an argument of a macro is none.
    fn note_other_axis(&mut self, letter: u8, index: usize, request: &Request) {
        // In the contour of a turning cycle of LinuxCNC these letters are corners and increments.
        let shapes_contour = self.draws && self.program.dialect().flow == FlowStyle::OWords;
        if shapes_contour || letter == b'C' && self.c_is_corner() || !self.program.dialect().other_axes.has(letter) {
            return;
        }
        // U and W are words of cycles, too.
        let is_argument = request.codes().iter().any(|(code, _)| match letter {
            b'U' | b'W' => acts(*code),
            MACHINE_AXIS => *code == G::FixedPoint,
            _ => matches!(code, G::CallMacro | G::ModalMacro | G::OwnCycle),
        });
        if !is_argument && !self.state.other_axes.contains(&letter) {
            self.state.other_axes.push(letter);
            self.note_opaque(index as i32, "this axis is not in the path");
        }
    }

    /// A word of the parameter that never has a value is as good as not written.
    fn is_null(&self, word: &Word) -> bool {
        let value = || self.program.source().get(self.program.value_start(word)..word.end());
        self.program.dialect().flow == FlowStyle::Macro && value() == Some(b"#0")
    }

    fn gather_g(&mut self, value: f64, index: usize, request: &mut Request) {
        if let Some(code) = self.program.dialect().g_code(value) {
            self.add_code(code, index, request);
        }
    }

    fn add_code(&mut self, code: G, index: usize, request: &mut Request) {
        if !request.add_code(code, index) {
            let at = self.word_start(index as i32);
            self.refuse(finding::LIMIT, at, "more than 16 G codes in a block".into(), "split the block");
        }
    }

    fn gather_m(&mut self, value: f64, index: usize, request: &mut Request) {
        if let Some(function) = self.program.dialect().m_code(value) {
            if matches!(function, M::CallCycle | M::CallCycleAlways) {
                request.cycle_call = Some((index as i32, function == M::CallCycleAlways));
            }
            self.apply_function(function, request);
        }
    }

    /// A word of the dialect's list of names.
    fn gather_name(&mut self, name: usize, index: usize, request: &mut Request) {
        match self.program.dialect().names.get(name) {
            Some(Name::Text(G::CallNamed)) => request.jump = Jump::Named(index),
            Some(Name::Code(code) | Name::Text(code)) => self.add_code(code, index, request),
            Some(Name::Function(function)) => self.apply_function(function, request),
            _ => {}
        }
    }

    fn apply_function(&mut self, function: M, request: &mut Request) {
        match function {
            M::End => request.ends = true,
            M::SaveState => self.state.saved.push((self.state.modal, None)),
            M::SaveStateUntilReturn => self.state.saved.push((self.state.modal, Some(self.returns.len()))),
            M::RestoreState => self.state.restore_saved(),
            M::ChangeTool => request.changes_tool = true,
            M::CallProgram => request.jump = Jump::Program,
            M::CallBlock => request.jump = Jump::Block,
            M::Return => request.jump = Jump::Return,
            M::Elsewhere => request.jump = Jump::Elsewhere,
            M::CallCycle | M::CallCycleAlways | M::Inert => {}
        }
    }

    fn gather_assignment(&mut self, word: &Word, request: &mut Request) {
        if self.program.dialect().flow == FlowStyle::Structured && self.sets_frame(word) {
            return;
        }
        let key = if word.value.is_nan() { self.key(word.start as usize) } else { Key::numbered(word.value) };
        let value = self.given_value(key.as_ref(), self.program.value_start(word), word.end());
        if let Some(Key::Number(number)) = &key {
            self.state.defined.tell(*number, (self.program.value_start(word) as u32, word.end() as u32));
        }
        match key {
            Some(key) if self.program.dialect().formulas => self.state.store.set(key, value), // one after another
            Some(key @ Key::Number(_)) if self.program.dialect().parameters.unset_is_zero && !is_numbered(&key) => {
                let message = format!("{} is no parameter that the control has", key.text(self.program.dialect()));
                self.refuse(finding::PARAMETER, word.start as usize, message, "take one from #1 to #5601");
            }
            Some(Key::Number(ALARM)) if self.program.dialect().flow == FlowStyle::Macro => {
                request.ends = true;
                self.report_alarm(word.start as usize);
            }
            Some(key) => request.assignments.push((key, value)),
            None => {}
        }
    }

    /// Reports that the program stops itself here.
    pub(crate) fn report_alarm(&mut self, at: usize) {
        let message = "the program stops here in an alarm of its own (#3000): the path ends".to_owned();
        self.refuse(finding::FLOW, at, message, "check the values that lead here");
    }

    /// The value of an assignment. Of Klartext a feed of a cycle may be rapid, or that of the tool's call, and every
    /// parameter that of GLOBAL DEF, which is not read: NaN.
    pub(crate) fn given_value(&mut self, key: Option<&Key>, at: usize, end: usize) -> f64 {
        if self.program.dialect().flow != FlowStyle::Labels {
            return self.assigned(at, end);
        }
        let text = self.program.source().get(at..end).unwrap_or(&[]).trim_ascii().to_ascii_uppercase();
        let is_feed = matches!(key, Some(Key::Number(number)) if FEEDS.contains(number));
        match text.as_slice() {
            b"PREDEF" => f64::NAN,
            b"MAX" | b"FMAX" if is_feed => RAPID_FEED,
            b"AUTO" | b"FAUTO" if is_feed && self.state.tool_feed > 0.0 => self.state.tool_feed / self.unit_of_feeds(),
            b"AUTO" | b"FAUTO" if is_feed => f64::NAN,
            _ => self.assigned(at, end),
        }
    }

    /// The value of an assignment, that ends at a byte.
    pub(crate) fn assigned(&mut self, at: usize, end: usize) -> f64 {
        if self.program.dialect().flow != FlowStyle::Macro {
            return self.value(at).0;
        }
        let (value, after) = self.computed(at, expression::formula);
        if !self.is_parameter(at, end) {
            self.require_value(value, at);
        }
        let rest = self.program.source().get(after..end).unwrap_or(&[]);
        if value.is_finite() && !rest.trim_ascii().is_empty() {
            let what = "an operator is missing".to_owned();
            self.report_fault(&Fault { at: after, what });
            return f64::NAN;
        }
        value
    }

    /// Whether a value depends on a parameter without one, of which nothing is reported; and the byte after it.
    pub(crate) fn is_undefined(&mut self, at: usize) -> Option<(bool, usize)> {
        let mut undefined = Vec::new();
        let (_, end) =
            expression::value(self.program.source(), at, self.program.dialect(), &mut self.scope(&mut undefined))
                .ok()?;
        Some((!undefined.is_empty(), end))
    }

    /// Computes the value at a byte; faults are reported and read as NaN. Gives the byte after it too.
    pub(crate) fn value(&mut self, at: usize) -> (f64, usize) {
        let formulas = self.program.dialect().formulas;
        self.computed(at, if formulas { expression::formula } else { expression::value })
    }

    /// The same of one value: brackets, a number, a parameter, without operators after it.
    pub(crate) fn bracketed(&mut self, at: usize) -> (f64, usize) {
        self.computed(at, expression::value)
    }

    fn computed(&mut self, at: usize, compute: Compute) -> (f64, usize) {
        let mut undefined = Vec::new();
        let outcome = compute(self.program.source(), at, self.program.dialect(), &mut self.scope(&mut undefined));
        self.report_undefined(undefined);
        outcome.unwrap_or_else(|fault| {
            self.report_fault(&fault);
            (f64::NAN, at)
        })
    }

    pub(crate) fn key(&mut self, at: usize) -> Option<Key<'static>> {
        let mut undefined = Vec::new();
        let outcome =
            expression::key(self.program.source(), at, self.program.dialect(), &mut self.scope(&mut undefined));
        self.report_undefined(undefined);
        outcome.map_err(|fault| self.report_fault(&fault)).ok().map(|(key, _)| key)
    }

    fn scope<'s>(&'s self, undefined: &'s mut Vec<(Key<'static>, usize)>) -> Scope<'s> {
        Scope {
            store: &self.state.store,
            modal: &self.state.modal,
            frame: &self.state.frame,
            position: self.state.position,
            touched: self.state.touched,
            tools: &self.options.tools,
            unset_is_zero: self.program.dialect().parameters.unset_is_zero,
            has_null: self.program.dialect().flow == FlowStyle::Macro,
            in_macro: self.in_macro(),
            undefined,
        }
    }

    fn report_fault(&mut self, fault: &Fault) {
        let words = self.program.words();
        let word = words.partition_point(|word| word.start as usize <= fault.at).checked_sub(1);
        let text = word.map_or(String::new(), |index| self.word_text(index as i32));
        let message = format!("{} in \"{text}\"", fault.what);
        self.refuse(finding::EXPRESSION, fault.at, message, "mend the expression at this column");
    }

    fn report_undefined(&mut self, undefined: Vec<(Key<'static>, usize)>) {
        for (key, at) in undefined {
            if self.state.undefined.contains(&key) {
                continue;
            }
            let text = key.text(self.program.dialect());
            let hint = format!("give it one: --set '{text}=…', or in a job, in its table [programs] (surface: [program]): parameters = {{ \"{text}\" = … }}");
            let hint = match &key {
                Key::Name(name) if name.as_ref() == b"o" => format!("if the figure is meant, write 0; else {hint}"),
                _ => hint,
            };
            let of_linuxcnc = self.program.dialect().parameters.unset_is_zero;
            if of_linuxcnc && is_zero(&key) {
                let message = format!("parameter {text} has no value: the control reads it as 0");
                self.report(Severity::Warning, finding::PARAMETER, at, message, &hint);
            } else if (of_linuxcnc || matches!(key, Key::Name(_))) && is_kept(&key) {
                let message = format!("the value that the control itself gives {text} is not known here");
                self.refuse(finding::PARAMETER, at, message, &hint);
            } else {
                self.refuse(finding::PARAMETER, at, format!("parameter {text} has no value"), &hint);
            }
            if self.state.undefined.is_empty() {
                self.expect_endless_loops();
            }
            self.state.undefined.push(key);
        }
    }
}
