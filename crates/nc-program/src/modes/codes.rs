//! Codes: what a block changes of the modal state, and what it does besides.

use crate::dialect::{FlowStyle, ToolOffset, G};
use crate::drilling::drill::Drill;
use crate::drilling::hole::Hole;
use crate::finding::{self, Severity, Unseen};
use crate::modes::modal::{Compensation, FeedMode, FeedUnit, Motion, Plane};
use crate::modes::request::{Jump, Request};
use crate::modes::tool::{Called, NONE_CALLED};
use crate::modes::turned_frame::{SCALES, TURNS};
use crate::path::INHERITED;
use crate::reading::program::Word;
use crate::run::Runner;
use crate::shapes::spline::Spline;
use crate::values::parameters::Key;

/// Address of a feed that holds for its block alone.
const BLOCK_FEED: u8 = b'b';

/// What a block does besides setting modes: the code that makes something of its coordinates; `Inert` where they are a move.
pub(crate) type Action = G;

/// Whether a code makes something of its block's coordinates; the others leave them to be a move.
pub(crate) fn acts(code: G) -> bool {
    is_idle(code)
        || to_machine(code)
        || is_frame(code)
        || is_cycle(code)
        || matches!(code, G::DiameterByWord | G::EndSpline)
}

/// Whether nothing moves for a code, nor is anything renamed.
pub(crate) fn is_idle(code: G) -> bool {
    matches!(
        code,
        G::Procedure | G::DefineCycle(_) | G::CycleLine | G::SystemData | G::Probe | G::Dwell | G::StoreHome(_)
    ) || matches!(
        code,
        G::OpaqueCycle
            | G::OpaqueBlock
            | G::OpaqueCut
            | G::Continued
            | G::GoToName
            | G::OpaqueMode
            | G::Setting(..)
            | G::ToleranceCycle
    ) || matches!(code, G::Preset | G::Turn | G::TurnAnew | G::DefineTool | G::Limits)
}

/// Whether a code sets a frame.
pub(crate) fn is_frame(code: G) -> bool {
    matches!(
        code,
        G::SetRegister
            | G::OffsetRegister
            | G::ResetDatum
            | G::Shift(_)
            | G::Pole(_)
            | G::CancelRegister(_)
            | G::RestoreRegister
    ) || matches!(code, G::SetData | G::SetWorkOffset | G::ToolOffset | G::Rotate | G::Scale)
        || matches!(code, G::Mirror(_) | G::EndMirror)
}

/// Whether a code goes to a place of the machine, by positions or by none.
pub(crate) fn to_machine(code: G) -> bool {
    in_machine(code) || matches!(code, G::Home(_) | G::HomeNamed(_) | G::Retract | G::FixedPoint | G::Swivel)
}

fn in_machine(code: G) -> bool {
    matches!(code, G::MachineCoordinates | G::BuilderCoordinates)
}

/// Whether a code is a cycle or a call of its own.
fn is_cycle(code: G) -> bool {
    matches!(code, G::FinishContour | G::RoughContour(_) | G::TurningCycle | G::Thread | G::Groove(_) | G::Profile(_))
        || matches!(code, G::OwnCycle | G::CirclePocket)
        || matches!(
            code,
            G::Lap(_)
                | G::Removal(_)
                | G::HoleCycle(_)
                | G::ModalCycle
                | G::CallCycle
                | G::CallCycleAt
                | G::CallPattern
        )
        || matches!(code, G::Pattern(_) | G::MillPocket(_) | G::CallMacro | G::ModalMacro | G::Leave(false))
}

