//! The unit of lengths: what the program states, what it was run with, and which length comes first.

use crate::dialect::{Dialect, FlowStyle, G};
use crate::finding;
use crate::modes::codes::{is_frame, is_idle, to_machine, Action};
use crate::modes::modal::FeedMode;
use crate::modes::request::Request;
use crate::run::Runner;

/// Words that are lengths in blocks that set a frame or go to a place of the machine.
const LENGTHS: [u8; 6] = *b"XYZUVW";

/// What is known of the unit so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unit {
    /// Whoever runs the program says it.
    is_given: bool,
    /// The program has stated it.
    is_stated: bool,
    /// A length has come.
    pub is_used: bool,
    /// The block at hand goes to a place of the machine by no length of its own.
    is_idle: bool,
}

impl Unit {
    /// Before the first block.
    pub fn new(is_given: bool) -> Self {
        Self { is_given, is_stated: false, is_used: false, is_idle: false }
    }
}

/// What states the unit in a program of a dialect, where that is in its words.
fn unit_codes(dialect: &Dialect) -> &'static str {
    let states = |tenths: u16| matches!((dialect.g)(tenths), Some(G::Inch(_) | G::LengthsInch(_)));
    match dialect.flow {
        FlowStyle::Labels => "write BEGIN PGM with MM or INCH before it, or ",
        _ if states(200) => "write G20 or G21 before it, or ",
        _ if states(700) => "write G70 or G71 before it, or ",
        _ => "",
    }
}

impl Runner<'_> {
    /// The program states its unit. Before any length that is its own, whatever it was run with.
    pub(crate) fn state_unit(&mut self, inch: bool, word: i32) {
        let unit = self.state.unit;
        if unit.is_used && inch != self.state.modal.inch && self.program.dialect().rules.unit_once {
            let message = format!("\"{}\" after a length in the other unit", self.word_text(word));
            let hint = "the manual forbids it within a program: offsets in force would count in the other unit";
            // Programs of plants that switch after a return home are known: without offsets the path is not in doubt.
            let has_offsets = self.state.frame.work.values().any(|offset| offset.iter().any(|value| *value != 0.0));
            if has_offsets {
                self.refuse(finding::UNIT, self.word_start(word), message, hint);
            } else {
                self.warn(finding::UNIT, self.word_start(word), message, hint);
            }
        }
        if !unit.is_stated && !unit.is_used {
            self.path.unit_stated = Some((self.block, inch));
        }
        self.state.unit.is_stated = true;
        self.state.modal.inch = inch;
    }

    /// A length comes, the program's first: it means nothing without a unit.
    pub(crate) fn use_unit(&mut self, word: i32) {
        let unit = self.state.unit;
        if unit.is_idle {
            return;
        }
        self.state.unit.is_used = true;
        if unit.is_given || unit.is_stated {
            return;
        }
        let (name, habit) = (self.program.dialect().name, if self.state.modal.inch { "inch" } else { "mm" });
        let first = Some(self.word_text(word)).filter(|text| !text.is_empty());
        let first = first.map_or(String::new(), |text| format!(", {text}"));
        let message = format!(
            "the program does not state its unit before its first length{first}: by the habit of {name} it is {habit} (1 = {} mm)",
            self.state.modal.mm()
        );
        let hint = format!(
            "{}say which unit is in force at the start: --unit mm or --unit inch, in a job programs.unit",
            unit_codes(self.program.dialect())
        );
        self.warn(finding::UNIT, self.word_start(word), message, &hint);
    }

    /// Looks for lengths beside those of moves: of frames and feeds. Zero needs no unit where a block sets a frame or
    /// goes to a place of the machine: `G28 U0 W0`, `G53 Z0`.
    pub(crate) fn look_for_lengths(&mut self, request: &Request, action: Action) {
        let length = |letter: &&u8| request.get(**letter).is_some_and(|value| value != 0.0);
        let first = LENGTHS.iter().find(length).map(|letter| request.word(*letter));
        // The values of a fixed point's axes mean nothing.
        let fixed = matches!(action, G::FixedPoint | G::Retract | G::Swivel);
        self.state.unit.is_idle = fixed || to_machine(action) && first.is_none();
        let sets_frame = is_frame(action) && !matches!(action, G::CancelRegister(_) | G::RestoreRegister);
        let lengthens = request.codes().iter().any(|(code, _)| matches!(code, G::ToolTableOffset(_)));
        if let Some(word) = first.filter(|_| sets_frame || lengthens) {
            return self.use_unit(word);
        }
        let feeds = self.state.modal.feed_mode != FeedMode::InverseTime && !is_idle(action);
        if feeds && length(&&b'F') {
            self.use_unit(request.word(b'F'));
        }
    }
}
