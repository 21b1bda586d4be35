//! Numbers as text, in steps of the control's resolution.

use nc_program::dialect::{FlowStyle, Letters, Naming};
use nc_program::{Dialect, Program, WordKind};

use crate::value::closes_at_end;

/// Letters of coordinates.
const LENGTHS: Letters = Letters::of(b"XYZUVWIJKR");

/// No control resolves more.
const MOST_DECIMALS: usize = 9;

/// More of a control's steps than any machine is long.
const MOST_STEPS: f64 = 1e15;

/// The smallest programmable step in a program unit, how many decimals it has, and how numbers are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Its size in program units.
    pub unit: f64,
    /// How many decimals it has.
    pub decimals: usize,
    /// Steps in a program unit.
    scale: f64,
    /// Klartext writes the sign of what is positive.
    plus: bool,
    /// Its decimal point: some of its controls take a comma.
    point: u8,
}

impl Step {
    /// Of an inch or a metric program; `comma` as [`writes_comma`] says; with so many decimals at least.
    pub fn new(dialect: &Dialect, inch: bool, comma: bool, decimals: usize) -> Self {
        let unit = if inch { dialect.resolution.0 } else { dialect.resolution.1 };
        Self::of(dialect, unit.min(10f64.powi(-(decimals.min(MOST_DECIMALS) as i32))), comma)
    }

    /// Of that size, in program units: a program may write finer than its control resolves.
    pub fn of(dialect: &Dialect, unit: f64, comma: bool) -> Self {
        let decimals = (-unit.log10()).round().max(0.0) as usize;
        let plus = dialect.flow == FlowStyle::Labels;
        Self { unit, decimals, scale: 10f64.powi(decimals as i32), plus, point: if comma { b',' } else { b'.' } }
    }

    /// The number of steps nearest to a value in program units, halves to even.
    #[inline]
    pub fn round(&self, value: f64) -> i64 {
        const LAST_BIT_IS_ONE: f64 = 6_755_399_441_055_744.0; // 1.5·2⁵²: the sum is rounded to a whole number
        let steps = value * self.scale;
        if steps.abs() < 1e15 {
            return (steps + LAST_BIT_IS_ONE - LAST_BIT_IS_ONE) as i64; // `round_ties_even` is a function call
        }
        steps.round_ties_even() as i64
    }

    /// The same, refused by message and hint where no machine is that long.
    pub fn reachable(&self, value: f64) -> Result<i64, (String, String)> {
        if value * self.scale < MOST_STEPS && value * self.scale > -MOST_STEPS {
            return Ok(self.round(value));
        }
        let hint = "look for a slip in the program, or in its unit";
        Err((format!("a coordinate of {value:e} is further than a control could go"), hint.to_owned()))
    }

    /// The value of that many steps: the double nearest to the decimal number.
    pub fn value(&self, steps: i64) -> f64 {
        steps as f64 / self.scale
    }

    /// Writes a number as one that is new.
    pub fn write(&self, out: &mut Vec<u8>, steps: i64) {
        self.signed(out, steps, self.plus, 0, 1);
    }

    /// With at least `decimals` decimals and `digits` digits before the point; the plus sign where it is wanted.
    fn signed(&self, out: &mut Vec<u8>, steps: i64, plus: bool, decimals: usize, digits: usize) {
        if steps < 0 {
            out.push(b'-');
        } else if plus {
            out.push(b'+');
        }
        // Written from the last digit on: twenty digits and a point are the most.
        let (mut text, mut first, mut rest) = ([0; 32], 32, steps.unsigned_abs());
        let mut write = |byte: u8| {
            first = (first - 1) % 32;
            text[first] = byte;
        };
        if decimals.max(self.decimals) > 0 {
            for _ in 0..self.decimals {
                write(b'0' + (rest % 10) as u8);
                rest /= 10;
            }
            write(self.point);
        }
        let mut before = 0;
        while rest > 0 || before == 0 && digits > 0 {
            write(b'0' + (rest % 10) as u8);
            rest /= 10;
            before += 1;
        }
        out.resize(out.len() + digits.saturating_sub(before), b'0');
        out.extend_from_slice(&text[first..]);
        out.resize(out.len() + decimals.saturating_sub(self.decimals), b'0');
    }

