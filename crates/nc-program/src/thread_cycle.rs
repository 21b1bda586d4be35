//! Threading cycles (G76): what their words say, of LinuxCNC and of Fanuc and Haas lathes.

use crate::dialect::FlowStyle;
use crate::finding;
use crate::path::{MoveKind, INHERITED};
use crate::request::Request;
use crate::run::Runner;
use crate::thread::{depths, Slopes, Thread, MOST};

/// Lengths of Fanuc's G76 that take no decimal point count such steps: inch and mm.
const STEP: [f64; 2] = [1e-4, 1e-3];

/// What Fanuc's first block of two says, for those that follow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThreadData {
    finishes: usize,
    angle: f64,
    least: f64,
    allowance: f64,
}

impl ThreadData {
    pub const NONE: Self = Self { finishes: 1, angle: 0.0, least: 0.0, allowance: 0.0 };
}

impl Runner<'_> {
    /// G76 of either kind.
    pub(crate) fn thread_cycle(&mut self, request: &Request, word: i32) {
        if self.program.dialect().flow != FlowStyle::Macro {
            self.linuxcnc_thread(request);
        } else if self.names_axis(request) {
            self.macro_thread(request, word);
        } else {
            self.state.thread = self.thread_data(request);
        }
    }

    fn refuse_thread(&mut self) {
        let hint = "a threading cycle wants its end, the depth of the first pass and a greater one of the thread";
        let message = "a threading cycle whose depths make no sense".to_owned();
        self.refuse(finding::MISPLACED, self.block_start(), message, hint);
    }

    fn emit_thread(&mut self, steps: Vec<(MoveKind, [f64; 2])>) {
        let y = self.state.position[1];
        for (kind, [x, z]) in steps {
            self.emit(kind, [x, y, z], [INHERITED; 3]);
        }
    }

    /// P lead, Z end, I crest less position, J first and K full depth, R degression, Q angle, H further finishing passes,
    /// E length of the slopes at the ends that L tells: 1 the start's, 2 the end's, 3 both. X stays the driving line.
    fn linuxcnc_thread(&mut self, request: &Request) {
        let across = |letter: u8| request.get(letter).map_or(f64::NAN, |value| value * self.state.modal.axis_mm(0));
        let (peak, first, full) = (across(b'I'), across(b'J'), across(b'K'));
        let ([x, _, z], (end, _)) = (self.state.position, self.target(request, false));
        let number = |letter: u8, without: f64| request.get(letter).unwrap_or(without);
        let times = number(b'H', 0.0).round().clamp(0.0, MOST as f64) as usize + 1;
        let found = depths(first, full, number(b'R', 1.0), 0.0, times).filter(|_| !peak.is_nan());
        let Some(depths) = found else { return self.refuse_thread() };
        let slant = number(b'Q', 0.0).to_radians().tan();
        let thread =
            Thread { start: [x, z], end: [x + peak, end[2]], taper: 0.0, inward: peak.signum(), depths, slant };
        let (ends, length) = (number(b'L', 0.0).round() as i64, number(b'E', 0.0) * self.state.modal.mm());
        self.lead_mm = request.get(b'P').map_or(f64::NAN, |lead| lead * self.state.modal.mm());
        let slopes = Slopes { at_start: ends & 1 == 1, at_end: ends & 2 == 2, length };
        self.emit_thread(thread.flank_steps(&slopes));
    }

    /// `P011060`: passes of full depth, pull-out, angle of the tool; Q least step, R allowance of the finishing pass.
    fn thread_data(&self, request: &Request) -> ThreadData {
        let before = self.state.thread;
        let packed = request.get(b'P').map(|p| p.round().clamp(0.0, 999_999.0) as usize);
        ThreadData {
            finishes: packed.map_or(before.finishes, |packed| (packed / 10_000).max(1)),
            angle: packed.map_or(before.angle, |packed| (packed % 100) as f64),
            least: self.stepped(request, b'Q').unwrap_or(before.least),
            allowance: request.get(b'R').map_or(before.allowance, |r| r * self.state.modal.mm()),
        }
    }

    /// A length that may be written as a number of least steps: mm.
    pub(crate) fn stepped(&self, request: &Request, letter: u8) -> Option<f64> {
        let value = request.get(letter)?;
        let step = if self.has_point(request.word(letter)) { 1.0 } else { STEP[usize::from(!self.state.modal.inch)] };
        Some(value * self.state.modal.mm() * step)
    }

    /// X, Z end at the root; R or I taper.
    fn macro_thread(&mut self, request: &Request, word: i32) {
        let ([x, _, z], (end, _)) = (self.state.position, self.target(request, false));
        let Some((height, angle, depths)) = self.macro_depths(request) else { return self.refuse_thread() };
        self.note_opaque(
            word,
            "where its passes begin and are pulled out is the control's; taken along the flank, square",
        );
        let taper = request.get(b'R').or(request.get(b'I')).unwrap_or(0.0) * self.state.modal.mm();
        let inward = (end[0] - x).signum();
        let (crest, slant) = (end[0] - inward * height, (angle / 2.0).to_radians().tan());
        let thread = Thread { start: [x, z], end: [crest, end[2]], taper, inward, depths, slant };
        self.lead_mm = f64::NAN;
        self.emit_thread(thread.square_steps());
    }

    /// Height, angle of the tool and depths. Fanuc: P height, Q depth of the first pass; Haas, in one block: K, D, A.
    fn macro_depths(&self, request: &Request) -> Option<(f64, f64, Vec<f64>)> {
        let one_block = request.any(b"K");
        let data = if one_block { ThreadData::NONE } else { self.state.thread };
        let (height, first, angle) = if one_block {
            let height = request.get(b'K')? * self.state.modal.mm();
            (height, self.stepped(request, b'D')?, request.get(b'A').unwrap_or(0.0))
        } else {
            (self.stepped(request, b'P')?, self.stepped(request, b'Q')?, data.angle)
        };
        let mut depths = depths(first, height - data.allowance, 2.0, data.least, 1).filter(|_| height >= first)?;
        let further = data.finishes - usize::from(data.allowance <= 0.0);
        depths.extend(std::iter::repeat_n(height, further));
        Some((height, angle, depths))
    }
}
