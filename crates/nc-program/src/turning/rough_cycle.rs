//! Roughing cycles of Fanuc and Haas lathes (G71 to G73): what their words say, and their moves.

use crate::compensation::offset::minus;
use crate::modes::modal::{Compensation, Modal};
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::run::Runner;
use crate::shapes::arc::{about, Circle, Point};
use crate::shapes::drawn::{planar, Contour};
use crate::turning::rough::{Piece, Rough, Roughing, MOST};
use crate::turning::rough_contour::{pieces, Own};

/// How far the tool is lifted after a cut where the program does not say it, mm.
const ESCAPE: f64 = 1.27;

/// What the first block of two says, for those that follow; NaN where none said it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RoughData {
    pub depth: f64,
    escape: f64,
    /// Of G73: how far off its first pass is (x, z), and how many there are.
    relief: [f64; 2],
    passes: f64,
}

impl RoughData {
    pub const NONE: Self = Self { depth: f64::NAN, escape: f64::NAN, relief: [f64::NAN; 2], passes: f64::NAN };
}

impl Runner<'_> {
    /// `G71 U2. R1.`: depth of cut and how far the tool is lifted, of G72 W and R; of G73 U, W the relief, R passes.
    pub(crate) fn rough_data(&mut self, request: &Request, rough: Rough) {
        let mm = self.state.modal.mm();
        let length = |letter: u8, before: f64| request.get(letter).map_or(before, |value| value * mm);
        let data = &mut self.state.rough;
        match rough {
            Rough::Along => (data.depth, data.escape) = (length(b'U', data.depth), length(b'R', data.escape)),
            Rough::Face => (data.depth, data.escape) = (length(b'W', data.depth), length(b'R', data.escape)),
            Rough::Pattern => {
                data.relief = [length(b'U', data.relief[0]), length(b'W', data.relief[1])];
                data.passes = request.get(b'R').unwrap_or(data.passes);
            }
        }
    }

    /// Roughs out the contour between two blocks; one that cannot be followed is reported, and nothing moves.
    pub(crate) fn rough(&mut self, request: &Request, rough: Rough, word: i32, blocks: (usize, usize)) {
        let made = self.draw(blocks.0, blocks.1).and_then(|contour| match rough {
            _ if !contour.lies_in(self.state.position[1], self.state.modal.plane) => {
                Err("its contour is not in the plane of Z and X")
            }
            Rough::Pattern => self.rough_pattern(request, &contour),
            _ => self.rough_cuts(request, rough, &contour, (word, blocks.0)),
        });
        if let Err(why) = made {
            self.not_roughed(word, why);
        }
    }

    /// U and W of the block with P and Q: what is left for finishing (x, y, z), with its sign; U on the diameter.
    pub(crate) fn allowance(&self, request: &Request) -> [f64; 3] {
        let of = |letter: u8, axis: usize| request.get(letter).unwrap_or(0.0) * self.state.modal.axis_mm(axis);
        [of(b'U', 0), 0.0, of(b'W', 2)]
    }

    /// Cuts level by level, then along the contour, all off by the allowance.
    fn rough_cuts(
        &mut self,
        request: &Request,
        rough: Rough,
        contour: &Contour,
        (word, first): (i32, usize),
    ) -> Result<(), &'static str> {
        let axes = if rough == Rough::Face { (0, 2) } else { (2, 0) };
        let (start, allowance) = (self.state.position, self.allowance(request));
        let own = Own::of(contour, start, axes);
        let mut roughing = self.roughing(request, contour, &own, axes)?;
        let mut taken = Vec::new();
        let steps = if self.names_both(first) {
            let to = own.inside(planar(contour.start, axes));
            roughing.pieces.insert(0, Piece { from: [0.0; 2], to, centre: None });
            taken = of_pockets(&roughing, allowance[axes.0])?;
            roughing.pocket_cuts()
        } else if roughing.is_monotone() {
            roughing.cuts()
        } else {
            return Err(
                "the contour has a pocket, or begins not at its deepest: its first block has to name X and Z then",
            );
        };
        let steps = steps.ok_or("its depth of cut makes no sense")?;
        if self.state.rough.escape.is_nan() {
            taken.push(format!("how far the tool is lifted after a cut is the control's; taken as {ESCAPE} mm"));
        }
        if !taken.is_empty() {
            self.note_opaque(word, &taken.join("; "));
        }
        let further = [request.get(b'I'), None, request.get(b'K')].map(|i| i.unwrap_or(0.0) * self.state.modal.mm());
        let left = sum(allowance, further);
        let at = |point: Point| sum(own.outside(point, start), left);
        self.uncompensated(|runner| {
            runner.emit(MoveKind::Rapid, sum(start, left), [INHERITED; 3]);
            for step in &steps {
                runner.rough_step(step.kind, at(step.to), step.centre.map(at));
            }
            runner.cut_contour(contour, allowance);
            if roughing.has_pocket() {
                runner.come_out(axes.1, start[axes.1] + allowance[axes.1], own.signs[1]);
            }
            runner.emit(MoveKind::Rapid, start, [INHERITED; 3]);
        });
        Ok(())
    }

    /// What the words say of the cuts, and the contour in their own coordinates.
    fn roughing(
        &self,
        request: &Request,
        contour: &Contour,
        own: &Own,
        axes: (usize, usize),
    ) -> Result<Roughing, &'static str> {
        let data = self.state.rough;
        let depth_of_cut = self.stepped(request, b'D').unwrap_or(data.depth);
        if depth_of_cut.is_nan() {
            return Err("its depth of cut is a parameter of the control");
        }
        Ok(Roughing {
            pieces: pieces(contour, axes, |point| own.inside(point)),
            depth_of_cut,
            escape: if data.escape.is_nan() { ESCAPE } else { data.escape },
            feeds_down: contour.feeds_down,
        })
    }

    /// At rapid out of a pocket to that height, where the tool is deeper; `sign` is that of deep along the axis.
    fn come_out(&mut self, axis: usize, height: f64, sign: f64) {
        let mut out = self.state.position;
        if sign * (out[axis] - height) > 0.0 {
            out[axis] = height;
            self.emit(MoveKind::Rapid, out, [INHERITED; 3]);
        }
    }

    /// Whether a block names X and Z, as the first one of a contour with pockets does.
    fn names_both(&self, block: usize) -> bool {
        let words = self.program.words_of(block);
        [b"XU", b"ZW"].iter().all(|letters| words.iter().any(|word| letters.contains(&word.letter)))
    }

    /// A move of the roughing: about a centre it is the shorter way.
    pub(crate) fn rough_step(&mut self, kind: MoveKind, end: [f64; 3], centre: Option<[f64; 3]>) {
        let (first, second, _) = self.state.modal.plane.axes();
        let [from, to] = [self.state.position, end].map(|point| planar(point, (first, second)));
        let circle = centre.map(|centre| planar(centre, (first, second))).and_then(|centre| {
            let (a, b) = (minus(from, centre), minus(to, centre));
            about(from, to, centre, a[0] * b[1] < a[1] * b[0])
        });
        match circle {
            Some(circle) => self.emit_arc(circle, circle.sweep, f64::NAN, end, [INHERITED; 3]),
            None => self.emit(kind, end, [INHERITED; 3]),
        }
    }

    /// The contour as often as R says: first as far off as U and W of the first block say, last with the allowance.
    fn rough_pattern(&mut self, request: &Request, contour: &Contour) -> Result<(), &'static str> {
        let (data, start, mm) = (self.state.rough, self.state.position, self.state.modal.mm());
        // In one block: I and K the relief, D the passes.
        let of = |letter: u8, first: f64| request.get(letter).map_or(first, |value| value * mm);
        let relief = [of(b'I', data.relief[0]), 0.0, of(b'K', data.relief[1])];
        let passes = request.get(b'D').unwrap_or(data.passes).round();
        if relief.iter().any(|value| value.is_nan()) || passes.is_nan() {
            return Err("its relief or its number of passes is a parameter of the control");
        }
        if !(1.0..=MOST).contains(&passes) {
            return Err("its number of passes makes no sense");
        }
        let allowance = self.allowance(request);
        self.uncompensated(|runner| {
            for pass in 1..=passes as usize {
                let share = (passes - pass as f64) / (passes - 1.0).max(1.0);
                let off = sum(allowance, relief.map(|value| value * share));
                runner.emit(MoveKind::Rapid, sum(start, off), [INHERITED; 3]);
                runner.cut_contour(contour, off);
            }
            runner.emit(MoveKind::Rapid, start, [INHERITED; 3]);
        });
        Ok(())
    }

    /// Along the contour, off by as much.
    pub(crate) fn cut_contour(&mut self, contour: &Contour, off: [f64; 3]) {
        let down = if contour.feeds_down { MoveKind::Line } else { MoveKind::Rapid };
        self.emit(down, sum(contour.start, off), [INHERITED; 3]);
        let (first, second, _) = self.state.modal.plane.axes();
        for cut in &contour.cuts {
            let end = sum(cut.end, off);
            match cut.arc {
                Some(arc) => {
                    let centre = planar(sum(arc.centre, off), (first, second));
                    self.emit_arc(Circle { centre, sweep: arc.sweep }, arc.sweep, arc.radius, end, [INHERITED; 3]);
                }
                None => self.emit(MoveKind::Line, end, [INHERITED; 3]),
            }
        }
    }

    /// Roughing takes no notice of G41 and G42.
    fn uncompensated(&mut self, cut: impl FnOnce(&mut Self)) {
        let before = self.state.modal;
        self.state.modal = Modal { compensation: Compensation::Off, ..before };
        cut(self);
        self.state.modal = before;
    }
}

/// What is taken of a contour with pockets, to be said; why it cannot be followed.
fn of_pockets(roughing: &Roughing, allowance: f64) -> Result<Vec<String>, &'static str> {
    if let Some(why) = roughing.pockets_refused() {
        return Err(why);
    }
    let mut taken = Vec::new();
    if roughing.has_pocket() {
        taken.push("the order of its pockets is the control's; taken as each to its ground before the next".to_owned());
        if allowance != 0.0 {
            taken.push(
                "the allowance along its cuts moves both walls of a pocket the same way, into one of them".into(),
            );
        }
    }
    Ok(taken)
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
