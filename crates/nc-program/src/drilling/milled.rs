//! Milling cycles that are called: pockets, slots, bores and studs around the place, faces by coordinates of their own.
//!
//! Their passes are the control's. The path has the way there and out, and the space in which the passes stay.

use crate::drilling::called_cycle::CalledHole;
use crate::drilling::cycle_arguments::numbers;
use crate::drilling::hole::{Drilled, Said};
use crate::modes::modal::Plane;
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::run::Runner;
use crate::values::parameters::Key;

/// Least and greatest coordinates, mm.
pub type Space = [[f64; 3]; 2];

/// Q parameters that are positions: the surface of drilling and pockets, start and end of a face, a centre, surface and
/// clearance of contours.
pub(crate) const POSITIONS: [u32; 9] = [203, 225, 226, 227, 386, 216, 217, 5, 7];

/// A milling cycle of Sinumerik, by its arguments (RTP, RFP, SDIS, DP, …).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pocket {
    /// Arguments of which the sum is the farthest that it mills from its place.
    pub sizes: &'static [usize],
    /// The first argument of its place; the other one comes after it.
    pub place: usize,
    /// Arguments that all versions of it take.
    pub most: usize,
}

/// How far a boring tool leaves the wall of its hole (Q214).
const BESIDE_MM: f64 = 0.2;

/// Whether a cycle goes to a centre of its own, Q216 and Q217.
pub(crate) fn has_centre(number: u16, q: impl Fn(u32) -> Option<f64>) -> bool {
    matches!(number, 210..=215) || number == 254 && q(367) == Some(0.0)
}

/// How far from its place a cycle of that number reaches at most, by its Q parameters and numbered lines, in their unit.
pub(crate) fn reach(
    number: u16,
    q: impl Fn(u32) -> Option<f64>,
    lines: &[Option<f64>],
    mm: f64,
) -> Result<f64, String> {
    let line = |index: usize| lines.get(index).copied().flatten();
    let half = |size: Option<f64>| size.map(|size| size / 2.0);
    let diagonal = |sides: (Option<f64>, Option<f64>)| sides.0.zip(sides.1).map(|(x, y)| x.hypot(y));
    let reach = match number {
        3 | 4 => diagonal((line(4), line(5))),
        5 => line(4),
        202 => Some(BESIDE_MM / mm),
        208 => half(q(335)),
        211 => half(q(244)).zip(q(219)).map(|(radius, width)| radius + width),
        214 | 215 => q(222).zip(q(223)).map(|(blank, finished)| blank.max(finished)),
        233 => diagonal((q(218), q(219))).map(|reach| reach + q(357).unwrap_or(0.0)),
        240 => q(344).map(|diameter| diameter.abs() / 2.0),
        252 => half(q(223)),
        254 => half(q(375)).zip(q(219)).map(|(radius, width)| radius + width),
        256 => diagonal((q(424), q(425))),
        257 => q(222),
        262..=267 => q(335),
        _ => diagonal((q(218), q(219))),
    };
    reach.filter(|reach| *reach > 0.0 && reach.is_finite()).ok_or_else(|| "its size is not given".to_owned())
}

/// Whether the manual says that a cycle ends where it began: else both axes of the plane have to be named after it.
fn ends_at_its_place(number: u16) -> bool {
    matches!(number, 4 | 5 | 208 | 240)
}

