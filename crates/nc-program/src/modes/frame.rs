//! What a position is called: work offset, position register and tool offset over the machine position, mm.

use std::collections::BTreeMap;

use crate::dialect::FlowStyle;
use crate::finding::{self, Severity};
use crate::modes::linear::Linear;
use crate::modes::modal::Plane;
use crate::modes::request::Request;
use crate::modes::rotary::Rotary;
use crate::path::{Origin, INHERITED};
use crate::reading::number;
use crate::run::{Runner, AXES};

/// Number of G54.1 P1 less 1: no other work offset is as high.
const EXTENDED: f64 = 100.0;
/// Shifts that are put on and taken away again differ by less.
const SAME_MM: f64 = 1e-9;

/// Offsets in force. machine = program + work + register + tool.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// Work offsets by number, from 1; what is not there is zero. Those of G54.1 P1 … stand from `EXTENDED` on.
    pub work: BTreeMap<usize, [f64; 3]>,
    /// The one in force.
    pub active: usize,
    /// Offset made by setting the position register.
    pub register: [f64; 3],
    /// The part of it that shifts the work offset (G52, TRANS); the rest gives the tool's place a name (G92).
    pub shift: [f64; 3],
    /// Those of the other work offsets, where each has its own.
    pub shifts: BTreeMap<usize, [f64; 3]>,
    /// What additive shifts (ATRANS) have put on the offset of the last one (TRANS).
    pub fine: [f64; 3],
    /// By how much shifts have renamed the place of each axis since it last moved, mm.
    pub skipped: [f64; 3],
    /// The work offset in which each axis last moved; `None` before its first move.
    pub moved_in: [Option<usize>; 3],
    /// A register offset put aside.
    pub set_aside: ([f64; 3], [f64; 3]),
    /// Tool offset; zero where it is not known.
    pub tool: [f64; 3],
    /// It is known.
    pub tool_is_known: bool,
    /// The number by which it was called: H, or that of the tool; 0 for none.
    pub tool_number: i32,
    /// The control subtracts it: G44.
    pub tool_is_subtracted: bool,
    /// How often tool or work offsets came into force that each axis' position hangs on.
    pub renamed: [u32; 3],
    /// Stored machine positions.
    pub home: [[f64; 3]; 2],
    /// Where rotary axes stand.
    pub rotary: Rotary,
    /// What mirrors, what scales, what turns coordinates and what scales axes of their own, in this order from outside; the
    /// first alone where the program has one frame of its own.
    pub parts: [Option<Linear>; 4],
    /// All of it together: from the program's coordinates to those of the work offset.
    pub linear: Option<Linear>,
    /// Angles of work offsets that are turned themselves, degrees: their coordinates are the part's.
    pub angles: BTreeMap<usize, f64>,
    /// With these: from the program's coordinates to the machine's directions.
    pub whole: Option<Linear>,
}

impl Frame {
    /// The work offsets given, and no others. Of a control whose T brings an offset into force nobody knows which is,
    /// before the first.
    pub fn new(work: &[(usize, [f64; 3])], tool_is_known: bool) -> Self {
        Self {
            work: work.iter().copied().collect(),
            active: 1,
            register: [0.0; 3],
            shift: [0.0; 3],
            shifts: BTreeMap::new(),
            fine: [0.0; 3],
            skipped: [0.0; 3],
            moved_in: [None; 3],
            set_aside: ([0.0; 3], [0.0; 3]),
            tool: [0.0; 3],
            tool_is_known,
            tool_number: 0,
            tool_is_subtracted: false,
            renamed: [0; 3],
            home: [[0.0; 3]; 2],
            rotary: Rotary::default(),
            parts: [None; 4],
            linear: None,
            angles: BTreeMap::new(),
            whole: None,
        }
    }

    /// Works out how coordinates are turned. A work offset turns what the register adds, too.
    fn compose(&mut self) {
        let together = |outer: Linear, inner: Linear| outer.after(&inner);
        let own = self.angles.get(&self.active);
        let own = own.map(|angle| Linear::turn(Plane::Xy, *angle, self.register.map(|value| -value)));
        self.linear = self.parts.into_iter().flatten().reduce(together).and_then(Linear::unless_none);
        self.whole = own.into_iter().chain(self.linear).reduce(together).and_then(Linear::unless_none);
    }

    /// A position of the program in machine coordinates.
    pub fn machine(&self, position: [f64; 3]) -> [f64; 3] {
        let (placed, total) = (self.whole.map_or(position, |whole| whole.place(position)), self.total());
        [0, 1, 2].map(|axis| placed[axis] + total[axis])
    }