    /// A number in the style of an old one: its sign habit, leading zeros, and at least as many decimals.
    pub fn restyle(&self, out: &mut Vec<u8>, old: &[u8], steps: i64) {
        let mut point = false;
        let (mut whole, mut decimals, mut leading_zero) = (0, 0, false);
        for byte in old {
            match byte {
                b'0'..=b'9' if point => decimals += 1,
                b'0'..=b'9' => {
                    leading_zero |= whole == 0 && *byte == b'0';
                    whole += 1;
                }
                b'.' | b',' => point = true,
                _ => {}
            }
        }
        let plus = old.first() == Some(&b'+') || self.plus && old.first() == Some(&b'-');
        let digits = if leading_zero { whole } else { usize::from(whole > 0) };
        self.signed(out, steps, plus, decimals, digits);
    }

    /// An expression plus a term: inside its own brackets, in new ones where it has none, behind it where it needs none.
    pub fn with_term(&self, out: &mut Vec<u8>, old: &[u8], steps: i64, dialect: &Dialect) {
        let (open, close) = dialect.brackets;
        let (whole, weak) = (closes_at_end(old, open, close), compares(old, dialect));
        if weak && !whole {
            return self.with_term(out, &[&[open], old, &[close]].concat(), steps, dialect);
        }
        let inside = old.strip_suffix(&[close]).filter(|_| whole && !weak);
        let bare = dialect.formulas && !whole;
        if inside.is_none() && !bare {
            out.push(open);
        }
        out.extend(inside.unwrap_or(old));
        self.signed(out, steps, true, 0, 1);
        let zeros = out.iter().rev().take_while(|byte| **byte == b'0').count();
        out.truncate(out.len() - zeros);
        if !bare {
            out.push(close);
        }
    }
}

/// How many decimals the coordinates of a program have, nine at most: a correction is never coarser than they are.
pub fn written_decimals(program: &Program) -> usize {
    let mut most = 0;
    for word in program.words() {
        if word.kind == WordKind::Number && LENGTHS.has(word.letter) && usize::from(word.length) > most + 2 {
            let point = |text: &[u8]| memchr::memchr2(b'.', b',', text);
            let text = program.text(word);
            let decimals =
                point(text).map_or(0, |at| text[at + 1..].iter().filter(|byte| byte.is_ascii_digit()).count());
            most = most.max(decimals);
        }
    }
    most.min(MOST_DECIMALS)
}

/// Whether a program of Klartext writes decimal commas.
pub fn writes_comma(program: &Program) -> bool {
    let mut numbers = program.words().iter().filter(|word| word.kind == WordKind::Number);
    program.dialect().flow == FlowStyle::Labels && numbers.any(|word| program.text(word).contains(&b','))
}

/// Whether operators that bind more weakly than a sum may be in the text: EQ, NE, GT, GE, LT, LE, OR, XOR, AND, and the
/// signs of Sinumerik's comparisons. What stands between angle brackets is a name.
fn compares(text: &[u8], dialect: &Dialect) -> bool {
    if dialect.parameters.named != Naming::Brackets {
        return dialect.formulas && text.iter().any(|byte| b"<>=".contains(byte)) || says_weak(text);
    }
    text.split(|byte| b"<>".contains(byte)).step_by(2).any(says_weak)
}

fn says_weak(text: &[u8]) -> bool {
    let weak = |two: &[u8]| {
        matches!(
            [two[0].to_ascii_lowercase(), two[1].to_ascii_lowercase()],
            [b'e', b'q'] | [b'n', b'e'] | [b'g' | b'l', b't' | b'e'] | [b'o', b'r']
        )
    };
    text.windows(2).any(weak) || text.windows(3).any(|three| three.eq_ignore_ascii_case(b"and"))
}

