//! Lathe auto-programming of Okuma's OSP: contours between G81 or G82 and G80, called by the sequence name of their first
//! block (`G85 NLAP1 …`, `G87 NLAP1`). In the program's course a definition is passed over.

use crate::dialect::G;
use crate::finding::{self, Severity};
use crate::modes::modal::{Compensation, Modal};
use crate::modes::request::Request;
use crate::path::{MoveKind, INHERITED};
use crate::reading::program::{Word, WordKind};
use crate::run::Runner;
use crate::shapes::drawn::Contour;
use crate::turning::rough::{Rough, MOST};

/// What a code of it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lap {
    /// Begins a contour that is cut along Z (G81).
    Begin,
    /// Begins one that is cut along X (G82).
    BeginFacing,
    /// Begins the shape of the blank (G83).
    Blank,
    /// Ends the definition (G80).
    End,
    /// Roughs: bar turning in straight cuts (G85), or copies of the contour (G86).
    Rough(Rough),
    /// Runs along the contour (G87).
    Finish,
}

/// A definition: whether it is cut along X, and its first and last block.
type Definition = (bool, (usize, usize));

impl Runner<'_> {
    pub(crate) fn lap(&mut self, request: &Request, lap: Lap, word: i32) {
        match lap {
            Lap::End => {}
            Lap::Begin | Lap::BeginFacing | Lap::Blank => match self.lap_end(self.block) {
                Some(end) => self.next = end + 1,
                None => {
                    let message = format!("{} without the G80 that ends its contour", self.word_text(word));
                    self.refuse(finding::FLOW, self.word_start(word), message, "end the contour with G80");
                }
            },
            Lap::Rough(_) | Lap::Finish => {
                let Some((facing, blocks)) = self.lap_contour(word) else {
                    let message = format!("{}: its contour is not in this program", self.word_text(word));
                    let hint = "name the block with G81 or G82, and end the contour with G80";
                    return self.refuse(finding::FLOW, self.word_start(word), message, hint);
                };
                if self.draws {
                    let hint = "write the contour with moves alone, outside of its cycle";
                    return self.refuse(
                        finding::FLOW,
                        self.block_start(),
                        "a contour that runs on a contour".into(),
                        hint,
                    );
                }
                match lap {
                    Lap::Rough(rough) => self.lap_rough(request, (rough, facing), word, blocks),
                    _ => {
                        self.visit_contour(blocks, self.next, None, false);
                        self.note_end(word, blocks.0);
                    }
                }
            }
        }
    }

    /// Said where the contour begins: the call itself moves nothing.
    fn note_end(&mut self, word: i32, first: usize) {
        let at = self.program.blocks().get(first).map_or(0, |block| block.start as usize);
        let message =
            format!("{}: where it leaves the contour is the control's; taken as at its end", self.word_text(word));
        self.report(Severity::Note, finding::OPAQUE, at, message, "write the way from there into the program");
    }

    fn lap_rough(&mut self, request: &Request, (rough, facing): (Rough, bool), word: i32, blocks: (usize, usize)) {
        if !self.options.roughing {
            self.note_opaque(
                word,
                "its roughing passes are not in the path; the contour is run by its finishing cycle",
            );
            if self.contour_to_run(word, blocks) && !self.finishes_lap(blocks) {
                self.visit_contour(blocks, self.next, None, true);
            }
            return;
        }
        let axis = if facing { 2 } else { 0 };
        let depth = request.get(b'D').map_or(f64::NAN, |depth| depth * self.state.modal.axis_mm(axis));
        if self.lap_goes_on() {
            return self.not_roughed(word, "its block goes on in the next line (G84)");
        }
        match rough {
            Rough::Pattern => {
                let made =
                    self.draw(blocks.0, blocks.1).and_then(|contour| self.lap_copies(request, &contour, axis, depth));
                if let Err(why) = made {
                    self.not_roughed(word, why);
                }
            }
            _ => {
                self.state.rough.depth = depth;
                let mut allowances = Request::new();
                for letter in *b"UW" {
                    if let Some(value) = request.get(letter) {
                        allowances.set(letter, value, request.word(letter).max(0) as usize);
                    }
                }
                self.rough(&allowances, if facing { Rough::Face } else { Rough::Along }, word, blocks);
            }
        }
    }

    /// G86: the contour again and again, each pass nearer by D, the last off by the allowance. The pass of number n
    /// begins D n nearer to the contour than the tool stood, and in the other axis as near in proportion.
    fn lap_copies(
        &mut self,
        request: &Request,
        contour: &Contour,
        axis: usize,
        depth: f64,
    ) -> Result<(), &'static str> {
        let (start, left) = (self.state.position, self.allowance(request));
        if !contour.lies_in(start[1], self.state.modal.plane) {
            return Err("its contour is not in the plane of Z and X");
        }
        let way = [0, 1, 2].map(|index| start[index] - contour.start[index] - left[index]);
        let passes = (way[axis].abs() / depth - 1e-9).ceil();
        if !(depth > 0.0 && (1.0..=MOST).contains(&passes)) {
            return Err("its depth of cut makes no sense");
        }
        let before = self.state.modal;
        self.state.modal = Modal { compensation: Compensation::Off, ..before };
        for pass in 1..=passes as usize {
            let share = if pass as f64 == passes { 0.0 } else { 1.0 - pass as f64 * depth / way[axis].abs() };
            let off = [0, 1, 2].map(|index| left[index] + way[index] * share);
            self.cut_contour(contour, off);
            let [x, y, _] = self.state.position;
            self.emit(MoveKind::Rapid, [x, y, start[2]], [INHERITED; 3]);
            self.emit(MoveKind::Rapid, start, [INHERITED; 3]);
        }
        self.state.modal = before;
        Ok(())
    }

    /// Whether a cycle of the program finishes that contour.
    fn finishes_lap(&self, blocks: (usize, usize)) -> bool {
        let words = self.program.words();
        let finishes = |at: &usize| self.program.code(&words[*at]) == Some(G::Lap(Lap::Finish));
        (0..words.len()).filter(finishes).any(|at| self.lap_contour(at as i32).is_some_and(|(_, own)| own == blocks))
    }

    /// Says of a roughing cycle why its passes are left out.
    pub(crate) fn not_roughed(&mut self, word: i32, why: &str) {
        let message = format!("{}: its roughing passes are not in the path: {why}", self.word_text(word));
        let hint = "the path goes on without them; write them out to have them";
        self.warn(finding::OPAQUE, self.word_start(word), message, hint);
    }

    /// Whether the next line belongs to the block.
    fn lap_goes_on(&self) -> bool {
        let first = self.program.words_of(self.block + 1).first();
        first.is_some_and(|word| self.program.text(word).starts_with(b"$"))
    }

    /// The contour of the sequence name that stands behind the code: the blocks between G81 or G82 and G80.
    fn lap_contour(&self, word: i32) -> Option<Definition> {
        let call = self.program.words().get(usize::try_from(word).ok()?)?;
        let block = self.program.block_at(call.start as usize);
        let behind = self.program.words_of(block).iter().find(|word| word.start > call.start && is_name(word));
        let name = self.sequence_name(behind?);
        let named =
            |block: usize| self.program.words_of(block).first().is_some_and(|word| self.sequence_name(word) == name);
        let begins = (0..self.program.blocks().len()).find(|block| named(*block) && self.lap_code(*block).is_some())?;
        let end = self.lap_end(begins)?;
        // The blank's shape, which comes first, is no part of the contour.
        let first = (begins..end).find(|block| matches!(self.lap_code(*block), Some(Lap::Begin | Lap::BeginFacing)))?;
        let facing = self.lap_code(first) == Some(Lap::BeginFacing);
        (first + 1 < end).then_some((facing, (first + 1, end - 1)))
    }

    fn sequence_name(&self, word: &Word) -> Vec<u8> {
        let text = self.program.text(word).to_ascii_uppercase();
        let digits =
            text.strip_prefix(b"N").map(|rest| rest.iter().skip_while(|byte| **byte == b'0').copied().collect());
        digits.unwrap_or(text)
    }

    /// What begins a definition in a block.
    fn lap_code(&self, block: usize) -> Option<Lap> {
        let codes = self.program.words_of(block).iter().filter_map(|word| self.program.code(word));
        codes
            .filter_map(|code| if let G::Lap(lap) = code { Some(lap) } else { None })
            .find(|lap| matches!(lap, Lap::Begin | Lap::BeginFacing | Lap::Blank))
    }

    /// The block of the G80 that ends the definition beginning in a block.
    fn lap_end(&self, begin: usize) -> Option<usize> {
        let ends = |block: &usize| {
            self.program.words_of(*block).iter().any(|word| self.program.code(word) == Some(G::Lap(Lap::End)))
        };
        (begin..self.program.blocks().len()).find(ends)
    }
}

fn is_name(word: &Word) -> bool {
    word.letter == b'N' && matches!(word.kind, WordKind::Number | WordKind::Label)
}
