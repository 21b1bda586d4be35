//! Turning cycles of LinuxCNC on a contour that Q names (G70, G71, G72 and their variants).

use crate::finding::{Severity, Unseen};
use crate::modes::modal::{Compensation, Motion, Plane};
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::run::Runner;
use crate::shapes::arc::{about, Circle, Point};
use crate::turning::beside::beside;
use crate::turning::level_cuts::{level_cuts, Pockets, Step};
use crate::turning::profile_contour::Drawn;
use crate::turning::segment::{cut_corners, Segment, Turn};

/// What such a cycle does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// Runs along the contour (G70).
    Finish,
    /// Roughs along Z (G71).
    Along(Pockets),
    /// Roughs along X (G72).
    Face(Pockets),
}

impl Profile {
    /// Whether its passes only come near the contour.
    pub fn roughs(self) -> bool {
        self != Self::Finish
    }
}

/// More finishing passes than this are a slip.
const MOST: f64 = 10_000.0;

/// Arcs that end nearer to where they begin, in program units, are left out.
const SAME: f64 = 1e-5;

/// A move to be made, and what it comes from where it is a block of the contour as it stands.
struct Cut {
    kind: MoveKind,
    end: [f64; 3],
    circle: Option<Circle>,
    of: Option<(usize, [i32; 3])>,
}

/// Which way the cycle's own coordinates lie in those of (z, x): a quarter turn first, then mirrored.
#[derive(Clone, Copy, Default)]
struct Frame {
    turned: bool,
    mirrored: [bool; 2],
}

impl Frame {
    /// Turns a contour so that it is cut along X.
    fn turn(&mut self, segments: &mut [Segment]) {
        self.turned = true;
        segments.iter_mut().for_each(|segment| *segment = segment.moved(|point| [point[1], -point[0]], false));
    }

    /// Mirrors it so that it runs up, and towards lower `along`, from the end of its first segment to that of its last.
    fn face(&mut self, segments: &mut [Segment]) {
        let (Some(first), Some(last)) = (segments.first().copied(), segments.last().copied()) else { return };
        for (axis, wrong) in [last.to[0] > first.to[0], last.to[1] < first.to[1]].into_iter().enumerate() {
            if wrong {
                self.mirrored[axis] = !self.mirrored[axis];
                segments.iter_mut().for_each(|segment| *segment = segment.mirrored(axis));
            }
        }
    }

    fn outside(&self, point: Point) -> Point {
        let sign = |axis: usize| if self.mirrored[axis] { -point[axis] } else { point[axis] };
        let (along, up) = (sign(0), sign(1));
        if self.turned {
            [-up, along]
        } else {
            [along, up]
        }
    }

    fn mirrors(&self) -> bool {
        self.mirrored[0] != self.mirrored[1]
    }
}

