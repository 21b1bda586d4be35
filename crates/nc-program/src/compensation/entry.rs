//! Compensation begins and ends: the moves onto the contour and off it.

use crate::compensation::compensate::{Active, Compensator, Way};
use crate::compensation::offset::{minus, plus, unit, Planar};
use crate::finding;
use crate::modes::linear::SAME;
use crate::modes::modal::{Compensation, Modal, Plane};
use crate::modes::tool::{self, Cutter};
use crate::shapes::arc::Point;

impl Compensator<'_> {
    /// Starts or ends compensation where the state of the next move says so.
    pub fn switch(&mut self, index: usize, state: &Modal) {
        let off = state.compensation == Compensation::Off;
        let key = |modal: &Modal| (modal.compensation, modal.called, modal.plane);
        if self.active.as_ref().map_or(off, |active| key(&active.modal) == key(state)) {
            return;
        }
        if self.active.is_some() && !off {
            let message = "compensation changes its side, tool or plane while it is on".to_owned();
            self.refuse(index, finding::ENTRY, message, "write G40 and a straight move between the two");
        }
        self.finish();
        if off {
            return;
        }
        if state.plane == Plane::Yz {
            let message = format!("{} in the plane of G19", mode(state));
            return self.refuse(index, finding::ENTRY, message, "compensation acts in G17 and G18");
        }
        match tool::cutter(state, self.tools, self.program.dialect()) {
            Ok(cutter) if cutter.radius > 0.0 && !self.keeps_shape(index, &cutter) => {
                let message =
                    format!("{} where coordinates are scaled, or turned with the tip of the tool", mode(state));
                let hint =
                    "the radius and the tip of a tool are not scaled and turned: end the scaling or the turn before";
                self.refuse(index, finding::OPAQUE, message, hint);
            }
            Ok(cutter) => {
                let since = self.out.len();
                self.active = Some(Active { modal: *state, cutter, since, open: since, way: Way::By([0.0; 2]) })
                    .filter(|_| cutter.radius > 0.0);
            }
            Err(what) => {
                let hint = "give it: --tool R0.4 (mm), on a lathe with its tip: --tool R0.4,Q3";
                self.refuse(index, finding::TOOL, format!("{}: {what}", mode(state)), hint);
            }
        }
    }

    /// Whether the tool, worked with in the program's coordinates, is itself where these are placed: a circle that is not
    /// scaled, and no tip beside it that would be turned.
    fn keeps_shape(&self, index: usize, cutter: &Cutter) -> bool {
        let state = self.path.state[index] as usize;
        self.path.origins[state].linear.is_none_or(|linear| {
            let circle = linear.of_circles(self.path.states[state].plane);
            cutter.tip == [0.0; 3] && circle.is_some_and(|(scale, _)| (scale - 1.0).abs() <= SAME)
        })
    }

    /// Ends compensation. The controlled point of what was compensated is the tip.
    pub fn finish(&mut self) {
        if self.active.as_ref().is_some_and(|active| active.open < self.out.len()) {
            self.check_way(self.last, true);
        }
        let Some(active) = self.active.take() else { return };
        let tip = active.cutter.tip;
        let shift = |position: &mut [f64; 3]| *position = [0, 1, 2].map(|axis| position[axis] + tip[axis]);
        self.out.end.iter_mut().skip(active.since).for_each(shift);
        self.out.start.iter_mut().skip(active.since + 1).for_each(shift);
        let arcs = self.out.arcs.iter_mut().filter(|arc| arc.of_move >= active.since);
        arcs.for_each(|arc| shift(&mut arc.centre));
        if self.out.len() > active.since {
            shift(&mut self.lead);
        }
    }

    /// The first move: straight to beside its end, or by an arc that touches there.
    pub fn enter(&mut self, planar: &Planar<'_>) {
        let Some(active) = &self.active else { return };
        let (standing, radius, tip) = (self.standing(planar), active.cutter.radius, active.cutter.tip);
        let way = minus(planar.to(), standing);
        let own = if planar.arc.is_some() { planar.direction(planar.to()) } else { unit(way) };
        let next = if self.program.dialect().rules.enters_beside_next { self.next_direction(planar) } else { None };
        let direction = next.unwrap_or(own);
        let end = active.beside(planar.to(), direction);
        let length = way[0].hypot(way[1]);
        if length <= radius || length.is_nan() {
            let message = format!(
                "the first move under {} is {length:.4} mm long, the tool's radius {radius:.4} mm",
                mode(&active.modal)
            );
            self.refuse(planar.index, finding::ENTRY, message, "begin further away: by more than the tool's radius");
            return self.as_programmed(planar);
        }
        if planar.arc.is_some() && tip != [0.0; 3] {
            // The controlled point changes from the tip to the tip as the centre sees it, before the arc.
            self.append(planar, planar.start, standing, None);
            self.settle();
        }
        let circle = planar.circle().map(|(centre, clockwise)| (entry_centre(standing, end, centre), clockwise));
        self.emit(planar, end, circle);
        if let (Some(active), None) = (self.active.as_mut(), planar.arc) {
            // Taken back into a corner it may turn about, but not cross over to the contour's other side. Square to the
            // next move there is nothing to take back, whichever way it came.
            active.way = Way::By(if next.is_some() { [0.0; 2] } else { minus(end, planar.to()) });
        }
    }

    /// Direction in which the next move under the same compensation begins.
    fn next_direction(&self, planar: &Planar<'_>) -> Option<Point> {
        for index in planar.index + 1..self.path.len() {
            let state = self.path.states.get(*self.path.state.get(index)? as usize)?;
            if state.compensation != self.active.as_ref()?.modal.compensation {
                return None;
            }
            let place = self.path.arcs.partition_point(|arc| arc.of_move < index);
            let arc = self.path.arcs.get(place).filter(|arc| arc.of_move == index);
            let (start, end) = (*self.path.start.get(index)?, *self.path.end.get(index)?);
            let next = Planar { index, axes: planar.axes, start, end, arc };
            if next.from() != next.to() || arc.is_some() {
                return Some(next.direction(next.from()));
            }
        }
        None
    }
}

fn mode(modal: &Modal) -> &'static str {
    if modal.compensation == Compensation::Left {
        "G41"
    } else {
        "G42"
    }
}

/// The centre of the arc of the tool's centre that begins where it stands and, with the programmed arc, ends square to
/// the way to the programmed arc's centre.
fn entry_centre(standing: Point, end: Point, centre: Point) -> Point {
    let towards = unit(minus(centre, end));
    let way = minus(standing, end);
    let along = way[0] * towards[0] + way[1] * towards[1];
    plus(end, towards, (way[0] * way[0] + way[1] * way[1]) / (2.0 * along))
}
