//! What a parameter of the machine decides: its value is the user's to say, and asked for where a program depends on it;
//! times of dwells, which depend on the decimal point, too.

use crate::controls::Parameter;
use crate::dialect::{Dialect, FlowStyle, G};
use crate::finding::{self, Severity};
use crate::modes::modal::{FeedMode, Motion};
use crate::modes::request::Request;
use crate::reading::letters::Letters;
use crate::run::Runner;
use crate::shapes::curve::POLAR_ANGLE;
use crate::turning::rough::Rough;

/// Letters of lengths and of a line's angle, whose numbers may count steps where they have no decimal point.
const LENGTHS: &[u8] = b"IJKRUVWXYZacpqr";
/// Letters of arguments of macros that count steps so, each as its axis does.
const ARGUMENTS: &[u8] = b"ABCIJKQRUVWXYZ";
/// Rotary axes (H by increments) and angles of lines count thousandths of a degree so.
const ANGLES: &[u8] = b"ABCHaq";
const ANGLE_STEP: f64 = 0.001;

/// Letters of lengths and angles, among the words of a block with these codes.
pub(crate) fn lengths(dialect: &Dialect, codes: impl Iterator<Item = G> + Clone) -> Letters {
    if codes.clone().any(|code| matches!(code, G::CallMacro | G::ModalMacro)) {
        return Letters::of(ARGUMENTS);
    }
    let mut letters = Letters::of(LENGTHS);
    if codes.clone().any(|code| matches!(code, G::RoughContour(Rough::Pattern) | G::Setting(..))) {
        letters.remove(b'R'); // a number of passes, or of machining conditions
    }
    if codes.clone().any(|code| matches!(code, G::Drill(_) | G::DrillAlong(..))) {
        b"IJK".iter().for_each(|letter| letters.remove(*letter)); // how often a hole is drilled; pecks
    }
    if codes.clone().any(|code| code == G::Scale) {
        b"IJK".iter().for_each(|letter| letters.remove(*letter)); // factors
    }
    if codes.clone().any(|code| code == G::Rotate) {
        letters.remove(b'R'); // an angle
    }
    if codes.clone().any(|code| code == G::DiameterByWord) {
        letters.remove(b'X');
    }
    if !codes.clone().any(|code| code == G::Thread) {
        let turns = |letter: &&u8| {
            **letter == POLAR_ANGLE || dialect.other_axes.has(**letter) || dialect.line_angle.contains(letter)
        };
        ANGLES.iter().filter(turns).for_each(|letter| letters.add(*letter));
    }
    if codes.into_iter().any(|code| code == G::Limits) {
        return Letters::default(); // nothing moves
    }
    letters
}

