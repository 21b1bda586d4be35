//! Contours of Sinumerik's turning cycles: CYCLE95, and CYCLE952 on the contour that CYCLE62 names.
//!
//! A contour is a subprogram of the file, or the blocks between two labels. Finishing runs its blocks, each move under its
//! own line and with the nose kept off, which the cycle switches on by itself.

use crate::dialect::{Name, G, M};
use crate::drilling::cycle_arguments::{numbers, Argument};
use crate::finding::{Severity, Unseen};
use crate::modes::modal::{Compensation, Motion};
use crate::modes::request::Request;
use crate::order::labels::{called, lower, program_name, Direction};
use crate::path::{MoveKind, INHERITED};
use crate::reading::program::{Word, WordKind};
use crate::run::Runner;
use crate::shapes::drawn::Contour;
use crate::turning::removal_cuts::Stock;

/// What such a cycle does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Removal {
    /// Names the contour for the one that follows (CYCLE62).
    Names,
    /// Roughs, finishes or both (CYCLE95).
    Stock,
    /// The same with a blank of its own (CYCLE952): of it the finishing is run.
    Contour,
}

/// How far the tool is off the contour before and after, where the program does not say it, mm.
const CLEARANCE: f64 = 1.0;

/// On which side of the contour the tool is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Outside,
    Inside,
}

type Made = Result<(), &'static str>;

