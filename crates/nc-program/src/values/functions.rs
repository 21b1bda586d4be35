//! Operators and functions of expressions.

use crate::values::expression::counted;

/// An operator and how strongly it binds.
#[derive(Clone, Copy)]
pub(crate) struct Operator {
    /// As it is written, in lower case.
    pub text: &'static [u8],
    /// Operators of a higher number bind first; equals from left to right.
    pub strength: u8,
    /// The value, or what is wrong.
    pub apply: fn(f64, f64) -> Result<f64, &'static str>,
}

/// The four operations that every dialect has.
pub(crate) const ARITHMETIC: [Operator; 4] = [
    Operator { text: b"+", strength: 3, apply: |a, b| Ok(a + b) },
    Operator { text: b"-", strength: 3, apply: |a, b| Ok(a - b) },
    Operator { text: b"*", strength: 4, apply: |a, b| Ok(a * b) },
    Operator { text: b"/", strength: 4, apply: |a, b| divided(a, b, a / b) },
];

/// Those that RS-274 has besides; `**` is to be looked for before `*`.
pub(crate) const RS274: [Operator; 11] = [
    Operator { text: b"**", strength: 5, apply: power },
    Operator { text: b"mod", strength: 4, apply: |a, b| divided(a, b, a.rem_euclid(b)) },
    Operator { text: b"eq", strength: 2, apply: |a, b| truth((a - b).abs() < EQUAL) },
    Operator { text: b"ne", strength: 2, apply: |a, b| truth((a - b).abs() >= EQUAL) },
    Operator { text: b"gt", strength: 2, apply: |a, b| truth(a > b) },
    Operator { text: b"ge", strength: 2, apply: |a, b| truth(a >= b) },
    Operator { text: b"lt", strength: 2, apply: |a, b| truth(a < b) },
    Operator { text: b"le", strength: 2, apply: |a, b| truth(a <= b) },
    Operator { text: b"and", strength: 1, apply: |a, b| truth(a != 0.0 && b != 0.0) },
    Operator { text: b"xor", strength: 1, apply: |a, b| truth((a != 0.0) != (b != 0.0)) },
    Operator { text: b"or", strength: 1, apply: |a, b| truth(a != 0.0 || b != 0.0) },
];

/// Those of custom macro B: AND binds as a product, OR and XOR as a sum, all three bit by bit.
pub(crate) const MACRO: [Operator; 10] = [
    Operator { text: b"mod", strength: 4, apply: |a, b| divided(a, b, a % b) },
    Operator { text: b"and", strength: 4, apply: |a, b| bits(a, b, |a, b| a & b) },
    Operator { text: b"xor", strength: 3, apply: |a, b| bits(a, b, |a, b| a ^ b) },
    Operator { text: b"or", strength: 3, apply: |a, b| bits(a, b, |a, b| a | b) },
    Operator { text: b"eq", strength: 1, apply: |a, b| truth(same(a, b)) },
    Operator { text: b"ne", strength: 1, apply: |a, b| truth(!same(a, b)) },
    Operator { text: b"gt", strength: 1, apply: |a, b| greater(a, b, |a, b| a > b) },
    Operator { text: b"ge", strength: 1, apply: |a, b| greater(a, b, |a, b| a >= b) },
    Operator { text: b"lt", strength: 1, apply: |a, b| greater(a, b, |a, b| a < b) },
    Operator { text: b"le", strength: 1, apply: |a, b| greater(a, b, |a, b| a <= b) },
];