impl Runner<'_> {
    /// G12, G13 of Haas: down to Z at the middle, in circles out to K or I, and back to the middle. D is the tool's radius.
    pub(crate) fn circle_pocket(&mut self, request: &Request, word: i32) {
        let modal = &self.state.modal;
        let radius = request.get(b'K').or(request.get(b'I')).map_or(f64::NAN, |radius| radius * modal.mm());
        let why = match request.get(b'Z') {
            _ if modal.incremental || request.any(b"L") => "its depth is an increment",
            _ if modal.plane != Plane::Xy => "it lies in another plane than G17",
            Some(_) if radius > 0.0 => "",
            _ => "Z, and I or K are not both given",
        };
        if !why.is_empty() {
            return self.not_followed(word, why);
        }
        self.note_opaque(word, "its circles are not in the path");
        let (to, words) = self.target(request, false);
        let top = self.state.position[2].max(to[2]);
        let mut space = [to.map(|middle| middle - radius), to.map(|middle| middle + radius)];
        (space[0][2], space[1][2]) = (self.state.position[2].min(to[2]), top);
        self.path.pockets.push((self.path.len(), space));
        self.emit(MoveKind::Line, to, words);
    }

    /// A pocket, slot or bore around where the tool stands.
    pub(crate) fn mill_here(&mut self, hole: &CalledHole, number: u16, reach: f64) {
        let third = self.state.modal.plane.axes().2;
        if let Some(centre) = hole.centre() {
            self.go_to_place(centre, [216, 217].map(|number| self.state.defined.said(number)));
        }
        let at = self.state.position;
        let [plane, bottom, retract] = hole.heights();
        let mut space = [at.map(|middle| middle - reach), at.map(|middle| middle + reach)];
        (space[0][third], space[1][third]) = (bottom, plane);
        self.mill(space, plane, retract, hole.said());
        if !ends_at_its_place(number) {
            self.state.frame.rename([0, 1, 2].map(|axis| axis != third));
        }
    }

    /// To the plane where its passes begin, and out to where the tool ends.
    pub(crate) fn mill(&mut self, space: Space, plane: f64, retract: f64, said: Said) {
        let third = self.state.modal.plane.axes().2;
        let (at, first) = (self.state.position, self.path.len());
        self.height(MoveKind::Rapid, at, third, plane, INHERITED);
        if retract != plane {
            self.height(MoveKind::Rapid, at, third, retract, INHERITED);
        }
        self.path.drilled.push(Drilled {
            first,
            place: first,
            bottom: first,
            end: self.path.len(),
            third,
            plane_word: INHERITED,
            depth_word: INHERITED,
            plane,
            initial: retract,
            plane_from_initial: false,
            ends_at_plane: false,
            series: 0,
            repeat: 0,
            said: Some(said),
            milled: Some(space),
        });
    }

    /// Why no cycle whose passes are the control's is displaced as a whole here.
    pub(crate) fn require_plain_frame(&self) -> Result<(), String> {
        if self.state.frame.whole.is_some() {
            return Err("coordinates are turned, mirrored or scaled".to_owned());
        }
        Ok(())
    }

    /// Cycle 232: a face between Q225, Q226, Q227 and Q386, wherever the tool stands.
    pub(crate) fn mill_face(&mut self) -> Result<(), String> {
        self.require_plain_frame()?;
        let q = |number: u32| self.state.store.get(&Key::Number(number)).filter(|value| value.is_finite());
        let [Some(x), Some(y), Some(top), Some(bottom)] = [225, 226, 227, 386].map(q) else {
            return Err("Q225, Q226, Q227 and Q386 are not all given".to_owned());
        };
        let (Some(along), Some(across), Some(clearance)) = (q(218), q(219), q(200)) else {
            return Err("Q218, Q219 and Q200 are not all given".to_owned());
        };
        if bottom > top {
            return Err(format!("it mills from {top} up to {bottom}"));
        }
        let said = POSITIONS.map(|number| self.state.defined.said(number));
        let mm = self.state.modal.mm();
        let (first, second, third) = self.state.modal.plane.axes();
        let mut space = [[0.0; 3]; 2];
        for (axis, from, by) in [(first, x, along), (second, y, across)] {
            (space[0][axis], space[1][axis]) = (from.min(from + by) * mm, from.max(from + by) * mm);
        }
        let plane = (top + clearance) * mm;
        (space[0][third], space[1][third]) = (bottom * mm, plane);
        self.go_to_place([x * mm, y * mm], [said[1], said[2]]);
        self.mill(space, plane, plane, Said::at([said[3], (0, 0)], [said[4], (0, 0)]));
        self.state.frame.rename([true; 3]);
        Ok(())
    }

    /// POCKET3, POCKET4: around the place that its arguments state.
    pub(crate) fn mill_pocket(&mut self, pocket: Pocket, word: i32) {
        if let Err(why) = self.pocket(pocket, word) {
            self.not_followed(word, &why);
        }
    }

    fn pocket(&mut self, pocket: Pocket, word: i32) -> Result<(), String> {
        self.require_plain_frame()?;
        let arguments = self.cycle_arguments(word).ok_or("its arguments cannot be read")?;
        let Pocket { sizes, place, most } = pocket;
        let further = arguments.get(most..).unwrap_or(&[]);
        if further.iter().any(|one| one.text.is_some() || !(one.value.is_nan() || one.value == 0.0)) {
            return Err("its further arguments choose what its depth counts from".to_owned());
        }
        let given: [Option<f64>; 11] = numbers(&arguments);
        let [Some(retract), Some(reference), clearance, Some(depth), ..] = given else {
            return Err("RTP, RFP and DP are not all given".to_owned());
        };
        let reach: Option<f64> = sizes.iter().map(|size| given[*size].map(f64::abs)).sum();
        let (Some(x), Some(y), Some(reach)) = (given[place], given[place + 1], reach.filter(|reach| *reach > 0.0))
        else {
            return Err("its sizes and its place are not all given".to_owned());
        };
        let plane = reference + clearance.unwrap_or(0.0).abs();
        if depth >= reference || retract < plane {
            return Err(format!("it mills from {reference} to {depth} and ends at {retract}"));
        }
        let (first, second, third) = self.state.modal.plane.axes();
        let mm = self.state.modal.mm();
        if [first, second].iter().any(|axis| self.state.modal.axis_mm(*axis) != mm) {
            return Err("an axis of its plane counts diameters".to_owned());
        }
        let span = |index: usize| arguments.get(index).map_or((0, 0), |argument| argument.span);
        let mut space = [[0.0; 3]; 2];
        for (axis, middle) in [(first, x), (second, y)] {
            (space[0][axis], space[1][axis]) = ((middle - reach) * mm, (middle + reach) * mm);
        }
        (space[0][third], space[1][third]) = (depth * mm, plane * mm);
        self.note_opaque(word, "its passes are not in the path");
        self.go_to_place([x * mm, y * mm], [span(place), span(place + 1)]);
        let said = Said::at([span(0), span(1)], [span(3), (0, 0)]);
        self.mill(space, plane * mm, retract * mm, said);
        self.state.frame.rename([0, 1, 2].map(|axis| axis != third));
        Ok(())
    }
}
