//! Coordinates by a Q parameter: Klartext takes no sum of one, so a block before sets another parameter to it.

use nc_program::dialect::FlowStyle;
use nc_program::Word;

use super::Writer;
use crate::edits::line_ending;
use crate::refusal::Refused;
use crate::text::Step;
use crate::value::Value;

/// The parameters that a user's programs share among themselves.
const SHARED: std::ops::Range<usize> = 0..100;

impl Writer<'_> {
    /// Has a coordinate go by so many steps further than its parameter says. False where another way has to do: it is
    /// no parameter, or the program takes sums, or is not held in one part.
    pub(super) fn add_to_parameter(
        &mut self,
        word: &Word,
        axis: usize,
        step: Step,
        steps: i64,
    ) -> Result<bool, Refused> {
        let (program, value) = (self.program, Value::of(self.program, word)?);
        let text = value.text(program);
        let signs = text.iter().take_while(|byte| matches!(byte, b'+' | b'-' | b' ')).count();
        let (sign, name) = text.split_at(signs);
        let is_parameter = match name {
            [b'Q' | b'q', b'L' | b'l' | b'R' | b'r', number @ ..] | [b'Q' | b'q', number @ ..] => {
                !number.is_empty() && number.iter().all(u8::is_ascii_digit)
            }
            _ => false,
        };
        let free = self.free.get_or_init(|| unused(program.source())).get(axis).copied();
        let block = program.blocks().get(program.block_at(word.start as usize));
        let (true, true, true, Some(free), Some(block)) =
            (is_parameter, self.single, program.dialect().flow == FlowStyle::Labels, free, block)
        else {
            return Ok(false);
        };
        let steps = if sign.contains(&b'-') { -steps } else { steps };
        let at = block.start as usize;
        self.edits.replace(at, at, |out| {
            out.extend(format!("FN 1: Q{free} = +").bytes());
            out.extend(name);
            out.extend(b" + ");
            step.write(out, steps);
            out.extend(line_ending(program.source()));
        });
        self.edits.replace(value.start + signs, value.end, |out| out.extend(format!("Q{free}").bytes()));
        self.added += usize::from(self.edits.is_open(program.block_at(at)));
        Ok(true)
    }
}

/// One parameter for each axis that stands nowhere in a program, from the last one that programs share.
fn unused(source: &[u8]) -> Vec<usize> {
    let mut used = [false; SHARED.end];
    for at in memchr::memchr2_iter(b'Q', b'q', source) {
        let digits = source[at + 1..].iter().take_while(|byte| byte.is_ascii_digit());
        let number = digits.fold(None, |number: Option<usize>, byte| {
            Some(number.unwrap_or(0).saturating_mul(10).saturating_add(usize::from(byte - b'0')))
        });
        if let Some(used) = number.and_then(|number| used.get_mut(number)) {
            *used = true;
        }
    }
    SHARED.rev().filter(|number| !used[*number]).take(3).collect()
}

#[cfg(test)]
mod tests {
    use super::unused;

    #[test]
    fn a_parameter_that_stands_anywhere_is_used() {
        assert_eq!(unused(b"L X+Q1"), [99, 98, 97]);
        assert_eq!(unused(b"L X+q99 ;Q97\nQ098=5 Q9 Q1000 QL96"), [96, 95, 94]);
        assert_eq!(unused(&(3..100).map(|number| format!("Q{number} ")).collect::<String>().into_bytes()), [2, 1, 0]);
    }
}