impl Runner<'_> {
    /// Does what the block asks for: modes first, then feed, speed and tool, then parameters, then its action.
    pub(crate) fn execute(&mut self, request: &mut Request) {
        if request.codes().len() > 1 {
            self.check_groups(request);
            self.check_claims(request);
        }
        if !request.pointless.is_empty() {
            self.count_steps(request);
        }
        if self.program.dialect().about_pole {
            self.state.modal.motion = Motion::Line; // `X+50 F100`: no function of a block stays in force
        }
        let (action, word) = self.apply_codes(request);
        if !self.state.unit.is_used {
            self.look_for_lengths(request, action);
        }
        if !matches!(action, G::CallMacro | G::ModalMacro) {
            self.check_sign(request);
            self.apply_feed_speed_tool(request, action);
        }
        if action != G::TurningCycle {
            for (key, value) in request.assignments.drain(..) {
                self.state.store.set(key, value);
            }
        }
        if matches!(action, G::Inert) {
            self.plain_corner(request);
        }
        let turns = self.turn(request, action);
        if to_machine(action) {
            self.check_turned_way(request);
        }
        match action {
            G::Inert | G::MachineCoordinates | G::BuilderCoordinates => {
                let before = self.path.len();
                let feed = self.state.modal.feed;
                if let Some(own) = request.get(BLOCK_FEED) {
                    self.state.modal.feed = self.feed_mm(request, own);
                }
                let across = self.state.modal.plane;
                self.state.modal.plane = self.plane_of(request);
                self.motion(request, in_machine(action));
                self.state.modal.plane = across;
                if request.any(&[BLOCK_FEED]) {
                    self.state.modal.feed = feed;
                }
                self.ask_corner(request);
                if self.path.len() > before {
                    self.call_modal_macro();
                }
                self.call_cycle(request, self.path.len() > before);
            }
            G::DiameterByWord => self.diameter_by_word(request),
            G::Leave(_) => self.leave_contour(word),
            G::Rotate => self.rotate(request, word),
            G::Scale => self.scale(request, word),
            G::Mirror(at_zero) => self.mirror(request, at_zero, word),
            G::EndMirror => self.end_mirror(request, word),
            G::SetRegister | G::OffsetRegister | G::ResetDatum | G::SetWorkOffset if self.is_turned() => {}
            G::SetRegister => self.set_register(request),
            G::OffsetRegister => self.offset_register(self.given(request), request),
            G::ResetDatum => self.offset_register([Some(0.0); 3], request),
            G::Pole(from) => self.set_pole(request, from),
            G::Shift(adds) => self.shift(request, adds),
            G::CancelRegister(forget) => self.cancel_register(forget),
            G::RestoreRegister => self.reframe(|frame| (frame.register, frame.shift) = frame.set_aside),
            G::SetData => self.set_data(request),
            G::SetWorkOffset => self.set_work_offset(request),
            G::ToolOffset => self.tool_offset(request),
            G::Home(number) => self.home(request, usize::from(number)),
            G::HomeNamed(number) => self.home_named(request, usize::from(number), word),
            G::Retract => self.retract(request, word),
            G::FixedPoint => self.fixed_point(request, word),
            G::Swivel => self.swivel(word),
            G::FinishContour => self.finish_contour(request, word),
            G::RoughContour(rough) => self.rough_contour(request, rough, word),
            G::TurningCycle => self.turning_cycle(request),
            G::CallMacro => self.call_macro(request, word),
            G::ModalMacro => self.set_modal_macro(request, word),
            G::OwnCycle => self.own_cycle(request, word),
            G::CirclePocket => self.circle_pocket(request, word),
            G::GoToName => self.go_to_name(word),
            G::Groove(deep) => self.groove(request, usize::from(deep), word),
            G::EndSpline => self.spline(request, Spline::End),
            G::Profile(profile) => self.profile_cycle(request, profile, word),
            G::Lap(lap) => self.lap(request, lap, word),
            G::Removal(removal) => self.removal(removal, word),
            G::HoleCycle(drill) => self.cycle_here(drill, word),
            G::MillPocket(pocket) => self.mill_pocket(pocket, word),
            G::ModalCycle => self.modal_cycle(word),
            G::CallCycle => self.call_defined(word),
            G::CallCycleAt => self.call_at(request, word),
            G::CallPattern => self.call_pattern(word),
            G::Pattern(pattern) => self.pattern(pattern, word),
            G::Thread => self.thread_cycle(request, word),
            _ => {}
        }
        if turns {
            self.state.frame.rotary.settle();
        }
        self.jump(request);
    }

    fn apply_codes(&mut self, request: &Request) -> (Action, i32) {
        let mut action = (G::Inert, INHERITED);
        for (code, word) in request.codes() {
            let code = &if self.names_further_offset(request, *code) { G::ExtendedOffset } else { *code };
            if let G::Compensation(side) | G::CompensationGiven(side) = *code {
                self.compensate(request, side, *code == G::CompensationGiven(side), *word as i32);
            }
            if let G::Leave(_) = *code {
                self.compensate(request, Compensation::Off, false, *word as i32);
            }
            match *code {
                G::Dwell => {
                    self.check_dwell(request);
                    self.dwell(request);
                }
                G::Pause => self.dwell(request),
                G::ExtendedOffset => self.extended_offset(request, *word as i32),
                G::Setting(letter, known) => self.setting(request, letter, known, *word as i32),
                G::ToolTableOffset(adds) => self.length_offset(request, adds, *word as i32),
                _ => {}
            }
            if self.apply_code(*code, *word as i32) {
                action = (*code, *word as i32);
            }
        }
        action
    }

    /// G40, G41, G42: the tool is that of D, else the one in use.
    pub(crate) fn compensate(&mut self, request: &Request, side: Compensation, given: bool, word: i32) {
        self.state.switched |= (side == Compensation::Off) != (self.state.modal.compensation == Compensation::Off);
        self.state.modal.compensation = side;
        if side == Compensation::Off {
            self.state.modal.called = NONE_CALLED;
            return;
        }
        let mm = self.state.modal.mm();
        let of_tool = self.program.dialect().flow == FlowStyle::Structured; // D is an edge of the tool in use
        let named = request.get(b'D').or(self.state.radius_called).filter(|_| !of_tool);
        let number = named.unwrap_or(f64::from(self.tool_in_use()));
        let edge = matches!(self.program.dialect().tool_offset, ToolOffset::Edge(_)).then_some(self.state.edge.0);
        // T0100 cancels the offset of a lathe's tool; before any T word that of the tool called by hand is in force.
        let unknown = named.is_none() && self.tool_called() < 0 && self.state.modal.plane == Plane::Zx;
        let none = number == 0.0 && self.program.dialect().flow == FlowStyle::Macro && !unknown;
        let cancelled = none || edge == Some(0);
        self.state.modal.called = Called {
            number: number.round() as i32,
            radius: if given {
                number * mm / 2.0
            } else if cancelled {
                0.0
            } else {
                -1.0
            },
            tip: request.get(b'L').filter(|_| given).map_or(0, |tip| tip.round() as u8),
            edge,
            oversize: self.state.oversize,
        };
        if self.options.tools.is_empty() {
            self.note_opaque(word, "the path is the programmed contour, not that of the tool's centre");
        }
    }

    /// Number of the tool in the spindle; on a lathe with offsets in T, of the offset.
    pub(crate) fn tool_in_use(&self) -> i32 {
        let called = self.tool_called().max(0);
        if self.program.dialect().tool_offset == ToolOffset::InT {
            called % 100
        } else {
            called
        }
    }

    /// Sets the modes of a code; whether it makes something of its block's coordinates.
    fn apply_code(&mut self, code: G, word: i32) -> bool {
        let modal = &mut self.state.modal;
        match code {
            G::Motion(motion) => modal.motion = motion,
            G::Heading => {
                let inch = self.whole_text(word).ends_with("INCH");
                self.state_unit(inch, word);
            }
            G::ContourLabels => self.name_contours(word),
            G::DefinePattern => self.define_pattern(word),
            G::CallFile => self.call_file(word),
            G::EndFile => self.end_file(),
            G::Fast if modal.motion == Motion::Line => modal.motion = Motion::Rapid,
            G::FeedOfTool => {
                if std::mem::take(&mut self.state.feed_by_revolution) {
                    self.set_feed_mode(FeedMode::PerMinute);
                }
                let is_known = self.state.modal.feed_mode == FeedMode::PerMinute;
                self.state.modal.feed = if is_known { self.state.tool_feed } else { -1.0 };
            }
            G::Drill(drill) => self.start_holes(drill, None, word),
            G::DrillAlong(drill, axis) => self.start_holes(drill, Some(usize::from(axis)), word),
            G::Pass(pass) => {
                modal.motion = Motion::Pass;
                self.start_passes(pass, word);
            }
            G::RetractToPlane(plane) => self.state.retracts_to_plane = plane,
            G::NoMotion | G::EndSpline => modal.motion = Motion::None,
            G::EndCycle if matches!(modal.motion, Motion::Drill | Motion::Opaque) => {
                modal.motion = self.state.under_cycle
            }
            G::EndModalMacro => self.end_modal_macro(word),
            G::Polar(polar) => self.state.polar = polar,
            G::EndRotation => self.set_part(TURNS, None, word),
            G::EndScale => self.set_part(SCALES, None, word),
            G::Plane(plane) => {
                if modal.plane != plane {
                    self.state.polar_said = [f64::NAN; 2];
                }
                (modal.plane, self.state.pole_plane) = (plane, plane);
                self.state.xy_is_stated |= plane == Plane::Xy;
            }
            G::Inch(inch) => {
                self.state_unit(inch, word);
                self.state.modal.feed_unit = FeedUnit::OfLengths;
            }
            G::LengthsInch(inch) => {
                self.state_unit(inch, word);
                self.state.modal.feed_unit = self.feed_unit_beside(inch);
            }
            G::Incremental(incremental) => modal.incremental = incremental,
            G::CentreAbsolute(absolute) => modal.centre_absolute = absolute,
            G::Diameter(diameter) => {
                (modal.diameter, modal.radius_increments) = (diameter, false);
                self.state.diameter_is_known = true;
            }
            G::DiameterOfPositions => {
                (modal.diameter, modal.radius_increments) = (true, true);
                self.state.diameter_is_known = true;
            }
            G::Feed(mode) => self.set_feed_mode(mode),
            G::Spindle(mode) => modal.spindle_mode = mode,
            G::SpeedAndFeed(mode, feed) => {
                modal.spindle_mode = mode;
                self.set_feed_mode(feed);
            }
            G::SteadyFeed(steady) => {
                self.state.steady_feed = steady;
                if !steady {
                    self.note_opaque(word, "the feed changes along the path: it is not given");
                }
            }
            G::Procedure => self.enter_procedure(word),
            G::WorkOffset(number) => self.use_offset(number),
            G::StoreHome(number) => self.store_home(usize::from(number)),
            G::NoToolOffset => self.cancel_tool_offset(),
            G::OpaqueCycle => {
                modal.motion = Motion::None;
                self.note_unseen(word, Unseen::Moves, "the cycle's own moves are not in the path");
            }
            G::OpaqueMotion => {
                self.keep_under_cycle();
                self.state.modal.motion = Motion::Opaque;
            }
            G::DefineCycle(cycle) => self.define_cycle(cycle, word),
            G::CycleLine => self.cycle_line(word),
            G::CallCycleAt => modal.motion = Motion::Line,
            G::Approach | G::Leave(true) => {
                modal.motion = Motion::Line;
                let message =
                    format!("{}: the way to or from the contour is drawn as a straight line", self.word_text(word));
                let hint = "the point that it names is displaced by a correction; the way to it is the control's";
                self.report(Severity::Note, finding::OPAQUE, self.word_start(word), message, hint);
            }
            G::SystemData => self.forget_read(word),
            G::Probe => self.probe_cycle(word),
            G::OpaqueBlock | G::OpaqueCut => self.note_unseen(word, Unseen::Block, "what it does is not in the path"),
            G::Continued => self.continued(word),
            G::OpaqueMode => self.unfollowed(word),
            G::Turn | G::TurnAnew => self.turn_frame(code == G::TurnAnew, word),
            G::DefineTool => self.define_tool(word),
            G::ToleranceCycle => self.tolerance_cycle(word),
            G::Preset => self.use_preset(word),
            G::BuilderCoordinates => {
                self.note_opaque(
                    word,
                    "a place counted from a point of the machine's builder, taken as the machine's zero",
                );
            }
            _ => {}
        }
        let beside_move = code == G::OpaqueMode && self.program.dialect().flow == FlowStyle::Labels; // M128
        acts(code) && !beside_move
    }

    /// TCH PROBE.
    fn probe_cycle(&mut self, word: i32) {
        let text = self.word_text(word).to_ascii_uppercase();
        let digits: String =
            text.chars().skip_while(|c| !c.is_ascii_digit()).take_while(char::is_ascii_digit).collect();
        if !matches!(digits.parse(), Ok(400_u32..=405 | 408..=431 | 480..=484)) {
            return self.warn_unseen(word, Unseen::Block, "what it does is not in the path");
        }
        self.touched(word, 150..200);
    }

    /// Touches: what a position is called after them, and parameters of those numbers, only the control knows.
    pub(crate) fn touched(&mut self, word: i32, results: std::ops::Range<u32>) {
        self.note_unseen(word, Unseen::Touches, "its touches are not in the path, what they set is the control's");
        results.for_each(|number| self.state.store.forget(&Key::Number(number)));
        self.drop_contouring("a probe cycle comes after it");
        self.state.frame.rename([true; 3]);
    }

    /// FN 18: the parameter that it names has no value that the program gives; one that was given for it stays.
    fn forget_read(&mut self, word: i32) {
        let text = self.word_text(word).to_ascii_uppercase();
        let digits = text.split_once("SYSREAD").map_or("", |(_, rest)| rest.trim_start().trim_start_matches('Q'));
        let digits: String = digits.chars().take_while(char::is_ascii_digit).collect();
        let Some(key) = digits.parse().ok().map(Key::Number) else {
            return self.note_opaque(word, "what it reads is not known");
        };
        match self.options.parameters.iter().find(|(given, _)| *given == key) {
            Some((_, value)) => self.state.store.set(key, *value),
            None => self.state.store.forget(&key),
        }
    }

    /// A drilling cycle comes into force; one that follows another goes on with its series.
    fn start_holes(&mut self, drill: Drill, along: Option<usize>, word: i32) {
        self.keep_under_cycle();
        let third = along.unwrap_or(self.state.modal.plane.axes().2);
        let goes_on = self.state.hole.filter(|_| self.state.modal.motion == Motion::Drill);
        let initial = goes_on.map_or(self.state.position[third], |hole| hole.initial);
        // Z, R, Q and P hold until G80; on LinuxCNC until another cycle.
        let holds = self.program.dialect().flow == FlowStyle::Macro;
        let same = goes_on.filter(|hole| hole.along == along && (hole.drill == drill || holds));
        let dwells = self.dwells_at_bottom(word);
        let same = same.map(|hole| if holds { Hole { drill, dwells, ..hole } } else { hole });
        let last = self.state.hole.map_or(0, |hole| hole.series);
        let series = if goes_on.is_some() { last } else { last + 1 };
        let new = || Hole::new(drill, along, dwells, initial, series);
        self.state.hole = Some(same.unwrap_or_else(new));
        self.state.modal.motion = Motion::Drill;
    }

    /// The motion in force stays so under a cycle, and comes back when it ends.
    fn keep_under_cycle(&mut self) {
        let motion = self.state.modal.motion;
        if !matches!(motion, Motion::Drill | Motion::Opaque) {
            self.state.under_cycle = motion;
        }
    }

    /// Whether P beside G54 names one of the further work offsets: it belongs to no other code or call of the block.
    fn names_further_offset(&self, request: &Request, code: G) -> bool {
        let own = |code: G| {
            let timed = matches!(code, G::Dwell | G::Drill(_) | G::DrillAlong(..) | G::Setting(..));
            timed || acts(code) && !in_machine(code)
        };
        let by_p = self.program.dialect().rules.offset_by_p && code == G::WorkOffset(1) && request.any(b"P");
        by_p && request.jump == Jump::None && !request.codes().iter().any(|(code, _)| own(*code))
    }

    /// DEP without coordinates: in the plane the tool stands where the contour, and its radius, put it.
    fn leave_contour(&mut self, word: i32) {
        self.note_opaque(
            word,
            "the way from the contour is not in the path; the next cut has to name both axes of the plane",
        );
        let third = self.state.modal.plane.axes().2;
        self.drop_contouring("a way from the contour comes after it (DEP)");
        self.state.contouring.left_at = Some(self.path.len());
        self.state.frame.rename([0, 1, 2].map(|axis| axis != third));
    }

    /// G10.9: words on X are diameters or radii from here on.
    fn diameter_by_word(&mut self, request: &Request) {
        if let Some(diameter) = request.get(b'X') {
            (self.state.modal.diameter, self.state.modal.radius_increments) = (diameter != 0.0, false);
        }
    }

    /// What F counts where a code switches lengths alone: the machine's basic unit; mm as delivered, if lengths are, too.
    fn feed_unit_beside(&self, inch: bool) -> FeedUnit {
        let given = self.program.dialect().rules.basic_unit.and_then(|known| self.parameter(known));
        let at_start = self.options.initial.filter(|_| self.options.unit_is_known).map(|initial| initial.inch);
        match given.map(|value| value == 0.0).or(at_start) {
            Some(inch) => FeedUnit::Fixed(inch),
            None if inch => FeedUnit::Unknown,
            None => FeedUnit::Fixed(false),
        }
    }

    /// A feed in another unit has to be given anew.
    fn set_feed_mode(&mut self, mode: FeedMode) {
        if mode != self.state.modal.feed_mode {
            self.state.modal.feed_mode = mode;
            self.state.modal.feed = -1.0;
        }
    }

    /// Says of a code that changes where later positions are that the path does not follow it.
    pub(crate) fn unfollowed(&mut self, word: i32) {
        let message = format!("{}: the path goes on as if it were not there", self.word_text(word));
        let hint = "positions after it are not those of the machine; write it without this code";
        self.warn(finding::OPAQUE, self.word_start(word), message, hint);
    }

    /// An F in mm or as an inverse time; negative where its unit is not known.
    pub(crate) fn feed_mm(&mut self, request: &Request, feed: f64) -> f64 {
        let feed = self.feed_of(request, feed);
        let mm = match self.state.modal.feed_unit {
            _ if self.state.modal.feed_mode == FeedMode::InverseTime => 1.0,
            FeedUnit::OfLengths => self.state.modal.mm(),
            FeedUnit::Fixed(inch) => [1.0, 25.4][usize::from(inch)],
            FeedUnit::Unknown => {
                if let Some(parameter) = self.program.dialect().rules.basic_unit {
                    let what = "F counts the machine's basic unit, whatever lengths are in";
                    self.ask(parameter, Severity::Warning, request.word(b'F'), what);
                }
                -1.0
            }
        };
        if mm < 0.0 || feed < 0.0 && request.get(b'F').is_some_and(|word| word >= 0.0) {
            -1.0
        } else {
            feed * mm
        }
    }

    pub(crate) fn note_opaque(&mut self, word: i32, what: &str) {
        self.note_unseen(word, Unseen::Nothing, what);
    }

    pub(crate) fn note_unseen(&mut self, word: i32, unseen: Unseen, what: &str) {
        let hint = "it is kept as it is; a correction that would have to move it refuses the program";
        self.report_unseen(Severity::Note, unseen, word, what, hint);
    }

    /// Whether the block calls a tool of Klartext, by its number or name, or gives the one in use another speed or feed.
    fn calls_tool(&self) -> bool {
        let is_call = |word: &Word| self.program.text(word).to_ascii_uppercase().starts_with(b"TOOL CALL");
        self.program.dialect().flow == FlowStyle::Labels
            && self.program.words_of(self.block).iter().take(2).any(is_call)
    }

    fn apply_feed_speed_tool(&mut self, request: &Request, action: Action) {
        if self.is_corner(request) || is_idle(action) || action == G::CallCycleAt {
        } else if let Some(feed) = request.get(b'F') {
            if std::mem::take(&mut self.state.feed_by_revolution) {
                self.set_feed_mode(FeedMode::PerMinute);
            }
            self.state.modal.feed = self.feed_mm(request, feed);
        } else if let Some(feed) = request.get(b'f') {
            self.set_feed_mode(FeedMode::PerRevolution);
            (self.state.modal.feed, self.state.feed_by_revolution) = (feed * self.state.modal.mm(), true);
        } else if request.any(b"z") {
            self.state.modal.feed = -1.0;
            self.note_opaque(request.word(b'z'), "a feed a tooth: the number of teeth is not in the program");
        }
        if self.calls_tool() {
            self.state.tool_feed = request.get(b'F').map_or(-1.0, |_| self.state.modal.feed);
        }
        match request.get(b'S') {
            // With the position register S is the greatest speed, not the one to run at.
            Some(limit) if action == G::SetRegister => self.state.modal.spindle_limit = limit,
            Some(speed) => self.state.modal.spindle_speed = speed,
            None => {}
        }
        self.apply_tool(request);
    }
}