#[cfg(test)]
mod tests {
    use super::Step;
    use nc_program::dialect::{GE2000T, LINUXCNC, SIEMENS};
    use proptest::prelude::*;

    const STEP: Step = Step { unit: 0.001, decimals: 3, scale: 1000.0, plus: false, point: b'.' };

    fn restyled(old: &str, steps: i64) -> String {
        let mut out = Vec::new();
        STEP.restyle(&mut out, old.as_bytes(), steps);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_programmers_style_stays() {
        for (old, steps, new) in [
            ("3.2", 3_250, "3.250"),
            ("3.20000", -3_250, "-3.25000"),
            ("+2.", 2_001, "+2.001"),
            ("-.5", 499, ".499"),
            ("00.25", 251, "00.251"),
            ("-0.1", 99, "0.099"),
            ("10", 10_010, "10.010"),
            ("+1", -5, "-0.005"),
        ] {
            assert_eq!(restyled(old, steps), new, "{old}");
        }
    }

    #[test]
    fn klartext_writes_its_signs_and_keeps_its_comma() {
        let klartext = Step { plus: true, point: b',', ..STEP };
        for (old, steps, new) in [("+2,5", 2_501, "+2,501"), ("-0,1", 1, "+0,001"), ("7", 7_001, "7,001")] {
            let mut out = Vec::new();
            klartext.restyle(&mut out, old.as_bytes(), steps);
            assert_eq!(String::from_utf8(out).unwrap(), new, "{old}");
        }
        let mut out = Vec::new();
        klartext.write(&mut out, 1);
        assert_eq!(out, b"+0,001");
    }

    #[test]
    fn terms_go_into_the_programmers_brackets() {
        for (dialect, old, new) in [
            (&LINUXCNC, "[#1+2]", "[#1+2-0.012]"),
            (&LINUXCNC, "#1", "[#1-0.012]"),
            (&LINUXCNC, "[#1]*[2]", "[[#1]*[2]-0.012]"),
            (&LINUXCNC, "[#1 GT 2]", "[[#1 GT 2]-0.012]"),
            (&LINUXCNC, "[#<scale>*[#1]]", "[#<scale>*[#1]-0.012]"),
            (&LINUXCNC, "[#<scale>LE#<b>]", "[[#<scale>LE#<b>]-0.012]"),
            (&SIEMENS, "(R1>2)", "((R1>2)-0.012)"),
            (&SIEMENS, "(R1*2)", "(R1*2-0.012)"),
            (&SIEMENS, "5", "5-0.012"),
            (&SIEMENS, "R1+10", "R1+10-0.012"),
            (&SIEMENS, "(R1+1)*2", "(R1+1)*2-0.012"),
            (&SIEMENS, "R1 B_AND 6", "((R1 B_AND 6)-0.012)"),
            (&GE2000T, "(P46+0.0625)", "(P46+0.0625-0.012)"),
        ] {
            let mut out = Vec::new();
            STEP.with_term(&mut out, old.as_bytes(), -12, dialect);
            assert_eq!(String::from_utf8(out).unwrap(), new);
        }
    }

    proptest! {
        #[test]
        fn rounding_is_that_of_the_standard(value in prop_oneof![-1e6..1e6f64, -1e19..1e19f64, (-9999i32..9999).prop_map(|half| f64::from(half) / 2e3)]) {
            prop_assert_eq!(STEP.round(value), (value * 1000.0).round_ties_even() as i64);
        }

        #[test]
        fn what_is_written_is_the_value(steps in -999_999_999i64..999_999_999, old in "[+-]?[0-9]{1,4}(\\.[0-9]{0,6})?") {
            let written: f64 = restyled(&old, steps).parse().unwrap();
            prop_assert_eq!(written, STEP.value(steps));
            prop_assert_eq!(STEP.round(written), steps);
        }
    }
}
