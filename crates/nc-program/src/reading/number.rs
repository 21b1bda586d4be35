//! Decimal numbers as controls write them: optional sign, digits, point, digits; no exponent.

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// The number that starts at `at` and the position after it; `None` without a digit.
///
/// Exactly rounded: up to 15 digits the quotient of two exact doubles is the nearest double (Clinger, "How to read
/// floating point numbers accurately", 1990); longer ones go the slow way.
#[inline]
pub fn read(bytes: &[u8], at: usize) -> Option<(f64, usize)> {
    let mut end = at;
    let negative = match bytes.get(at) {
        Some(b'-') => {
            end += 1;
            true
        }
        Some(b'+') => {
            end += 1;
            false
        }
        _ => false,
    };
    let first = end;
    let mut mantissa = 0u64;
    end = digits(bytes, end, &mut mantissa);
    let mut count = end - first;
    let mut decimals = 0;
    if bytes.get(end) == Some(&b'.') {
        let after = digits(bytes, end + 1, &mut mantissa);
        decimals = after - end - 1;
        count += decimals;
        end = after;
    }
    if count == 0 {
        return None;
    }
    let value = match POWERS.get(decimals) {
        Some(power) if count <= 15 => mantissa as i64 as f64 / power,
        _ => slow(bytes.get(first..end)?),
    };
    Some((if negative { -value } else { value }, end))
}

#[inline]
fn digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(digit) = bytes.get(at).map(|byte| byte.wrapping_sub(b'0')) {
        if digit > 9 {
            break;
        }
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

fn slow(text: &[u8]) -> f64 {
    std::str::from_utf8(text).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::read;
    use proptest::prelude::*;

    #[test]
    fn numbers_as_shops_write_them() {
        for (text, value) in [("00.03125", 0.03125), ("-.0625", -0.0625), ("+2.", 2.0), ("100", 100.0)] {
            assert_eq!(read(text.as_bytes(), 0), Some((value, text.len())));
        }
        for text in ["", "-", ".", "+.", "x"] {
            assert_eq!(read(text.as_bytes(), 0), None);
        }
    }

    proptest! {
        #[test]
        fn exactly_rounded(text in "[+-]?[0-9]{0,24}\\.[0-9]{1,24}", after in "([ -/:-~\\n][ -~\\n]{0,9})?") {
            let (value, end) = read(format!("{text}{after}").as_bytes(), 0).unwrap();
            prop_assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits());
            prop_assert_eq!(end, text.len());
        }
    }
}