impl Runner<'_> {
    /// The cycle: Q names the contour, X and Z say from where it is come to.
    pub(crate) fn profile_cycle(&mut self, request: &Request, profile: Profile, word: i32) {
        let before = self.path.len();
        if let Err(why) = self.profile_moves(request, profile) {
            self.state.modal.motion = Motion::None;
            let what = format!("its moves are not in the path: {why}");
            let hint = "the path goes on without them; write them out to have them";
            return self.report_unseen(Severity::Warning, Unseen::Moves, word, &what, hint);
        }
        if profile != Profile::Finish && !self.options.roughing {
            self.path.truncate(before);
            let what = "its roughing passes are not in the path; the contour is run by its finishing cycle";
            self.note_opaque(word, what);
        }
    }

    fn profile_moves(&mut self, request: &Request, profile: Profile) -> Result<(), &'static str> {
        if profile != Profile::Finish && self.state.modal.compensation != Compensation::Off {
            return Err("it wants G40");
        }
        if self.state.modal.plane != Plane::Zx {
            return Err("it wants G18");
        }
        if request.any(b"UW") {
            return Err("U and W displace its contour");
        }
        let number = request.get(b'Q').ok_or("it wants Q, the number of the subroutine of its contour")?.round();
        let sub = self.table.subroutine(&format!("{number}"));
        let sub = sub.ok_or("the subroutine that Q names is not in this program")?;
        let (start, words) = self.target(request, false);
        if start != self.state.position {
            self.emit(MoveKind::Rapid, start, words);
        }
        let contour = self.read_profile(sub)?;
        if contour.len() > 1 {
            let cuts = self.profile_cuts(request, profile, &contour)?;
            self.path.enter_call(self.block);
            cuts.iter().for_each(|cut| self.profile_cut(cut));
            self.path.leave_call();
        }
        Ok(())
    }

    fn profile_cut(&mut self, cut: &Cut) {
        let here = self.block;
        let (block, words) = cut.of.unwrap_or((here, [INHERITED; 3]));
        self.block = block;
        self.state.modal.motion = match cut.kind {
            MoveKind::Rapid => Motion::Rapid,
            MoveKind::Arc if cut.circle.is_some_and(|circle| circle.sweep > 0.0) => Motion::Clockwise,
            MoveKind::Arc => Motion::Counterclockwise,
            _ => Motion::Line,
        };
        match cut.circle {
            Some(circle) => self.emit_arc(circle, circle.sweep, f64::NAN, cut.end, words),
            None if cut.kind == MoveKind::Rapid && cut.end == self.state.position => {}
            None => self.emit(cut.kind, cut.end, words),
        }
        self.block = here;
    }

    fn profile_cuts(&self, request: &Request, profile: Profile, contour: &[Drawn]) -> Result<Vec<Cut>, &'static str> {
        let mut segments: Vec<Segment> = contour.iter().map(|drawn| drawn.segment).collect();
        let number = |letter: u8, without: f64| request.get(letter).unwrap_or(without);
        let (distance, depth, lift) = (number(b'D', 0.0), number(b'I', 1.0), number(b'R', 0.5));
        let mut frame = Frame::default();
        let pockets = match profile {
            Profile::Finish => return self.finish_cuts(request, segments, contour),
            Profile::Along(pockets) => pockets,
            Profile::Face(pockets) => {
                frame.turn(&mut segments);
                pockets
            }
        };
        frame.face(&mut segments);
        cut_corners(&mut segments)?;
        require_way(&mut segments)?;
        let mut segments = beside(&segments, distance)?;
        rise(&mut segments);
        let steps = level_cuts(&segments, pockets, depth, lift)?;
        self.outside(&frame, &steps)
    }

    /// P passes, from D off to E: to where the contour is come to, to its beginning, along it.
    fn finish_cuts(
        &self,
        request: &Request,
        mut segments: Vec<Segment>,
        contour: &[Drawn],
    ) -> Result<Vec<Cut>, &'static str> {
        let number = |letter: u8, without: f64| request.get(letter).unwrap_or(without);
        let (first, last, passes) = (number(b'D', 0.0), number(b'E', 0.0), number(b'P', 1.0));
        if passes.is_nan() || passes >= MOST {
            return Err("its number of passes makes no sense");
        }
        let frame = finishing_frame(&mut segments)?;
        cut_corners(&mut segments)?;
        require_way(&mut segments)?;
        let mut cuts = Vec::new();
        for pass in (1..=passes.max(0.0) as usize).rev() {
            let distance = (pass as f64 - 1.0) * (first - last) / passes + last;
            let path = beside(&segments, distance)?;
            let Some((lead, along)) = path.split_first() else { continue };
            let rapid = |to: Point| Step { kind: MoveKind::Rapid, to, turn: None };
            let mut steps = vec![rapid(lead.from), rapid(lead.to)];
            steps.extend(along.iter().map(|segment| {
                let kind = if segment.turn.is_some() { MoveKind::Arc } else { MoveKind::Line };
                Step { kind, to: segment.to, turn: segment.turn }
            }));
            let made = self.outside(&frame, &steps)?;
            // Each of its moves is that of a block where the contour is run as it stands.
            let drawn = if distance == 0.0 && made.len() == contour.len() + 1 { contour } else { &[] };
            let drawn = if drawn.iter().any(|drawn| drawn.segment.corner != 0.0) { &[] } else { drawn };
            cuts.extend(made.into_iter().enumerate().map(|(index, cut)| {
                let of = index.checked_sub(1).and_then(|index| drawn.get(index));
                Cut { of: of.map(|drawn| (drawn.block, drawn.words)), ..cut }
            }));
        }
        Ok(cuts)
    }

    /// Steps in the cycle's coordinates as moves, mm.
    fn outside(&self, frame: &Frame, steps: &[Step]) -> Result<Vec<Cut>, &'static str> {
        let (mm, y) = (self.state.modal.mm(), self.state.position[1]);
        let mut from = [self.state.position[2], self.state.position[0]];
        let place = |point: Point| frame.outside(point).map(|value| value * mm);
        let cut = |step: &Step| {
            let to = place(step.to);
            let start = std::mem::replace(&mut from, to);
            let clockwise = |turn: Turn| turn.left == frame.mirrors();
            let circle = step.turn.map(|turn| about(start, to, place(turn.centre), clockwise(turn)));
            let circle = circle.map(|found| found.ok_or("an arc of its contour has no radius")).transpose()?;
            let end = [to[1], y, to[0]];
            if !(to[0].is_finite() && to[1].is_finite()) {
                return Err("its contour cannot be followed");
            }
            let leads_nowhere = circle.is_some() && (0..2).all(|axis| (to[axis] - start[axis]).abs() < SAME * mm);
            Ok((!leads_nowhere).then_some(Cut { kind: step.kind, end, circle, of: None }))
        };
        steps.iter().map(cut).filter_map(Result::transpose).collect()
    }
}

/// Which way the contour after its first line lies: cut along X where it turns back along Z.
fn finishing_frame(segments: &mut [Segment]) -> Result<Frame, &'static str> {
    let mut along = segments.get(1..).unwrap_or(&[]).to_vec();
    let mut frame = Frame::default();
    frame.face(&mut along);
    if !along.iter().all(Segment::runs_on) {
        frame.turn(&mut along);
        frame.face(&mut along);
    }
    require_way(&mut along)?;
    let turned = frame.turned;
    frame = Frame::default();
    if turned {
        frame.turn(segments);
    }
    frame.face(segments);
    Ok(frame)
}

/// The contour is come to from before its beginning, and never turns back.
fn require_way(segments: &mut [Segment]) -> Result<(), &'static str> {
    if let Some(first) = segments.first_mut() {
        first.from[0] = first.from[0].max(first.to[0]);
    }
    if segments.iter().all(Segment::runs_on) {
        return Ok(());
    }
    Err("its contour turns back along its cuts")
}

/// Ends a contour no lower than where it is come to.
fn rise(segments: &mut Vec<Segment>) {
    let (Some(first), Some(last)) = (segments.first(), segments.last()) else { return };
    if last.to[1] < first.from[1] {
        segments.push(Segment::line(last.to, [last.to[0], first.from[1]]));
    }
}