/// Those of Sinumerik, in the order of its manual: comparisons bind least, so that `(R1>0) AND (R2>0)` needs its brackets.
pub(crate) const SIEMENS: [Operator; 19] = [
    Operator { text: b"*", strength: 10, apply: |a, b| Ok(a * b) },
    Operator { text: b"/", strength: 10, apply: |a, b| divided(a, b, a / b) },
    Operator { text: b"div", strength: 10, apply: |a, b| divided(a, b, (a / b).trunc()) },
    Operator { text: b"mod", strength: 10, apply: |a, b| divided(a, b, a % b) },
    Operator { text: b"+", strength: 9, apply: |a, b| Ok(a + b) },
    Operator { text: b"-", strength: 9, apply: |a, b| Ok(a - b) },
    Operator { text: b"b_and", strength: 8, apply: |a, b| bits(a, b, |a, b| a & b) },
    Operator { text: b"b_xor", strength: 7, apply: |a, b| bits(a, b, |a, b| a ^ b) },
    Operator { text: b"b_or", strength: 6, apply: |a, b| bits(a, b, |a, b| a | b) },
    Operator { text: b"and", strength: 5, apply: |a, b| logical(a, b, a != 0.0 && b != 0.0) },
    Operator { text: b"xor", strength: 4, apply: |a, b| logical(a, b, (a != 0.0) != (b != 0.0)) },
    Operator { text: b"or", strength: 3, apply: |a, b| logical(a, b, a != 0.0 || b != 0.0) },
    Operator { text: b"<<", strength: 2, apply: |_, _| Ok(f64::NAN) },
    Operator { text: b"==", strength: 1, apply: |a, b| logical(a, b, near(a, b)) },
    Operator { text: b"<>", strength: 1, apply: |a, b| logical(a, b, !near(a, b)) },
    Operator { text: b">=", strength: 1, apply: |a, b| logical(a, b, a >= b) },
    Operator { text: b"<=", strength: 1, apply: |a, b| logical(a, b, a <= b) },
    Operator { text: b">", strength: 1, apply: |a, b| logical(a, b, a > b) },
    Operator { text: b"<", strength: 1, apply: |a, b| logical(a, b, a < b) },
];

/// Those of Klartext; FN 8 is written with LEN, FN 13 with ANG.
pub(crate) const KLARTEXT: [Operator; 5] = [
    Operator { text: b"%", strength: 4, apply: |a, b| divided(a, b, a % b) },
    Operator { text: b"^", strength: 5, apply: power },
    Operator { text: b"div", strength: 4, apply: |a, b| divided(a, b, a / b) },
    Operator { text: b"len", strength: 4, apply: |a, b| Ok(a.hypot(b)) },
    Operator { text: b"ang", strength: 4, apply: |a, b| Ok(a.atan2(b).to_degrees().rem_euclid(360.0)) },
];

/// Klartext's functions, whose argument needs no brackets; angles in degrees.
pub(crate) fn klartext(name: &[u8], argument: f64) -> Option<f64> {
    match name {
        b"sq" => Some(argument * argument),
        b"neg" => Some(-argument),
        b"int" => Some(argument.trunc()),
        b"frac" => Some(argument.fract()),
        b"log" => Some(argument.log10()),
        b"sgn" => Some(if argument == 0.0 { 0.0 } else { argument.signum() }),
        b"atan" => Some(argument.atan().to_degrees()),
        b"abs" | b"acos" | b"asin" | b"cos" | b"exp" | b"ln" | b"sin" | b"sqrt" | b"tan" => function(name, argument),
        _ => None,
    }
}

/// Sinumerik compares real numbers with a relative tolerance of this size.
const NEAR: f64 = 1e-12;

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= NEAR * a.abs().max(b.abs())
}

/// A truth; what is not known stays so.
#[allow(clippy::unnecessary_wraps)] // the type of `Operator::apply`
fn logical(a: f64, b: f64, holds: bool) -> Result<f64, &'static str> {
    Ok(if a.is_nan() || b.is_nan() { f64::NAN } else { f64::from(u8::from(holds)) })
}

/// Compares sizes: a parameter without a value counts as zero.
fn greater(a: f64, b: f64, compare: fn(f64, f64) -> bool) -> Result<f64, &'static str> {
    let (a, b) = (counted(a), counted(b));
    logical(a, b, compare(a, b))
}

