//! What cannot be written, and why.

use super::{Axis, Here, Writer};
use crate::field::Vector;
use crate::pieces::Piece;
use crate::refusal::Refused;
use crate::value::takes_terms;
use nc_program::{FeedMode, MoveKind, Word, WordKind};

/// M codes that may come before a move that was one: spindle, tool, coolant. The others are done after a block's move.
const BEFORE_MOVE: [u16; 5] = [3, 4, 6, 7, 8];

fn is_formula(word: &Word) -> bool {
    word.kind == WordKind::Expression
}

impl Writer<'_> {
    /// Some moves are one to the control: a thread, one whose time is given, one with a code that is done at its end.
    pub(super) fn require_divisible(&self, here: &Here) -> Result<(), Refused> {
        let late = |word: &&Word| word.letter == b'M' && !BEFORE_MOVE.contains(&(word.value.round() as u16));
        let code = here.words.iter().find(late).map(|word| String::from_utf8_lossy(self.program.text(word)));
        let why = if self.path.kind[here.index] == MoveKind::Thread {
            "a thread".to_owned()
        } else if here.state.feed_mode == FeedMode::InverseTime {
            "a move whose time is given (G93)".to_owned()
        } else if here.words.iter().any(|word| word.letter == b'b') {
            "a move with a feed of its own (FB)".to_owned()
        } else if self.is_pole_formula(here) {
            "an arc about a parameter".to_owned()
        } else if !takes_terms(self.program) && here.axes.iter().any(|axis| axis.word.is_some_and(is_formula)) {
            "a move to a parameter".to_owned()
        } else if let Some(code) = code {
            format!("a move with {code} in its block")
        } else {
            return Ok(());
        };
        Err(self.indivisible(here, &why))
    }

    /// A tap turns along its own axis: refuses a thread along the tool's axis, or of G331 and G332 along one, that the
    /// field would lead aside.
    pub(super) fn require_straight_tap(&self, here: &Here, before: &Vector, pieces: &[Piece]) -> Result<(), Refused> {
        let (_, _, third) = here.state.plane.axes();
        let is_tap = |word: &Word| word.letter == b'G' && (word.value == 331.0 || word.value == 332.0);
        let mut named = (0..3).filter(|axis| self.path.words[here.index][*axis] >= 0);
        let (Some(along), None, Some(last)) = (named.next(), named.next(), pieces.last()) else { return Ok(()) };
        if self.path.kind[here.index] != MoveKind::Thread || along != third && !here.words.iter().any(is_tap) {
            return Ok(());
        }
        let aside = (0..3).filter(|axis| *axis != along).map(|axis| (last.end[axis] - before[axis]).abs());
        let aside = aside.fold(0.0, f64::max);
        if aside <= self.tolerance_mm + here.step.unit * here.state.mm() {
            return Ok(());
        }
        let message = format!("a tap would be led {:.1} µm aside over its depth", aside * 1e3);
        let hint = "a tap keeps its place along its axis: give a field that is even along it there";
        Err(Refused::block(self.block_start(here.block), message, hint))
    }

    pub(super) fn indivisible(&self, here: &Here, what: &str) -> Refused {
        let message = format!("{what} would have to become several blocks to follow the field");
        let hint = "put the code into a block of its own, or allow a larger tolerance";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn no_centre(&self, here: &Here) -> Refused {
        let message = "the arc's centre is not said in its block of 1 move".to_owned();
        let hint = "write the arc with I, J, K or R in its own block, in Klartext with X and Y in CC before it";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn turned_about_pole(&self, here: &Here) -> Refused {
        let message = "the end is given about a pole that is displaced otherwise, or before the tool is".to_owned();
        Refused::block(self.block_start(here.block), message, "write the move by X, Y and Z")
    }

    pub(super) fn other_start(&self, here: &Here, axis: usize) -> Refused {
        let letter = char::from(super::AXES[axis]);
        let message = format!(
            "{letter} is displaced on the contour before it names {letter}, and a roughing cycle begins it elsewhere"
        );
        let hint = "name X and Z in the first block of the contour, or go on from there along one axis alone";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn other_turn(&self, here: &Here, chord_mm: f64, turned_rad: f64) -> Refused {
        let turned = turned_rad.to_degrees();
        let message =
            format!("the arc would turn by {turned:.3} degrees: rounded, its ends are {chord_mm:.5} mm apart");
        let hint = "write it as a line, or leave it out: it is shorter than the last digit of its coordinates";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(crate) fn arc_in_machine(&self, index: usize) -> Refused {
        let message = "an arc goes to a place of the machine, which is not displaced as its centre is".to_owned();
        let block = self.path.block[index] as usize;
        Refused::block(self.block_start(block), message, "go there by lines")
    }

    pub(super) fn nowhere(&self, here: &Here, axis: &Axis, off_mm: f64) -> Refused {
        let letter = char::from(axis.letter);
        let message = format!("{letter} is displaced by {off_mm:.5} mm, but the program never says where it stands");
        let hint = "name the axis before the first cut, or leave its displacement out of the field";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn unreachable(&self, here: &Here) -> Refused {
        let message = "an axis turns round before this arc, whose block may not be the next that is run".to_owned();
        let hint = "write loops and calls out, and arcs in blocks that are not optional";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn open_circle(&self, here: &Here) -> Refused {
        let message = "this full circle would not close after rounding".to_owned();
        let hint = "write it as two half circles, its start reached by absolute coordinates";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn leaning(&self, here: &Here, axis: usize, by_mm: f64) -> Refused {
        let (letter, by_um) = (char::from(super::AXES[axis]), 1e3 * by_mm);
        let message = format!("{letter} is displaced by {by_um:.2} µm more at one end of the hole than at the other");
        let hint = "a cycle drills straight: allow a tolerance of half of that, or write the hole out as moves";
        Refused::block(self.block_start(here.block), message, hint)
    }

    /// A cycle whose passes are the control's, over which the field differs; without an axis by the way of travel.
    pub(super) fn uneven(&self, here: &Here, off: Option<(usize, f64)>) -> Refused {
        let message = match off {
            Some((_, off_mm)) if off_mm.is_infinite() => {
                "the displacement is not known everywhere within what the cycle mills".to_owned()
            }
            Some((axis, off_mm)) => format!(
                "{} is displaced by up to {:.2} µm differently within what the cycle mills",
                char::from(super::AXES[axis]),
                1e3 * off_mm
            ),
            None => {
                "how far it is displaced depends on the way of travel or a rotary axis, or is not known: the passes of \
                     the cycle are the control's"
                    .to_owned()
            }
        };
        let hint = match off {
            Some((_, off_mm)) if off_mm.is_finite() => {
                "the cycle is displaced as a whole: allow a larger tolerance, or write its passes out as moves"
            }
            _ => "write its passes out as moves",
        };
        Refused::block(self.block_start(here.block), message, hint)
    }

    /// A cycle at absolute heights, none of which the program writes: Q203 is given from outside.
    pub(super) fn unwritten(&self, here: &Here) -> Refused {
        let message =
            "the heights of the cycle are not written in the program, and would have to be displaced".to_owned();
        Refused::block(self.block_start(here.block), message, "write the surface Q203 into the program")
    }

    pub(super) fn repeated(&self, here: &Here, off_mm: f64) -> Refused {
        let message = format!("a hole that the block repeats would be {:.2} µm off", 1e3 * off_mm);
        Refused::block(self.block_start(here.block), message, "write each hole into a block of its own")
    }

    pub(super) fn other_hole(&self, here: &Here, by_mm: f64, known_mm: f64) -> Refused {
        let message = format!(
            "this hole is displaced by {by_mm:.5} mm along an axis, and the first one of its cycle by {known_mm:.5} mm"
        );
        let hint =
            "define the cycle anew before it, or allow a larger tolerance: one definition states one value for all";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn begun_elsewhere(&self, here: &Here, initial_mm: f64, height_mm: f64) -> Refused {
        let message = format!("the cycle begins at {initial_mm:.5} mm, and its first hole at {height_mm:.5} mm");
        let hint = "call the cycle in the block of its first hole";
        Refused::block(self.block_start(here.block), message, hint)
    }

    pub(super) fn down_first(&self, here: &Here, plane_mm: f64) -> Refused {
        let message =
            format!("displaced, the cycle begins below its plane R at {plane_mm:.5} mm: it would go down first");
        Refused::block(self.block_start(here.block), message, "begin the cycle further above the plane R")
    }

    pub(super) fn other_height(&self, here: &Here, axis: &Axis, height_mm: f64) -> Refused {
        let text = axis.word.map_or("".into(), |word| String::from_utf8_lossy(self.program.text(word)));
        let message = format!("{text} does not say that the hole goes by {height_mm:.5} mm");
        Refused::block(self.block_start(here.block), message, "write the hole out as moves")
    }

    pub(super) fn twice(&self, block: usize) -> Refused {
        let message = "1 block moves the tool several times, to places that are displaced differently".to_owned();
        Refused::block(self.block_start(block), message, "write the loop, subprogram or cycle out")
    }

    pub(super) fn block_start(&self, block: usize) -> usize {
        self.program.blocks().get(block).map_or(0, |block| block.start as usize)
    }
}
