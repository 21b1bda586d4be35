//! Dwells: the time between two moves.

use crate::dialect::FlowStyle;
use crate::request::Request;
use crate::run::Runner;

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
        let found = usize::try_from(word).ok().and_then(|word| self.program.words().get(word));
        found.is_some_and(|word| self.program.text(word).iter().any(|byte| matches!(byte, b'.' | b'#' | b'[')))
    }
}
