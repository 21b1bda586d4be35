//! Where rotary axes stand: the path is without them, and what is displaced along X, Y, Z has to know that they do not
//! turn the work or the tool.

use crate::dialect::{FlowStyle, G};
use crate::modes::codes::Action;
use crate::modes::modal::Motion;
use crate::modes::request::Request;
use crate::reading::letters::Letters;
use crate::reading::program::{Program, WordKind};
use crate::run::Runner;

/// Rotary axes; the last stands for all that Sinumerik calls by a letter and a number.
const ROTARY: [u8; 4] = *b"ABCo";
/// C by an increment, on lathes.
const BY_INCREMENT: u8 = b'H';
const TURN_DEGREES: f64 = 360.0;

/// Angles in degrees: NaN where one is not stated yet, infinite where it is not known any more.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rotary {
    angles: [f64; 4],
    /// Those whose places are called otherwise than by the machine's angles: what the program states does not tell them.
    renamed: [bool; 4],
    /// Those that the program names.
    named: [bool; 4],
    /// The letter of one that is not at 0 or comes from elsewhere; 0 for none.
    pub turned: u8,
}

impl Rotary {
    /// Before the first block nobody knows where those stand that the program names.
    pub fn new(named: Letters) -> Self {
        let angles = ROTARY.map(|axis| if named.has(axis) { f64::NAN } else { 0.0 });
        let mut rotary = Self { angles, named: ROTARY.map(|axis| named.has(axis)), ..Self::default() };
        rotary.settle();
        rotary
    }

    /// A way home without axes takes all of them there.
    pub fn go_home(&mut self) {
        for index in (0..ROTARY.len()).filter(|index| self.named[*index]) {
            self.angles[index] = f64::INFINITY;
        }
        self.settle();
    }

    /// The block is over.
    pub fn settle(&mut self) {
        let away = |angle: f64| angle % TURN_DEGREES != 0.0; // true of NaN and of infinity
        self.turned = ROTARY.iter().zip(self.angles).find(|(_, angle)| away(*angle)).map_or(0, |(axis, _)| *axis);
    }

    /// The angles that are stated or were.
    pub fn stated(&self) -> [Option<f64>; 4] {
        self.angles.map(|angle| (!angle.is_nan()).then_some(angle))
    }
}

impl Runner<'_> {
    /// Takes rotary axes to where the block says; whether it does. While the block is run, one that comes from
    /// another angle than 0 counts as turned as well.
    pub(crate) fn turn(&mut self, request: &Request, action: Action) -> bool {
        let letters = self.program.dialect().other_axes;
        let is_axis = |letter: u8| letters.has(letter) && request.get(letter).is_some();
        let of_contour = self.draws && self.program.dialect().flow == FlowStyle::OWords;
        let named = ROTARY.into_iter().any(is_axis) || letters.has(BY_INCREMENT) && is_axis(BY_INCREMENT);
        if !named || of_contour || matches!(action, G::CallMacro | G::ModalMacro | G::OwnCycle) {
            return false;
        }
        let (before, angles) = (self.state.frame.rotary.turned, self.state.frame.rotary.angles);
        for (index, letter) in ROTARY.into_iter().enumerate() {
            if let Some(value) = request.get(letter).filter(|_| letters.has(letter)) {
                let increment = request.reference(letter).unwrap_or(self.state.modal.incremental);
                let now = self.state.frame.rotary.angles[index];
                let goes = matches!(
                    action,
                    G::Inert
                        | G::MachineCoordinates
                        | G::BuilderCoordinates
                        | G::Home(_)
                        | G::HomeNamed(_)
                        | G::Retract
                        | G::FixedPoint
                );
                self.state.frame.rotary.renamed[index] |= !(goes || now == 0.0 && value == 0.0);
                self.state.frame.rotary.angles[index] = match action {
                    _ if self.state.frame.rotary.renamed[index] => f64::INFINITY,
                    G::Inert if increment && now.is_nan() => f64::INFINITY,
                    G::Inert if increment => now + value,
                    // Several axes share the last place: one of them at 0 says nothing of the others.
                    G::Inert | G::MachineCoordinates | G::BuilderCoordinates if letter != b'o' || now == 0.0 => value,
                    _ if now == 0.0 && value == 0.0 && !matches!(action, G::Home(_) | G::HomeNamed(_)) => 0.0,
                    _ => f64::INFINITY,
                };
            }
        }
        if let Some(value) = request.get(BY_INCREMENT).filter(|_| letters.has(BY_INCREMENT)) {
            let now = &mut self.state.frame.rotary.angles[2];
            *now = if now.is_nan() { f64::INFINITY } else { *now + value };
        }
        let at_feed = matches!(action, G::Inert) && !matches!(self.state.modal.motion, Motion::Rapid | Motion::None);
        if at_feed && self.path.turns_in_cut.is_none() {
            let now = self.state.frame.rotary.angles;
            let changed = (0..ROTARY.len()).find(|index| now[*index].to_bits() != angles[*index].to_bits());
            self.path.turns_in_cut = changed.map(|index| (self.block, ROTARY[index]));
        }
        self.state.frame.rotary.settle();
        if before != 0 {
            self.state.frame.rotary.turned = before;
        }
        true
    }
}

/// The rotary axes that a program names. Arguments of macros do not count, nor do LinuxCNC's contours, in which these
/// letters are corners.
pub fn rotary_letters(program: &Program) -> Letters {
    let (others, mut found) = (program.dialect().other_axes, Letters::default());
    let axes = || ROTARY.into_iter().chain([BY_INCREMENT]).filter(|letter| others.has(*letter));
    if axes().next().is_none() || program.dialect().flow == FlowStyle::OWords && has_contours(program) {
        return found;
    }
    let mut wanted = Letters::default();
    axes().for_each(|letter| wanted.add(letter));
    for word in program.words() {
        let is_value = matches!(word.kind, WordKind::Number | WordKind::Expression);
        if is_value && wanted.has(word.letter) && !found.has(word.letter) {
            let block = program.words_of(program.block_at(word.start as usize));
            // Of a threading cycle A and B are angles of the thread.
            let calls = |code| matches!(code, G::CallMacro | G::ModalMacro | G::OwnCycle);
            if !block.iter().any(|other| program.code(other).is_some_and(calls)) {
                found.add(if word.letter == BY_INCREMENT { b'C' } else { word.letter });
            }
        }
    }
    found
}

fn has_contours(program: &Program) -> bool {
    program.words().iter().any(|word| matches!(program.code(word), Some(G::Profile(_))))
}
