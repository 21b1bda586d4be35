//! Cutter compensation: from the programmed contour to the path of the controlled point, as LinuxCNC 2.9 drives it.
//!
//! The first move under G41 or G42 ends where the tool touches its programmed end, at its left or right; with controls
//! that look ahead, at the left or right of the move that comes next. Then the
//! centre keeps the radius: around a corner that turns away from the tool by an arc about it (a rapid move goes
//! straight), into one that turns towards it as far as the crossing of the two offset paths. Where G40 ends it the
//! tool leaves from where it stands. Compensation acts in the plane of arcs, G17 or G18; along the third axis, and
//! where nothing is compensated, the path is the programmed one.

use std::f64::consts::PI;

use crate::compensation::offset::{dot, minus, plus, Planar};
use crate::finding::{self, Finding, Severity, Unseen};
use crate::modes::modal::{Compensation, Modal};
use crate::modes::tool::{Cutter, Tool};
use crate::path::{Arc, Caller, ToolPath, INHERITED};
use crate::reading::program::Program;
use crate::shapes::arc::{self, Point};

/// Turns below this (rad) are no corner to LinuxCNC.
pub(crate) const NO_CORNER: f64 = 0.05;

/// The path of the controlled point: the tool's centre, or the imaginary tip that its orientation says.
pub fn compensated(path: &ToolPath, program: &Program, tools: &[Tool]) -> (ToolPath, Vec<Finding>) {
    let (states, origins, calls) = (path.states.clone(), path.origins.clone(), path.calls.clone());
    let out = ToolPath { states, origins, calls, ..ToolPath::default() };
    let mut work =
        Compensator { path, program, tools, out, findings: Vec::new(), lead: [0.0; 3], active: None, last: 0 };
    let mut arcs = path.arcs.iter().peekable();
    let mut dwells = path.dwells.iter().copied().peekable();
    for index in 0..path.len() {
        while let Some((_, time)) = dwells.next_if(|(before, _)| *before <= index) {
            work.out.dwells.push((work.out.len(), time));
        }
        let arc = arcs.next_if(|arc| arc.of_move == index);
        work.add(index, arc);
    }
    work.finish();
    let after = work.out.len();
    work.out.dwells.extend(dwells.map(|(_, time)| (after, time)));
    (work.out, work.findings)
}

/// Compensation in force.
pub(crate) struct Active {
    /// The state that switched it on.
    pub modal: Modal,
    pub cutter: Cutter,
    /// First move of the output under it.
    pub since: usize,
    /// From this move of the output on ends may still change.
    pub open: usize,
    /// How that move was programmed to go.
    pub way: Way,
}

/// How a move was programmed to go.
#[derive(Clone, Copy)]
pub(crate) enum Way {
    /// Straight, by as much in the plane.
    By(Point),
    /// By an arc of that sweep.
    Turn(f64),
}

pub(crate) struct Compensator<'a> {
    pub path: &'a ToolPath,
    pub program: &'a Program,
    pub tools: &'a [Tool],
    pub out: ToolPath,
    findings: Vec<Finding>,
    /// Where the tool stands less where the program believes it.
    pub lead: [f64; 3],
    pub active: Option<Active>,
    /// The last move compensated.
    pub last: usize,
}

impl Active {
    pub fn left(&self) -> bool {
        self.modal.compensation == Compensation::Left
    }

    /// Where the centre is when the tool touches a point while it travels in a direction.
    pub fn beside(&self, point: Point, direction: Point) -> Point {
        let left = [-direction[1], direction[0]];
        plus(point, left, if self.left() { self.cutter.radius } else { -self.cutter.radius })
    }
}