impl Runner<'_> {
    /// A word of these; what cannot be followed is said, and nothing moves.
    pub(crate) fn removal(&mut self, removal: Removal, word: i32) {
        let Some(arguments) = self.cycle_arguments(word) else { return };
        let made = match removal {
            Removal::Stock | Removal::Contour if self.draws => Err("it stands in a contour itself"),
            Removal::Names => {
                self.state.contour_name = contour_name(&arguments);
                return;
            }
            Removal::Stock => self.stock_removal(&arguments, word),
            Removal::Contour => self.contour_turning(&arguments, word),
        };
        if let Err(why) = made {
            let what = format!("what it does is not in the path: {why}");
            if !self.options.roughed_contours {
                return self.note_unseen(word, Unseen::Block, &what);
            }
            // A field over the program would leave its contour where it is.
            let hint = "the path goes on without it; write its moves out to have them";
            self.report_unseen(Severity::Warning, Unseen::Block, word, &what, hint);
        }
    }

    /// `CYCLE95(NPP, MID, FALZ, FALX, FAL, FF1, FF2, FF3, VARI, DT, DAM, _VRT)`.
    fn stock_removal(&mut self, arguments: &[Argument], word: i32) -> Made {
        let [_, depth, left_z, left_x, left, feed, _, finish_feed, kind, _, _, lift] = numbers(arguments);
        let kind = kind.unwrap_or(f64::NAN).round();
        if !(1.0..=12.0).contains(&kind) {
            return Err("VARI is not one of 1 to 12");
        }
        let (way, stage) = ((kind as usize - 1) % 4, (kind as usize - 1) / 4);
        let side = if way < 2 { Side::Outside } else { Side::Inside };
        let name = arguments.first().and_then(|first| first.text.clone()).unwrap_or_default();
        let blocks = self.contour_named(&name).ok_or("its contour is not in this file")?;
        let contour = self.draw(blocks.0, blocks.1)?;
        let mm = self.state.modal.mm();
        let length = |value: Option<f64>| value.unwrap_or(0.0).abs() * mm;
        let lift = Some(length(lift)).filter(|lift| *lift > 0.0).unwrap_or(CLEARANCE);
        let stock = Stock {
            depth: length(depth),
            left: [length(left_x), length(left_z)],
            along: length(left),
            lift,
            side,
            faces: way % 2 == 1,
        };
        if stage != 1 {
            self.rough_stock(&contour, &stock, feed.map(|feed| feed * mm), word);
        }
        let alone = stage == 0 && self.contour_to_run(word, blocks) && !self.finishes_stock(&name);
        if stage != 0 || alone {
            let start = stock.start(&contour).ok_or("its contour does not say where the tool stands")?;
            self.finish_stock(blocks, &contour, (side, finish_feed.map(|feed| feed * mm), word), Some(start))?;
        }
        Ok(())
    }

    /// Whether a cycle of the program finishes the contour of that name.
    fn finishes_stock(&mut self, name: &str) -> bool {
        let name = lower(name.trim().as_bytes());
        let stock = |word: &Word| self.program.code(word) == Some(G::Removal(Removal::Stock));
        let cycles: Vec<usize> =
            (0..self.program.words().len()).filter(|at| stock(&self.program.words()[*at])).collect();
        cycles.into_iter().any(|at| {
            let arguments = self.cycle_arguments(at as i32).unwrap_or_default();
            let own =
                arguments.first().and_then(|first| first.text.as_deref()).map(|text| lower(text.trim().as_bytes()));
            own.as_ref() == Some(&name) && arguments.get(8).is_some_and(|kind| kind.value.round() > 4.0)
        })
    }

    fn rough_stock(&mut self, contour: &Contour, stock: &Stock, feed: Option<f64>, word: i32) {
        if !self.options.roughing {
            return self
                .note_opaque(word, "its roughing passes are not in the path; the contour is run where it finishes");
        }
        let steps = match stock.cuts(contour) {
            _ if !contour.lies_in(self.state.position[1], self.state.modal.plane) => {
                Err("its contour is not in the plane of Z and X")
            }
            steps => steps,
        };
        match steps {
            Ok(steps) => {
                let before = self.state.modal;
                self.state.modal.compensation = Compensation::Off;
                self.state.modal.feed = feed.unwrap_or(before.feed);
                for step in &steps {
                    self.rough_step(step.kind, step.to, step.centre);
                }
                self.state.modal = before;
                self.note_opaque(word, "its allowances are taken as radii, its infeeds as equal ones");
            }
            Err(why) => self.not_roughed(word, why),
        }
    }

    /// `CYCLE952(PRG, CON, CONR, VARI, F, …)`: roughing is left out, what it takes off depends on its blank.
    fn contour_turning(&mut self, arguments: &[Argument], word: i32) -> Made {
        let [_, _, _, kind, feed, ..] = numbers::<14>(arguments);
        let extra = arguments.get(13).map_or(0.0, |argument| argument.value);
        let kind = kind.filter(|kind| (0.0..1e9).contains(kind)).ok_or("VARI is not given")?.round() as usize;
        let digit = |place: u32| kind / 10_usize.pow(place) % 10;
        if digit(1) != 2 || !matches!(digit(0), 1 | 2) {
            return Err("of it finishing along or across the axis is followed alone");
        }
        if extra.abs() > 0.0 {
            return Err("it corrects its contour by an allowance of its own");
        }
        let name = self.state.contour_name.clone().ok_or("no CYCLE62 with a contour of this file comes before it")?;
        let blocks = self.contour_named(&name).ok_or("its contour is not in this file")?;
        let contour = self.draw(blocks.0, blocks.1)?;
        let last = contour.cuts.last().map_or(contour.start, |cut| cut.end);
        let way = [last[0] - contour.start[0], last[2] - contour.start[2]];
        let runs = match digit(2) {
            1 => -way[0],
            2 => way[0],
            3 => -way[1],
            4 => way[1],
            _ => f64::NAN,
        };
        let side = match digit(3) {
            2 => Side::Inside,
            _ => Side::Outside,
        };
        if runs.is_nan() || runs < 0.0 {
            return Err("it cuts its contour the other way round, or does not say which way");
        }
        let feed = feed.map(|feed| feed * self.state.modal.mm());
        self.finish_stock(blocks, &contour, (side, feed, word), None)?;
        self.note_opaque(word, "how the tool comes to the contour and leaves it is the control's; taken as straight from and to where it was");
        Ok(())
    }

    /// Runs the contour's blocks from `start`, or from where the tool is, and goes back there.
    fn finish_stock(
        &mut self,
        (first, last): (usize, usize),
        contour: &Contour,
        (side, feed, word): (Side, Option<f64>, i32),
        start: Option<[f64; 3]>,
    ) -> Made {
        let compensation =
            keeps_off(contour, side).ok_or("its contour is closed: on which side the tool is, is not clear")?;
        let before = self.state.modal;
        if let Some([x, _, z]) = start {
            let here = self.state.position;
            self.emit(MoveKind::Rapid, [here[0], here[1], z], [INHERITED; 3]);
            self.emit(MoveKind::Rapid, [x, here[1], z], [INHERITED; 3]);
        }
        self.compensate(&Request::new(), compensation, false, word);
        self.state.modal.motion = Motion::Line;
        self.state.modal.feed = feed.filter(|feed| *feed > 0.0).unwrap_or(before.feed);
        self.state.comes_at_rapid = true;
        self.visit_contour((first, last), self.next, Some(before), true);
        Ok(())
    }

    /// The blocks of a contour: of the subprogram of that name, or from one label to another (`BEGIN:END`).
    fn contour_named(&self, name: &str) -> Option<(usize, usize)> {
        let name = lower(name.trim().as_bytes());
        if let Some((first, last)) = name.split_once(':') {
            let label = |text: &str| self.labels().target(text.trim().as_bytes(), self.block, Direction::Either);
            return Some((label(first)?, label(last)?)).filter(|(first, last)| first <= last);
        }
        let bare = name.strip_suffix(".spf").or_else(|| name.strip_suffix("_spf")).unwrap_or(&name);
        let start = self.labels().named_program(bare.strip_prefix("_n_").unwrap_or(bare))?;
        let after = start + 1;
        let end = (after..self.program.blocks().len()).find(|block| self.ends_subprogram(*block));
        let last = end.unwrap_or(self.program.blocks().len()).checked_sub(1)?;
        (after <= last).then_some((after, last))
    }

    fn ends_subprogram(&self, block: usize) -> bool {
        let dialect = self.program.dialect();
        let ends = |function: Option<M>| matches!(function, Some(M::Return | M::End));
        program_name(self.program, block).is_some()
            || self.program.words_of(block).iter().any(|word| match (word.kind, word.letter) {
                (WordKind::Number, b'M') => ends(dialect.m_code(word.value)),
                (WordKind::Name, _) => match dialect.names.get(word.value as usize) {
                    Some(Name::Function(function)) => ends(Some(function)),
                    _ => false,
                },
                (WordKind::Call, _) => called(self.program, word).0 == "ret",
                _ => false,
            })
    }
}

/// The contour that CYCLE62 names: a subprogram (kind 0), or two labels (2).
fn contour_name(arguments: &[Argument]) -> Option<String> {
    let text = |index: usize| arguments.get(index).and_then(|argument| argument.text.clone());
    match arguments.get(1).map_or(0.0, |kind| kind.value) {
        2.0 => Some(format!("{}:{}", text(2)?, text(3)?)),
        kind if kind.is_nan() || kind == 0.0 => text(0),
        _ => None,
    }
}

/// Which side of its way the nose is kept on: the part is towards the axis, of an inside contour away from it; the tool
/// stands before a face.
fn keeps_off(contour: &Contour, side: Side) -> Option<Compensation> {
    let last = contour.cuts.last()?.end;
    let (x, z) = (last[0] - contour.start[0], last[2] - contour.start[2]);
    let right = match (side, z == 0.0) {
        (_, true) if x == 0.0 => return None,
        (_, true) => x > 0.0,
        (Side::Outside, false) => z < 0.0,
        (Side::Inside, false) => z > 0.0,
    };
    Some(if right { Compensation::Right } else { Compensation::Left })
}
