//! Threading cycles (G76): what their words say, of LinuxCNC and of Fanuc and Haas lathes.

use crate::dialect::FlowStyle;
use crate::finding;
use crate::modes::request::Request;
use crate::path::MoveKind;
use crate::run::Runner;
use crate::turning::thread::{depths, Slopes, Thread, MOST};

/// Lengths of Fanuc's G76 that take no decimal point count such steps: inch and mm.
const STEP: [f64; 2] = [1e-4, 1e-3];

/// Leads that a step of the pull-out in P is.
const PULL_OUT: f64 = 0.1;

/// Angles of a tool, in degrees, that are no point.
const STRAIGHT: f64 = 180.0;

/// Depths that differ by less, in mm, are the same.
const SAME: f64 = 1e-9;

/// What Fanuc's first block of two says, for those that follow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThreadData {
    finishes: usize,
    /// Length of the slope at the end, in leads; without it a parameter of the control.
    pull_out: Option<f64>,
    angle: f64,
    least: f64,
    allowance: f64,
}

impl ThreadData {
    pub const NONE: Self = Self { finishes: 1, pull_out: None, angle: 0.0, least: 0.0, allowance: 0.0 };
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

    fn emit_thread(&mut self, steps: Vec<(MoveKind, [f64; 2])>, words: [i32; 3], to: [f64; 3]) {
        let y = self.state.position[1];
        self.emit_turned(steps.into_iter().map(|(kind, [x, z])| (kind, [x, y, z])), words, to);
    }

    /// P lead, Z end, I crest less position, J first and K full depth, R degression, Q angle, H further finishing passes,
    /// E length of the slopes at the ends that L tells: 1 the start's, 2 the end's, 3 both. X stays the driving line.
    fn linuxcnc_thread(&mut self, request: &Request) {
        let across = |letter: u8| request.get(letter).map_or(f64::NAN, |value| value * self.state.modal.axis_mm(0));
        let (peak, first, full) = (across(b'I'), across(b'J'), across(b'K'));
        let ([x, _, z], (end, words)) = (self.state.position, self.target(request, false));
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
        self.emit_thread(thread.flank_steps(&slopes), words, end);
    }

    /// `P011060`: passes of full depth, pull-out, angle of the tool; Q least step, R allowance of the finishing pass.
    fn thread_data(&self, request: &Request) -> ThreadData {
        let before = self.state.thread;
        let packed = request.get(b'P').map(|p| p.round().clamp(0.0, 999_999.0) as usize);
        ThreadData {
            finishes: packed.map_or(before.finishes, |packed| (packed / 10_000).max(1)),
            pull_out: packed.map(|packed| (packed / 100 % 100) as f64 * PULL_OUT).or(before.pull_out),
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

    /// X, Z end at the root; R or I taper: radius where the thread begins, less that where it ends.
    fn macro_thread(&mut self, request: &Request, word: i32) {
        let ([x, _, z], (end, words)) = (self.state.position, self.target(request, false));
        let Some(said) = self.said(request).filter(|_| end[0] != x && end[2] != z) else {
            return self.refuse_thread();
        };
        if let Some(taken) = said.taken() {
            self.note_opaque(word, &taken);
        }
        let taper = request.get(b'R').or(request.get(b'I')).unwrap_or(0.0) * self.state.modal.mm();
        let inward = (end[0] - x).signum();
        let (crest, slant) = (end[0] - inward * said.height, said.slant());
        let pull_out = said.pull_out.map_or(0.0, |leads| leads * self.state.modal.feed.max(0.0));
        let thread = Thread { start: [x, z], end: [crest, end[2]], taper, inward, depths: said.depths, slant };
        self.lead_mm = f64::NAN;
        self.emit_thread(thread.square_steps(pull_out), words, end);
    }

    fn said(&self, request: &Request) -> Option<Said> {
        let said = if request.any(b"K") { self.one_block(request) } else { self.two_blocks(request) };
        said.filter(|said| said.angle.abs() < STRAIGHT)
    }

    /// Fanuc: P height, Q depth of the first pass, the rest in the block before.
    fn two_blocks(&self, request: &Request) -> Option<Said> {
        let data = self.state.thread;
        let (height, first) = (self.stepped(request, b'P')?, self.stepped(request, b'Q')?);
        let roughed = height - data.allowance;
        if !(data.allowance >= 0.0 && roughed > 0.0 && height >= first) {
            return None;
        }
        let mut depths = macro_depths(first, roughed, 2.0, data.least)?;
        let further = data.finishes - usize::from(data.allowance == 0.0);
        depths.extend(std::iter::repeat_n(height, further));
        Some(Said { height, angle: data.angle, depths, pull_out: data.pull_out, one_block: false, both: false })
    }

    /// Haas, and Fanuc in one block: K height, D depth of the first pass, A angle; P 1 and 2 a constant area, 3 and 4 a
    /// constant depth, cut on one flank (1, 3) or on both in turn (2, 4).
    fn one_block(&self, request: &Request) -> Option<Said> {
        let height = request.get(b'K')? * self.state.modal.mm();
        let method = request.get(b'P').map_or(1, |p| p.round() as i64);
        let degression = if method >= 3 { 1.0 } else { 2.0 };
        let first = self.stepped(request, b'D').filter(|first| (1..=4).contains(&method) && height >= *first)?;
        let angle = request.get(b'A').unwrap_or(0.0);
        let depths = macro_depths(first, height, degression, 0.0)?;
        Some(Said { height, angle, depths, pull_out: None, one_block: true, both: method % 2 == 0 })
    }
}

/// Depths up to the full one, which is cut once.
fn macro_depths(first: f64, full: f64, degression: f64, least: f64) -> Option<Vec<f64>> {
    let mut found = depths(first, full, degression, least, 1)?;
    // Rounding must not make a further pass where one comes out at the full depth.
    found.dedup_by(|after, before| (*after - *before).abs() < SAME);
    Some(found)
}

/// What the words of a thread say: mm, degrees.
struct Said {
    height: f64,
    angle: f64,
    depths: Vec<f64>,
    pull_out: Option<f64>,
    /// The least step and what is left for finishing are settings of the control.
    one_block: bool,
    /// The passes go in along one flank and the other in turn.
    both: bool,
}

impl Said {
    /// Tangent of the angle at which the passes go in.
    fn slant(&self) -> f64 {
        if self.both {
            0.0
        } else {
            (self.angle / 2.0).to_radians().tan()
        }
    }

    /// What is taken where the words leave it to the control.
    fn taken(&self) -> Option<String> {
        let parts = [
            (self.slant() != 0.0, "where its passes begin along Z, taken along the flank"),
            (self.both, "how they go in on both flanks, taken straight in"),
            (self.pull_out.is_none(), "how it is pulled out, taken as square"),
            (self.one_block, "the least step and what is left for finishing, taken as none"),
        ];
        let left: Vec<_> = parts.into_iter().filter(|(left, _)| *left).map(|(_, what)| what).collect();
        (!left.is_empty()).then(|| format!("left to the control: {}", left.join("; ")))
    }
}
