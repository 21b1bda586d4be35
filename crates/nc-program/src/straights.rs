//! Rapid moves and lines as blocks of text.

use std::io::Write;

/// How a control writes them.
#[derive(Clone, Debug)]
pub struct Style {
    /// What a rapid move and what a line begins with.
    pub codes: [String; 2],
    /// What ends a rapid move.
    pub rapid_end: String,
    /// Millimetres in one unit of X, Y and Z.
    pub unit_mm: [f64; 3],
    /// Decimals of positions.
    pub decimals: usize,
    /// What a feed is divided by, and its decimals.
    pub feed: (f64, usize),
    /// As Klartext writes numbers: with their sign, whole ones without a point.
    pub signed: bool,
}

/// Some moves, an entry each.
#[derive(Clone, Copy, Debug)]
pub struct Moves<'a> {
    /// Where they end, mm; NaN along an axis that is not written.
    pub end: &'a [[f64; 3]],
    /// Which are rapid.
    pub rapid: &'a [bool],
    /// The feed, NaN for none.
    pub feed: &'a [f64],
}

/// What is in force before and after the blocks.
#[derive(Clone, Debug)]
pub struct Standing {
    /// Where they have the tool, mm; NaN along an axis that was not positioned.
    pub at: [f64; 3],
    /// The largest distance along an axis by which a position was rounded, mm.
    pub rounded: f64,
    /// The feed word that the moves are to have.
    pub wanted_feed: String,
    /// The feed word that the control has.
    pub feed: String,
}

/// Appends a line for each move that ends somewhere, with `first` before the feed of the first.
pub fn write_straights(out: &mut Vec<u8>, style: &Style, moves: Moves, mut first: &str, now: &mut Standing) {
    let mut feed_written = f64::NAN;
    for ((end, rapid), feed) in moves.end.iter().zip(moves.rapid).zip(moves.feed) {
        if end.iter().all(|at| at.is_nan()) {
            continue;
        }
        out.extend_from_slice(style.codes[usize::from(!rapid)].as_bytes());
        for (axis, at) in end.iter().enumerate() {
            write_position(out, style, axis, *at, now);
        }
        if *feed != feed_written && !feed.is_nan() {
            feed_written = *feed;
            now.wanted_feed = feed_word(style, *feed);
        }
        word(out, std::mem::take(&mut first));
        if *rapid {
            word(out, &style.rapid_end);
        } else if now.wanted_feed != now.feed {
            word(out, &now.wanted_feed);
            now.feed.clone_from(&now.wanted_feed);
        }
        out.push(b'\n');
    }
}

fn word(out: &mut Vec<u8>, text: &str) {
    if !text.is_empty() {
        out.push(b' ');
        out.extend_from_slice(text.as_bytes());
    }
}

fn write_position(out: &mut Vec<u8>, style: &Style, axis: usize, value: f64, now: &mut Standing) {
    if value.is_nan() {
        return;
    }
    out.extend_from_slice(&[b' ', b"XYZ"[axis]]);
    let start = out.len();
    write_number(out, value / style.unit_mm[axis], style.decimals);
    let text = std::str::from_utf8(&out[start..]).unwrap_or_default();
    now.at[axis] = text.parse().unwrap_or(f64::NAN) * style.unit_mm[axis];
    now.rounded = now.rounded.max((now.at[axis] - value).abs());
    if style.signed {
        let negative = out[start..].starts_with(b"-");
        let whole = out[start..].ends_with(b".0");
        out.truncate(out.len() - if whole { 2 } else { 0 });
        if !negative {
            out.insert(start, b'+');
        }
    }
}

fn feed_word(style: &Style, feed: f64) -> String {
    let mut out = vec![b'F'];
    write_number(&mut out, feed / style.feed.0, style.feed.1);
    let text = String::from_utf8(out).unwrap_or_default();
    let whole = text.strip_suffix(".0").filter(|_| style.signed);
    whole.unwrap_or(&text).to_owned()
}

/// With a point and a digit after it; rounded exactly, half to even; zero has no sign.
fn write_number(out: &mut Vec<u8>, value: f64, decimals: usize) {
    let start = out.len();
    let done = write!(out, "{value:.decimals$}");
    debug_assert!(done.is_ok()); // writing to memory does not fail
    if decimals > 0 {
        let zeros = out[start..].iter().rev().take_while(|byte| **byte == b'0').count();
        out.truncate(out.len() - zeros);
    } else {
        out.push(b'.');
    }
    if out.last() == Some(&b'.') {
        out.push(b'0');
    }
    if out[start..].iter().all(|byte| matches!(byte, b'-' | b'0' | b'.')) {
        out.truncate(start);
        out.extend_from_slice(b"0.0");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOT: f64 = f64::NAN;

    fn style(signed: bool, decimals: usize) -> Style {
        let codes = if signed { ["L".to_owned(), "L".to_owned()] } else { ["G00".to_owned(), "G01".to_owned()] };
        let rapid_end = if signed { "FMAX".to_owned() } else { String::new() };
        Style { codes, rapid_end, unit_mm: [0.5, 1.0, 1.0], decimals, feed: (1.0, 3), signed }
    }

    fn written(style: &Style, first: &str) -> (String, Standing) {
        let mut now = Standing { at: [NOT; 3], rounded: 0.0, wanted_feed: String::new(), feed: String::new() };
        let end = [[1.0, -2.5, NOT], [NOT; 3], [NOT, NOT, -0.00001], [0.12345, NOT, 7.0]];
        let (rapid, feed) = ([true, false, false, false], [NOT, 900.0, 100.0, 100.0]);
        let mut out = Vec::new();
        write_straights(&mut out, style, Moves { end: &end, rapid: &rapid, feed: &feed }, first, &mut now);
        (String::from_utf8(out).unwrap(), now)
    }

    #[test]
    fn g_code_has_a_point_in_every_number_and_a_feed_where_it_is_new() {
        let (text, now) = written(&style(false, 3), "");
        assert_eq!(text, "G00 X2.0 Y-2.5\nG01 Z0.0 F100.0\nG01 X0.247 Z7.0\n");
        assert_eq!(now.at, [0.1235, -2.5, 7.0]);
        assert!((now.rounded - 0.00005).abs() < 1e-12);
        assert_eq!((now.wanted_feed.as_str(), now.feed.as_str()), ("F100.0", "F100.0"));
        assert_eq!(written(&style(false, 0), "").0, "G00 X2.0 Y-2.0\nG01 Z0.0 F100.0\nG01 X0.0 Z7.0\n");
    }

    #[test]
    fn klartext_has_signs_and_whole_numbers_without_a_point() {
        let text = written(&style(true, 4), "R0").0;
        assert_eq!(text, "L X+2 Y-2.5 R0 FMAX\nL Z+0 F100\nL X+0.2469 Z+7\n");
    }
}