/// Two parameters without a value are equal: `#1 EQ #0`.
#[allow(clippy::float_cmp)] // the control compares exactly
fn same(a: f64, b: f64) -> bool {
    a == b || a.is_nan() && b.is_nan()
}

#[allow(clippy::unnecessary_wraps)] // the type of `Operator::apply`
fn bits(a: f64, b: f64, apply: fn(i64, i64) -> i64) -> Result<f64, &'static str> {
    Ok(if a.is_nan() || b.is_nan() { f64::NAN } else { apply(a.round() as i64, b.round() as i64) as f64 })
}

/// LinuxCNC takes two numbers for equal that differ by less.
const EQUAL: f64 = 1e-4;

#[allow(clippy::unnecessary_wraps)] // the type of `Operator::apply`
fn truth(holds: bool) -> Result<f64, &'static str> {
    Ok(f64::from(u8::from(holds)))
}

fn divided(_: f64, by: f64, result: f64) -> Result<f64, &'static str> {
    if by == 0.0 {
        Err("division by zero")
    } else {
        Ok(result)
    }
}

pub(crate) fn power(base: f64, exponent: f64) -> Result<f64, &'static str> {
    if base < 0.0 && exponent.fract() != 0.0 {
        Err("a negative number to a fractional power")
    } else {
        Ok(base.powf(exponent))
    }
}

/// RS-274's functions of one argument, named in lower case; angles in degrees. `None`: there is no such function.
pub(crate) fn function(name: &[u8], argument: f64) -> Option<f64> {
    Some(match name {
        b"abs" => argument.abs(),
        b"acos" => argument.acos().to_degrees(),
        b"asin" => argument.asin().to_degrees(),
        b"cos" => argument.to_radians().cos(),
        b"exp" => argument.exp(),
        b"fix" => argument.floor(),
        b"fup" => argument.ceil(),
        b"ln" => argument.ln(),
        b"round" => argument.round(),
        b"sin" => argument.to_radians().sin(),
        b"sqrt" => argument.sqrt(),
        b"tan" => argument.to_radians().tan(),
        _ => return None,
    })
}

/// Names that stand for a value, in lower case.
pub(crate) fn constant(name: &[u8]) -> Option<f64> {
    match name {
        b"true" => Some(1.0),
        b"false" => Some(0.0),
        b"$pi" | b"pi" => Some(std::f64::consts::PI),
        _ => None,
    }
}

/// Sinumerik's functions, named in lower case; angles in degrees. `AC`, `IC` and their like keep the value: what they
/// say of it is read off the word. `None`: there is no such function of that many arguments.
pub(crate) fn of_arguments(name: &[u8], arguments: &[f64]) -> Option<f64> {
    match (name, arguments) {
        (b"ac" | b"ic" | b"dc" | b"acp" | b"acn", [value]) => Some(*value),
        (b"pot", [value]) => Some(value * value),
        (b"trunc", [value]) => Some(value.trunc()),
        (b"roundup", [value]) => Some(value.ceil()),
        (b"atan2", [y, x]) => Some(y.atan2(*x).to_degrees()),
        (b"minval", [a, b]) => Some(a.min(*b)),
        (b"maxval", [a, b]) => Some(a.max(*b)),
        (b"bound", [low, high, value]) => Some(value.max(*low).min(*high)),
        (b"fix" | b"fup", _) => None,
        (name, [argument]) => function(name, *argument),
        _ => None,
    }
}

/// Functions of custom macro B where they differ: FIX drops the fraction, FUP rounds away from zero.
pub(crate) fn macro_function(name: &[u8], argument: f64) -> Option<f64> {
    match name {
        b"fix" => Some(argument.trunc()),
        b"fup" => Some(argument.abs().ceil().copysign(argument)),
        _ => function(name, argument),
    }
}
