//! What a parameter of the machine decides: its value is the user's to say, and asked for where a program depends on it;
//! times of dwells, which depend on the decimal point, too.

use crate::controls::Parameter;
use crate::dialect::{FlowStyle, G};
use crate::finding::{self, Severity};
use crate::modes::modal::{FeedMode, Motion};
use crate::modes::request::Request;
use crate::reading::letters::Letters;
use crate::run::Runner;
use crate::turning::rough::Rough;
use crate::values::parameters::Key;

/// Letters of lengths, whose numbers may count steps where they have no decimal point.
const LENGTHS: &[u8] = b"IJKRUVWXYZ";

/// Letters of lengths that are words of a block's codes.
pub(crate) fn lengths(codes: impl Iterator<Item = G> + Clone) -> Letters {
    let mut letters = Letters::of(LENGTHS);
    if codes.clone().any(|code| matches!(code, G::RoughContour(Rough::Pattern) | G::Setting(..))) {
        letters.remove(b'R'); // a number of passes, or of machining conditions
    }
    if codes.clone().any(|code| matches!(code, G::Drill(_) | G::DrillAlong(..))) {
        letters.remove(b'K'); // how often a hole is drilled
    }
    if codes.clone().any(|code| code == G::Scale) {
        b"IJK".iter().for_each(|letter| letters.remove(*letter)); // factors
    }
    if codes.clone().any(|code| code == G::Rotate) {
        letters.remove(b'R'); // an angle
    }
    if codes.into_iter().any(|code| code == G::DiameterByWord) {
        letters.remove(b'X');
    }
    letters
}

impl Runner<'_> {
    /// The value that the user gave a parameter of the machine.
    pub(crate) fn parameter(&self, parameter: Parameter) -> Option<f64> {
        let named = |key: &Key| matches!(key, Key::Name(name) if name.eq_ignore_ascii_case(parameter.name.as_bytes()));
        self.options.parameters.iter().find(|(key, _)| named(key)).map(|(_, value)| *value)
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
        let mut letters = lengths(request.codes().iter().map(|(code, _)| *code));
        let moves = request.codes().iter().any(|(code, _)| matches!(code, G::Motion(_)));
        if self.state.modal.motion == Motion::Drill && !moves {
            letters.remove(b'K');
        }
        for letter in b'A'..=b'Z' {
            let counts = letters.has(letter) && request.pointless.has(letter);
            if !counts || request.get(letter).is_none_or(|value| value == 0.0) {
                continue;
            }
            let what = "a number without a decimal point counts steps or whole units";
            let by = match self.ask(parameter, Severity::Error, request.word(letter), what) {
                None => f64::NAN,
                Some(0.0) => self.step_of(request),
                Some(_) => 1.0,
            };
            request.scale(letter, by);
        }
    }

    /// The control's step in the unit that is in force in the block.
    fn step_of(&self, request: &Request) -> f64 {
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

    /// R or C on a straight move, without the comma of a corner.
    pub(crate) fn plain_corner(&mut self, request: &mut Request) {
        let Some(parameter) = self.program.dialect().rules.corner_letters else { return };
        if self.state.modal.motion != Motion::Line || request.get(b'R').is_none() && self.parameter(parameter).is_none()
        {
            return;
        }
        for (letter, corner) in [(b'R', b'r'), (b'C', b'c')] {
            let Some(size) = request.get(letter) else { continue };
            let word = request.word(letter);
            match self.ask(parameter, Severity::Error, word, "the corner at the end of the move is rounded or not") {
                Some(0.0) => {
                    let message = format!("{} on a straight move: the control stops", self.word_text(word));
                    self.refuse(finding::MISPLACED, self.word_start(word), message, "write a corner as ,R or ,C");
                }
                Some(_) => request.set(corner, size, usize::try_from(word).unwrap_or(0)),
                None => {}
            }
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
