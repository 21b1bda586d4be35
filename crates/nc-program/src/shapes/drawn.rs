//! A contour between two blocks, drawn to look at: its moves are made, and then the run is where it was.

use crate::modes::modal::Plane;
use crate::modes::request::Request;
use crate::path::{Arc, MoveKind, ToolPath};
use crate::run::Runner;
use crate::shapes::arc::Point;

/// The moves of a contour: how the tool comes to it, and its cuts.
#[derive(Debug)]
pub(crate) struct Contour {
    /// Where it begins.
    pub start: [f64; 3],
    /// Whether it is reached at feed.
    pub feeds_down: bool,
    pub cuts: Vec<Cut>,
}

/// A cut of a contour: straight, or about a centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub end: [f64; 3],
    pub arc: Option<Arc>,
}

impl Contour {
    /// Whether it lies in the plane of Z and X at that y, and its arcs are in the plane in force.
    pub fn lies_in(&self, y: f64, plane: Plane) -> bool {
        self.start[1] == y && self.cuts.iter().all(|cut| cut.end[1] == y && (cut.arc.is_none() || plane == Plane::Zx))
    }
}

impl Runner<'_> {
    /// The contour that the blocks from `first` to `last` draw from here; why there is none.
    pub(crate) fn draw(&mut self, first: usize, last: usize) -> Result<Contour, &'static str> {
        let state = self.state.clone();
        let (visits, returns, counters) = (self.visits.clone(), self.returns.clone(), self.counters.clone());
        let (path, here) = (std::mem::take(&mut self.path), (self.block, self.next));
        let watch = std::mem::take(&mut self.watch);
        self.draws = true;
        self.run_between(first, last);
        self.close_contour();
        self.draws = false;
        self.watch = watch;
        (self.block, self.next) = here;
        (self.visits, self.returns, self.counters) = (visits, returns, counters);
        let undefined = std::mem::replace(&mut self.state, state).undefined;
        self.state.undefined = undefined;
        contour(&std::mem::replace(&mut self.path, path))
    }

    pub(crate) fn run_between(&mut self, first: usize, last: usize) {
        let mut request = Request::new();
        let (depth, caller) = (self.visits.len(), self.returns.len());
        self.next = first;
        let within = |runner: &Self| (first..=last).contains(&runner.next);
        while within(self) || self.visits.len() > depth || self.returns.len() > caller {
            if self.visits.len() < depth || self.returns.len() < caller || !self.step(&mut request) {
                return;
            }
        }
    }
}

/// Moves that lead nowhere, and rapid ones after the last cut, are none of the contour.
fn contour(path: &ToolPath) -> Result<Contour, &'static str> {
    if path.origins.windows(2).any(|pair| pair.first() != pair.last()) {
        return Err("the frame changes within its contour");
    }
    if !path.arcs.is_empty() && path.states.iter().any(|state| state.plane != Plane::Zx) {
        return Err("its arcs are not in the plane of Z and X");
    }
    let Some(last) = path.kind.iter().rposition(|kind| *kind != MoveKind::Rapid) else {
        return Err("its contour has no cut");
    };
    let approach = path.kind.iter().take_while(|kind| **kind == MoveKind::Rapid).count();
    let feeds_down = approach == 0;
    let approach = approach.max(1);
    let mut arcs = path.arcs.iter().peekable();
    let mut cuts = Vec::new();
    for index in approach..=last {
        let arc = loop {
            match arcs.peek() {
                Some(arc) if arc.of_move < index => arcs.next(),
                Some(arc) if arc.of_move == index => break Some(**arc),
                _ => break None,
            };
        };
        let (Some(kind), Some(end)) = (path.kind.get(index), path.end.get(index)) else { break };
        if !matches!(kind, MoveKind::Line | MoveKind::Arc) {
            return Err("its contour is not of lines and arcs alone");
        }
        cuts.push(Cut { end: *end, arc });
    }
    let start = path.end.get(approach - 1).copied().ok_or("its contour has no cut")?;
    if path.kind.first() == Some(&MoveKind::Arc) || cuts.is_empty() {
        return Err("its contour has no cut after the move that leads to it");
    }
    Ok(Contour { start, feeds_down, cuts })
}

/// Coordinates of a position on two axes.
pub(crate) fn planar(position: [f64; 3], axes: (usize, usize)) -> Point {
    let at = |axis: usize| position.get(axis).copied().unwrap_or(f64::NAN);
    [at(axes.0), at(axes.1)]
}