impl Compensator<'_> {
    fn add(&mut self, index: usize, arc: Option<&Arc>) {
        let state = self.path.state.get(index).and_then(|state| self.path.states.get(*state as usize)).copied();
        let (Some(state), Some(start), Some(end)) = (state, self.path.start.get(index), self.path.end.get(index))
        else {
            return;
        };
        self.switch(index, &state);
        self.require_same_frame(index);
        let (first, second, _) = state.plane.axes();
        let planar = Planar { index, axes: (first, second), start: *start, end: *end, arc };
        match &self.active {
            None => self.as_programmed(&planar),
            Some(active) if active.since == self.out.len() => self.enter(&planar),
            Some(_) if planar.from() == planar.to() && arc.is_none() => {
                self.emit(&planar, self.standing(&planar), None)
            }
            Some(_) => self.go_on(&planar),
        }
    }

    /// The tool's radius, between its centre and where the program believes it, does not turn with the coordinates.
    fn require_same_frame(&mut self, index: usize) {
        let frame = |index: usize| self.path.origins[self.path.state[index] as usize].linear;
        if self.lead != [0.0; 3] && index.checked_sub(1).is_some_and(|before| frame(before) != frame(index)) {
            let message = "coordinates are turned, mirrored or scaled before the tool has left the contour".to_owned();
            self.refuse(index, finding::OPAQUE, message, "write a move after G40 (R0), and then turn them");
        }
    }

    pub fn as_programmed(&mut self, planar: &Planar<'_>) {
        let start = [0, 1, 2].map(|axis| planar.start[axis] + self.lead[axis]);
        self.lead = [0.0; 3];
        let arc = planar.arc.map(|arc| Arc { of_move: self.out.len(), ..*arc });
        self.push(planar.index, start, planar.end, arc);
    }

    /// Where the centre stands before a move.
    pub fn standing(&self, planar: &Planar<'_>) -> Point {
        plus(planar.from(), planar.point(self.lead), 1.0)
    }

    /// The ends of all moves so far are final.
    pub fn settle(&mut self) {
        if let Some(active) = self.active.as_mut() {
            active.open = self.out.len();
        }
    }

    /// The centre's move that a programmed one becomes.
    pub fn emit(&mut self, planar: &Planar<'_>, end: Point, circle: Option<(Point, bool)>) {
        let opens = self.out.len();
        self.append(planar, planar.end, end, circle);
        self.last = planar.index;
        if let Some(active) = self.active.as_mut().filter(|active| active.open == opens) {
            active.way = match planar.arc {
                Some(arc) => Way::Turn(arc.sweep),
                None => Way::By(minus(planar.to(), planar.from())),
            };
        }
    }

    /// Reports a move that had to be cut back so far that it runs the other way, an arc then nearly the whole circle.
    /// `ends`: before a corner, or where compensation ends, LinuxCNC also bounds by how much an arc becomes longer.
    pub fn check_way(&mut self, index: usize, ends: bool) {
        let Some(active) = &self.active else { return };
        let (open, axes) = (active.open, active.modal.plane.axes());
        let (Some(start), Some(end)) = (self.out.start.get(open), self.out.end.get(open)) else { return };
        let sweep = || self.out.arcs.iter().rev().find(|arc| arc.of_move == open).map_or(0.0, |arc| arc.sweep);
        let reached = match active.way {
            Way::By(way) => dot(way, [end[axes.0] - start[axes.0], end[axes.1] - start[axes.1]]) >= 0.0,
            Way::Turn(turn) => {
                let longer = self.program.dialect().rules.longer_arc.filter(|_| ends);
                let most = longer.map_or(PI - turn.abs() / 2.0, |most| most[usize::from(active.modal.inch)]);
                sweep().abs() <= turn.abs() + most
            }
        };
        if !reached {
            self.refuse_corner(index);
        }
    }

    pub fn refuse_corner(&mut self, index: usize) {
        let radius = self.active.as_ref().map_or(0.0, |active| active.cutter.radius);
        let message = format!("a tool of radius {radius:.4} mm does not fit into the corner before this move");
        let hint = "it would cut into the contour: use a smaller tool, or write the corner wider";
        self.refuse(index, finding::GOUGE, message, hint);
    }

    /// A move of the centre to `end`, after which the program believes itself at `believed`.
    pub fn append(&mut self, planar: &Planar<'_>, believed: [f64; 3], end: Point, circle: Option<(Point, bool)>) {
        let (first, second) = planar.axes;
        let start = [0, 1, 2].map(|axis| planar.start[axis] + self.lead[axis]);
        let mut to = believed;
        (to[first], to[second]) = (end[0], end[1]);
        let arc = circle.map(|(centre, clockwise)| {
            let circle = arc::about(planar.point(start), end, centre, clockwise);
            let mut around = start;
            (around[first], around[second]) = (centre[0], centre[1]);
            let sweep = circle.map_or(0.0, |circle| circle.sweep);
            Arc { of_move: self.out.len(), centre: around, sweep, radius: f64::NAN }
        });
        self.lead = [0, 1, 2].map(|axis| to[axis] - believed[axis]);
        self.push(planar.index, start, to, arc);
    }

    fn push(&mut self, index: usize, start: [f64; 3], end: [f64; 3], arc: Option<Arc>) {
        use crate::path::MoveKind;
        let source = self.path.kind.get(index).copied().unwrap_or(MoveKind::Line);
        let kind = match (source, arc) {
            (_, Some(_)) => MoveKind::Arc,
            (MoveKind::Arc, None) => MoveKind::Line,
            (kind, None) => kind,
        };
        let words = self.path.words.get(index).copied().unwrap_or([INHERITED; 3]);
        let block = self.path.block.get(index).copied().unwrap_or(0);
        let state = self.path.state.get(index).copied().unwrap_or(0);
        self.out.caller = Caller(self.path.call.get(index).copied().unwrap_or(INHERITED));
        self.out.push(kind, start, end, words, block, state);
        self.out.arcs.extend(arc);
    }

    pub fn refuse(&mut self, index: usize, code: &'static str, message: String, hint: &str) {
        let block = self.path.block.get(index).map_or(0, |block| *block as usize);
        let start = self.program.blocks().get(block).map_or(0, |block| block.start as usize);
        let at = start + self.path.column(index, self.program) - 1;
        finding::add(
            &mut self.findings,
            Finding { severity: Severity::Error, code, message, hint: hint.to_owned(), at, unseen: Unseen::Nothing },
        );
    }
}