    /// The program's coordinates of a position that is the machine's but for what `total` adds.
    pub fn back(&self, placed: [f64; 3]) -> [f64; 3] {
        self.whole.map_or(placed, |whole| whole.inverse().place(placed))
    }

    /// Machine position minus program position.
    pub fn total(&self) -> [f64; 3] {
        let work = self.work.get(&self.active).copied().unwrap_or_default();
        [0, 1, 2].map(|axis| work[axis] + self.register[axis] + self.tool[axis])
    }

    /// What a move is noted with.
    pub fn origin(&self) -> Origin {
        let tool = self.tool_is_known.then_some(self.tool);
        Origin {
            total: self.total(),
            register: self.register,
            shift: self.shift,
            tool,
            tool_number: self.tool_number,
            tool_is_subtracted: self.tool_is_subtracted,
            renamed: self.renamed,
            turned: self.rotary.turned,
            rotary: self.rotary.stated(),
            linear: self.linear,
            is_turned: self.whole.is_some(),
        }
    }

    /// Positions along these axes are called otherwise from now on.
    pub(crate) fn rename(&mut self, axes: [bool; 3]) {
        self.renamed = [0, 1, 2].map(|axis| self.renamed[axis].wrapping_add(u32::from(axes[axis])));
    }
}

impl Runner<'_> {
    /// Changes what positions are called: the tool stays where it is.
    pub(crate) fn reframe(&mut self, change: impl FnOnce(&mut Frame)) {
        let (frame, position) = (&mut self.state.frame, self.state.position);
        let (before, linear, whole, tool) = (frame.total(), frame.linear, frame.whole, frame.tool);
        change(frame);
        frame.compose();
        let after = frame.total();
        let placed = whole.map_or(position, |whole| whole.place(position));
        self.state.position = frame.back([0, 1, 2].map(|axis| placed[axis] + before[axis] - after[axis]));
        if frame.linear == linear && frame.tool == tool {
            let skipped = frame.skipped;
            frame.skipped = [0, 1, 2].map(|axis| skipped[axis] + position[axis] - self.state.position[axis]);
        }
        if frame.linear != linear || frame.whole.map(|whole| whole.matrix) != whole.map(|whole| whole.matrix) {
            frame.rename(turned_axes([whole, linear], [frame.whole, frame.linear]));
            self.drop_contouring("the coordinates are turned, mirrored or scaled between its moves");
        }
    }

    /// The block's coordinates in mm, X a radius.
    pub(crate) fn given(&self, request: &Request) -> [Option<f64>; 3] {
        [0, 1, 2].map(|axis| request.get(AXES[axis]).map(|value| value * self.state.modal.axis_mm(axis)))
    }

    /// G92: the present position gets the values given.
    pub(crate) fn set_register(&mut self, request: &Request) {
        if self.dialect_increments().is_some_and(|letters| request.any(&letters)) {
            let message = "a shift of the position register by increments is not followed".into();
            self.warn(finding::OPAQUE, self.block_start(), message, "set it by X and Z");
        }
        let (given, position) = (self.given(request), self.state.position);
        let named = [0, 1, 2].map(|axis| given[axis].unwrap_or(position[axis]));
        self.reframe(|frame| {
            frame.register = [0, 1, 2].map(|axis| frame.register[axis] + position[axis] - named[axis]);
            frame.set_aside = (frame.register, frame.shift);
        });
        self.state.position = named; // exactly, without the rounding of the difference
    }

    /// G52: the offset gets the values given, whatever the present position.
    pub(crate) fn offset_register(&mut self, given: [Option<f64>; 3], request: &Request) {
        let adds = [0, 1, 2].map(|axis| request.reference(AXES[axis]) == Some(true));
        self.reframe(|frame| {
            let before = |axis: usize| if adds[axis] { frame.register[axis] } else { 0.0 };
            let before_shift = |axis: usize| if adds[axis] { frame.shift[axis] } else { 0.0 };
            frame.shift =
                [0, 1, 2].map(|axis| given[axis].map_or(frame.shift[axis], |value| before_shift(axis) + value));
            frame.register =
                [0, 1, 2].map(|axis| given[axis].map_or(frame.register[axis], |value| before(axis) + value));
            frame.set_aside = (frame.register, frame.shift);
        });
    }

    /// TRANS: the offset of every axis gets the values given, zero without one. ATRANS: it is increased by them.
    pub(crate) fn shift(&mut self, request: &Request, adds: bool) {
        let given = [0, 1, 2].map(|axis| request.get(AXES[axis]).unwrap_or(0.0) * self.state.modal.mm());
        if self.state.modal.diameter && given[0] != 0.0 {
            let message = "X of the shift is taken as a radius, as controls do unless their machine data say otherwise";
            self.report(
                Severity::Note,
                finding::OPAQUE,
                self.block_start(),
                message.into(),
                "write X0, or try it on air",
            );
        }
        let kept = if adds { [0.0; 3] } else { self.kept_fine(request) };
        if !adds && self.state.frame.parts[0].is_some() && self.refuses_new_frame(INHERITED) {
            return;
        }
        self.reframe(|frame| {
            let given = frame.linear.filter(|_| adds).map_or(given, |linear| linear.vector(given));
            let before = if adds { frame.register } else { kept };
            frame.fine = if adds { [0, 1, 2].map(|axis| frame.fine[axis] + given[axis]) } else { kept };
            frame.register = [0, 1, 2].map(|axis| before[axis] + given[axis]);
            frame.shift = frame.register; // G92 is not of such a control
            frame.set_aside = (frame.register, frame.shift);
            if !adds {
                frame.parts = [None; 4];
            }
        });
    }

    /// What a shift leaves of the additive ones before it: by a parameter of the machine. Without axes it leaves nothing.
    fn kept_fine(&mut self, request: &Request) -> [f64; 3] {
        let fine = self.state.frame.fine;
        let Some(parameter) = self.program.dialect().rules.kept_fine.filter(|_| fine != [0.0; 3] && request.any(&AXES))
        else {
            return [0.0; 3];
        };
        let word = AXES.iter().map(|letter| request.word(*letter)).find(|word| *word >= 0).unwrap_or(-1);
        let what = "the shift takes away what was added to the one before, or leaves it";
        match self.ask(parameter, Severity::Error, word, what) {
            Some(value) if value != 0.0 => fine,
            _ => [0.0; 3],
        }
    }

    /// What an increment of an axis goes further by, mm: a shift that came since it last moved. By a parameter of the
    /// machine, of which the value it is delivered with is taken where it is not given.
    pub(crate) fn skipped_shift(&mut self, axis: usize) -> f64 {
        let Some(parameter) = self.program.dialect().rules.skipped_shift else { return 0.0 };
        let Frame { active, skipped, moved_in, .. } = &self.state.frame;
        let skipped = skipped[axis];
        if skipped.abs() < SAME_MM && moved_in[axis].is_none_or(|offset| offset == *active) {
            return 0.0;
        }
        let word = self.program.words_of(self.block).iter().position(|word| word.letter == AXES[axis]);
        let word = word.map_or(INHERITED, |at| (self.program.word_range(self.block).start + at) as i32);
        let what = "the increment goes by the shift that came since the axis moved, too, or not";
        match self.ask(parameter, Severity::Error, word, what) {
            Some(0.0) => 0.0,
            _ => skipped,
        }
    }

    /// These axes move: no shift waits for them.
    pub(crate) fn settle_shift(&mut self, words: [i32; 3]) {
        let frame = &mut self.state.frame;
        for axis in (0..3).filter(|axis| words[*axis] >= 0) {
            (frame.skipped[axis], frame.moved_in[axis]) = (0.0, Some(frame.active));
        }
    }

    pub(crate) fn cancel_register(&mut self, forget: bool) {
        self.reframe(|frame| {
            frame.set_aside = if forget { ([0.0; 3], [0.0; 3]) } else { (frame.register, frame.shift) };
            (frame.register, frame.shift) = ([0.0; 3], [0.0; 3]);
        });
    }

    /// G10: L2 sets a work offset, L20 so that the present position gets the values given.
    pub(crate) fn set_data(&mut self, request: &Request) {
        let level = request.get(b'L').unwrap_or(0.0).round() as i64;
        let system = match request.get(b'P').unwrap_or(0.0).round() as i64 {
            0 => self.state.frame.active,
            number => usize::try_from(number).unwrap_or(usize::MAX),
        };
        let angle = request.get(b'R');
        let turned = angle.is_some() || self.state.frame.angles.contains_key(&system);
        if !matches!(level, 2 | 20) || !(1..=9).contains(&system) || level == 20 && turned {
            let message = format!("G10 L{level}: only work offsets are followed, with L20 those that are not turned");
            let hint = "the path is given as if this block were not there";
            return self.warn(finding::OPAQUE, self.block_start(), message, hint);
        }
        if angle.is_some() && self.refuses_new_frame(request.word(b'R')) {
            return;
        }
        let (given, position, total) = (self.given(request), self.state.position, self.state.frame.total());
        let adds = self.state.modal.incremental && self.program.dialect().flow == FlowStyle::Macro;
        self.reframe(|frame| {
            let before = if adds { *frame.work.entry(system).or_default() } else { [0.0; 3] };
            let others = [0, 1, 2].map(|axis| frame.register[axis] + frame.tool[axis]);
            if let Some(angle) = angle {
                frame.angles.insert(system, angle);
            }
            let offsets = frame.work.entry(system).or_default();
            *offsets = [0, 1, 2].map(|axis| match given[axis] {
                Some(value) if level == 2 => before[axis] + value,
                Some(value) => position[axis] + total[axis] - others[axis] - value,
                None => offsets[axis],
            });
        });
    }

    /// G10 of controls where only L2 with P1 to P6 sets a work offset, and adds to it under G91.
    pub(crate) fn set_work_offset(&mut self, request: &Request) {
        let increments = self.dialect_increments().is_some_and(|letters| request.any(&letters)) || request.any(b"R");
        let known = request.get(b'L') == Some(2.0) && request.get(b'P').is_some_and(|p| (1.0..=6.0).contains(&p));
        if known && !increments {
            return self.set_data(request);
        }
        let of_tool = request.get(b'L').filter(|level| (10.0..=13.0).contains(level) && !self.state.modal.diameter);
        if of_tool.is_some() && request.any(b"P") && request.any(b"R") && !request.any(b"XYZ") {
            self.note_opaque(request.word(b'L'), "an offset of the tool table is set, which is taken as zero");
            let third = self.state.modal.plane.axes().2;
            return self.state.frame.rename([0, 1, 2].map(|axis| axis == third && of_tool < Some(12.0)));
        }
        let message = "G10: only L2 with P1 to P6 and the words of X, Y and Z is followed".into();
        let hint = "the path is given as if this block were not there";
        self.warn(finding::OPAQUE, self.block_start(), message, hint);
    }

    /// Stores where the tool is.
    pub(crate) fn store_home(&mut self, number: usize) {
        let machine = self.state.frame.machine(self.state.position);
        if let Some(home) = self.state.frame.home.get_mut(number) {
            *home = machine;
        }
    }

    /// G54.1 P1 …: a work offset of the further ones.
    pub(crate) fn extended_offset(&mut self, request: &Request, word: i32) {
        let Some(number) = request.get(b'P').filter(|number| (1.0..=300.0).contains(number)) else {
            let message = format!("{} without P1 to P300", self.word_text(word));
            return self.warn(finding::MISPLACED, self.word_start(word), message, "name the offset: G54.1 P1");
        };
        self.use_offset((EXTENDED + number.round()) as u16);
    }

    /// CYCL DEF 247: the preset of Q339, which stands in the same line or the next one.
    pub(crate) fn use_preset(&mut self, word: i32) {
        let (start, blocks) = (self.word_start(word), self.program.blocks());
        let end = blocks.get(self.block + 1).or(blocks.get(self.block)).map_or(start, |block| block.end as usize);
        let text = self.program.source().get(start..end).unwrap_or(&[]);
        let at = text.windows(5).position(|window| window == b"Q339=").map(|at| at + 5);
        let number = at.and_then(|at| number::read(text, at)).filter(|(value, _)| (0.0..=9999.0).contains(value));
        match number {
            Some((value, _)) => self.use_offset(value.max(1.0) as u16),
            None => self.unfollowed(word),
        }
    }

    /// G54 …, and a preset, be it the one in force already: what it leaves of turns is left to the control. In Klartext
    /// it takes a datum shift back.
    pub(crate) fn use_offset(&mut self, number: u16) {
        if self.is_turned() {
            return;
        }
        if self.program.dialect().flow == FlowStyle::Labels {
            self.reframe(|frame| (frame.register, frame.shift, frame.set_aside) = Default::default());
        }
        self.state.modal.work_offset = number;
        let number = usize::from(number);
        if number != self.state.frame.active {
            self.state.frame.rename([true; 3]);
        }
        let each = self.program.dialect().rules.shift_of_each_offset;
        self.reframe(|frame| {
            let left = std::mem::replace(&mut frame.active, number);
            if each {
                frame.shifts.insert(left, frame.shift);
                let own = frame.shifts.get(&number).copied().unwrap_or_default();
                frame.register = [0, 1, 2].map(|axis| frame.register[axis] + own[axis] - frame.shift[axis]);
                frame.shift = own;
            }
        });
    }
}

/// The axes whose coordinates differ between two frames: their directions on the machine, and where they begin.
fn turned_axes(before: [Option<Linear>; 2], after: [Option<Linear>; 2]) -> [bool; 3] {
    let none = Linear::scaled([1.0; 3], [0.0; 3]);
    let [before, after] = [before, after].map(|frame| frame.map(|linear| linear.unwrap_or(none)));
    [0, 1, 2]
        .map(|axis| before[0].matrix[axis] != after[0].matrix[axis] || before[1].shift[axis] != after[1].shift[axis])
}
