//! Rows of numbers and names as lines of comma-separated text.

use std::io::Write;
use std::ops::Range;

/// Below this size a whole number is exact as an integer.
const EXACT: f64 = 9e15;

/// A column of a table.
#[derive(Debug, Clone, Copy)]
pub enum Column<'a> {
    /// Numbers with at most so many decimals, trailing zeros left out; an empty cell for NaN.
    Number(&'a [f64], usize),
    /// Names, by index.
    Name(&'a [u32], &'a [String]),
}

/// Appends those rows, a line each.
///
/// # Panics
/// When a column is shorter than that, or a name has no such index.
pub fn write_rows(out: &mut Vec<u8>, columns: &[Column], rows: Range<usize>) {
    for row in rows {
        for (index, column) in columns.iter().enumerate() {
            if index > 0 {
                out.push(b',');
            }
            match *column {
                Column::Number(values, decimals) => write_number(out, values[row], decimals),
                Column::Name(which, names) => {
                    out.extend_from_slice(names[which[row] as usize].as_bytes());
                }
            }
        }
        out.push(b'\n');
    }
}

/// Rounded as `printf` does, exactly and half to even; zero has no sign.
fn write_number(out: &mut Vec<u8>, value: f64, decimals: usize) {
    let start = out.len();
    if value.is_nan() {
        return;
    }
    if value.trunc() == value && value.abs() < EXACT {
        #[allow(clippy::cast_possible_truncation)] // a whole number below 2^53
        let whole = value as i64;
        return written(write!(out, "{whole}"));
    }
    written(write!(out, "{value:.decimals$}"));
    if out[start..].contains(&b'.') {
        let kept = out.iter().rposition(|&byte| byte != b'0');
        out.truncate(kept.map_or(start, |at| at + usize::from(out[at] != b'.')));
    }
    if out[start..] == *b"-0" {
        out.remove(start);
    }
}

/// Writing to memory does not fail.
fn written(done: std::io::Result<()>) {
    debug_assert!(done.is_ok());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: f64, decimals: usize) -> String {
        let mut out = Vec::new();
        write_number(&mut out, value, decimals);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_are_rounded_half_to_even_and_shortened() {
        let cases = [
            (25.4, "25.4"),
            (-100.0, "-100"),
            (-0.0, "0"),
            (-1e-12, "0"),
            (1.0 / 1024.0, "0.000976562"),
            (3.0 / 1024.0, "0.002929688"),
            (0.999_999_999_9, "1"),
            (-19.999_999_999_99, "-20"),
            (1e300, &format!("{:.0}", 1e300)),
            (f64::INFINITY, "inf"),
            (f64::NAN, ""),
        ];
        for (value, expected) in cases {
            assert_eq!(text(value, 9), expected);
        }
    }

    #[test]
    fn rows_of_a_part_of_the_table() {
        let names = ["rapid".to_owned(), "line".to_owned()];
        let columns = [Column::Number(&[1.0, 2.5, f64::NAN], 9), Column::Name(&[0, 1, 0], &names)];
        let mut out = Vec::new();
        write_rows(&mut out, &columns, 1..3);
        assert_eq!(out, b"2.5,line\n,rapid\n");
    }
}