impl Runner<'_> {
    /// The value that the user gave a parameter of the machine.
    pub(crate) fn parameter(&self, parameter: Parameter) -> Option<f64> {
        self.options.machine_parameter(parameter)
    }

    /// The same, asked for once where it was not given: as an error where positions depend on it.
    pub(crate) fn ask(&mut self, parameter: Parameter, severity: Severity, word: i32, what: &str) -> Option<f64> {
        let given = self.parameter(parameter);
        if given.is_none() && !self.state.asked.contains(&parameter.name) {
            let Parameter { name, says } = parameter;
            let text = self.word_text(word);
            let message =
                format!("\"{text}\": {what}, by the machine's parameter {name} ({says}), whose value is not given");
            let hint = format!("give it: --set '{name}=0' or '{name}=1', in a job, in its table [programs] (surface: [program]): parameters = {{ \"{name}\" = … }}");
            self.report(severity, finding::PARAMETER, self.word_start(word), message, &hint);
            if severity == Severity::Error {
                self.state.asked.push(name);
            }
        }
        given
    }

    /// Lengths without a decimal point count steps of the control, or whole units.
    pub(crate) fn count_steps(&mut self, request: &mut Request) {
        let Some(parameter) = self.program.dialect().rules.point else { return };
        let mut letters = lengths(self.program.dialect(), request.codes().iter().map(|(code, _)| *code));
        let moves = request.codes().iter().any(|(code, _)| matches!(code, G::Motion(_)));
        if self.state.modal.motion == Motion::Drill && !moves {
            letters.remove(b'K');
        }
        let c_is_corner = self.c_is_corner();
        let of_turn = |letter: u8| ANGLES.contains(&letter) && !(letter == b'C' && c_is_corner);
        for letter in b'A'..=b'r' {
            let counts = letters.has(letter) && request.pointless.has(letter);
            if !counts || request.get(letter).is_none_or(|value| value == 0.0) {
                continue;
            }
            let what = "a number without a decimal point counts steps or whole units";
            let by = match self.ask(parameter, Severity::Error, request.word(letter), what) {
                None => f64::NAN,
                Some(0.0) if of_turn(letter) => ANGLE_STEP,
                Some(0.0) => self.step_of(request),
                Some(_) => 1.0,
            };
            request.scale(letter, by);
        }
    }

    /// The control's step in the unit that is in force in the block.
    pub(crate) fn step_of(&self, request: &Request) -> f64 {
        let said = request.codes().iter().rev().find_map(|(code, _)| match code {
            G::Inch(inch) => Some(*inch),
            _ => None,
        });
        let (inch, millimetre) = self.program.dialect().resolution;
        if said.unwrap_or(self.state.modal.inch) {
            inch
        } else {
            millimetre
        }
    }

    /// What F stands for in a block, in program units a minute, a revolution or as an inverse time; negative where it is
    /// not known.
    pub(crate) fn feed_of(&mut self, request: &Request, feed: f64) -> f64 {
        let (rules, mode, inch) = (self.program.dialect().rules, self.state.modal.feed_mode, self.state.modal.inch);
        if inch && mode == FeedMode::PerMinute && rules.inch_feed != 1.0 {
            return feed * rules.inch_feed;
        }
        let Some(steps) = rules.feed_point.filter(|_| request.pointless.has(b'F') && feed != 0.0) else { return feed };
        let step = match mode {
            FeedMode::PerMinute => steps.per_minute[usize::from(inch)],
            FeedMode::PerRevolution => steps.per_revolution[usize::from(inch)],
            FeedMode::InverseTime => steps.inverse_time,
        };
        if step == 1.0 {
            return feed;
        }
        let what = "a feed without a decimal point counts steps or whole units";
        match self.ask(steps.parameter, Severity::Warning, request.word(b'F'), what) {
            None => -1.0,
            Some(0.0) => feed * step,
            Some(_) => feed,
        }
    }

    /// Whether C is a corner by the machine's parameter, not an axis.
    pub(crate) fn c_is_corner(&self) -> bool {
        let value = self.program.dialect().rules.corner_letters.and_then(|parameter| self.parameter(parameter));
        value.is_some_and(|value| value != 0.0)
    }

    /// Corners of a lathe without a comma, on a straight move: R rounds; I breaks it after a move along Z, K after one along
    /// X, or C does by a parameter. Beside G40 I and K are a direction.
    pub(crate) fn plain_corner(&mut self, request: &mut Request) {
        let rules = self.program.dialect().rules;
        let switches = request.codes().iter().any(|(code, _)| matches!(code, G::Compensation(_)));
        let named = [b"XU", b"ZW"].map(|letters| request.any(letters));
        // A line of which the angle alone is known ends where the next one has it.
        let moves = named != [false, false] || self.angle_letter(request).is_some();
        if !rules.plain_corners || switches || self.state.modal.motion != Motion::Line || !moves {
            return;
        }
        let along_one = named[0] != named[1];
        let breaks_along = |letter: u8| if letter == b'I' { [false, true] } else { [true, false] };
        let breaks_wrong = |letter: u8| b"IK".contains(&letter) && named != breaks_along(letter);
        for (letter, corner) in [(b'R', b'r'), (b'I', b'c'), (b'K', b'c'), (b'C', b'c')] {
            let Some(size) = request.get(letter) else { continue };
            let word = request.word(letter);
            let by_c = match rules.corner_letters.filter(|_| letter != b'R') {
                None => Some(false),
                Some(_) if breaks_wrong(letter) => Some(true),
                Some(_) if letter == b'C' && !along_one && !self.c_is_corner() => Some(false),
                Some(parameter) => {
                    let asked = self.ask(
                        parameter,
                        Severity::Error,
                        word,
                        "it breaks the corner at the end of the move or not",
                    );
                    asked.map(|value| value != 0.0)
                }
            };
            match (by_c, letter) {
                (None | Some(false), b'C') => continue, // an axis, or asked for
                (None, _) => {
                    request.take(letter);
                    continue;
                }
                (_, b'R') | (Some(true), b'C') => {}
                (Some(false), _) if !breaks_wrong(letter) => {}
                _ => {
                    let message = format!("{} on a straight move: the control stops", self.word_text(word));
                    let hint = "I breaks the corner after a move along Z alone, K after one along X; write a corner as ,R or ,C";
                    self.refuse(finding::MISPLACED, self.word_start(word), message, hint);
                    request.take(letter);
                    continue;
                }
            }
            request.set(corner, size, usize::try_from(word).unwrap_or(0));
            request.take(letter);
        }
    }

    /// Axis words before any code of motion: the motion is a parameter's, rapid where it is not given.
    pub(crate) fn first_motion(&mut self, request: &Request) {
        let Some(parameter) = self.program.dialect().rules.start_motion else { return };
        let word = LENGTHS.iter().map(|letter| request.word(*letter)).filter(|word| *word >= 0).min().unwrap_or(-1);
        let given = self.ask(
            parameter,
            Severity::Error,
            word,
            "the motion in force at the program's start is rapid or at feed",
        );
        self.state.modal.motion = if given.is_some_and(|value| value != 0.0) { Motion::Line } else { Motion::Rapid };
    }
}

impl Runner<'_> {
    /// Notes the block's dwell: P or F in seconds; on Fanuc and its like P without a point in milliseconds, X or U in
    /// seconds. S counts revolutions of the spindle, of which the time is not known here.
    pub(crate) fn dwell(&mut self, request: &Request) {
        let style = self.program.dialect().flow;
        let seconds = match style {
            FlowStyle::Macro => self.dwell_of_p(request).or(request.get(b'X')).or(request.get(b'U')),
            FlowStyle::OWords => request.get(b'P'),
            _ => request.get(b'F').or(request.get(b'X')).or(request.get(b'P')),
        };
        self.path.dwells.push((self.path.len(), seconds.unwrap_or(f64::NAN)));
    }

    /// P as a time, s.
    pub(crate) fn dwell_of_p(&self, request: &Request) -> Option<f64> {
        let thousandths = self.program.dialect().flow == FlowStyle::Macro && !self.has_point(request.word(b'P'));
        request.get(b'P').map(|time| if thousandths { time / 1000.0 } else { time })
    }

    /// Whether a number is written with a decimal point, or computed.
    pub(crate) fn has_point(&self, word: i32) -> bool {
        self.program
            .word(word)
            .is_some_and(|word| self.program.text(word).iter().any(|byte| matches!(byte, b'.' | b'#' | b'[')))
    }
}
