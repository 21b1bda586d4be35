extern crate std;

use std::vec::Vec;

use super::*;
use crate::built::{file, hash, words, BODY, PROGRAM, ROWS, SLOPE};
use crate::names::{FAULTS, REFUSALS};

const MACHINE: Expected<'_> = Expected {
    serial: Some(b"4711"),
    program: Some(PROGRAM),
};

fn refusal(bytes: &[u8]) -> Option<Refusal> {
    Image::read(bytes, MACHINE).err()
}

/// A file with one word changed.
fn changed(place: usize, value: f64) -> Vec<u8> {
    let mut words = words();
    words[place] = value;
    file(&words)
}

#[test]
fn a_good_one_is_read_wherever_it_lies() {
    let bytes = file(&words());
    for shift in 0..8 {
        let mut moved = std::vec![0; shift];
        moved.extend(&bytes);
        assert_eq!(refusal(&moved[shift..]), None);
    }
    assert!(Image::read(&bytes, Expected::default()).is_ok());
}

#[test]
fn whatever_is_changed_is_seen() {
    // every byte, under miri some of them
    let bytes = file(&words());
    let step = if cfg!(miri) { 499 } else { 1 };
    for place in (0..bytes.len()).step_by(step) {
        let mut other = bytes.clone();
        other[place] ^= 1;
        assert!(refusal(&other).is_some(), "byte {place}");
        assert!(refusal(&bytes[..place]).is_some(), "{place} bytes");
    }
}

#[test]
fn each_fault_by_its_name_and_the_first_of_several() {
    let good = file(&words());
    let with = |change: fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        refusal(&bytes)
    };
    assert_eq!(refusal(&[]), Some(Refusal::Empty));
    assert_eq!(with(|b| b[0] = b'X'), Some(Refusal::Magic));
    assert_eq!(with(|b| b[8] = 2), Some(Refusal::Version));
    assert_eq!(with(|b| b[24] = 1), Some(Refusal::Version));
    assert_eq!(with(|b| b.truncate(1023)), Some(Refusal::Short));
    assert_eq!(with(|b| b[16] = 0), Some(Refusal::Long));
    assert_eq!(with(|b| b[23] = 255), Some(Refusal::Short));
    assert_eq!(with(|b| b[64] = 1), Some(Refusal::Hash));
    let other_serial = with(|b| {
        b[131] = b'2';
        hash(b);
    });
    assert_eq!(other_serial, Some(Refusal::Serial));
    let other_program = with(|b| {
        b[224] ^= 1;
        hash(b);
    });
    assert_eq!(other_program, Some(Refusal::Program));
    let of_no_program = with(|b| {
        b[224..256].fill(0);
        hash(b);
    });
    assert_eq!(of_no_program, Some(Refusal::Program));
    let odd = with(|b| {
        b.push(0);
        let count = b.len() as u64;
        b[16..24].copy_from_slice(&count.to_le_bytes());
        hash(b);
    });
    assert_eq!(odd, Some(Refusal::Odd));
}

#[test]
fn numbers_that_make_no_function() {
    let found = |place, value| refusal(&changed(place, value));
    assert_eq!(found(SLOPE, f64::NAN), Some(Refusal::NotFinite));
    assert_eq!(found(SLOPE, 1.1), Some(Refusal::Limits));
    assert_eq!(found(SLOPE + 9, 0.1), Some(Refusal::Limits)); // at 35, 15 above the reference
    assert_eq!(found(0, 0.0), Some(Refusal::Limits));
    assert_eq!(found(2, 201.0), Some(Refusal::Limits));
    assert_eq!(found(11, 17.0), Some(Refusal::Count));
    assert_eq!(found(BODY, 3.0), Some(Refusal::Count));
    assert_eq!(found(BODY + 2, 2.0), Some(Refusal::Count));
    assert_eq!(found(BODY + 12, -300.0), Some(Refusal::Body));
    assert_eq!(found(BODY + 14, 1001.0), Some(Refusal::Body));
    assert_eq!(found(BODY + 26, 1.0), Some(Refusal::Count)); // its signal
    assert_eq!(found(BODY + 27, 70.0), Some(Refusal::Body));
    assert_eq!(found(ROWS - 3, 1.0), Some(Refusal::Order));
    assert_eq!(found(ROWS - 3, 0.0), Some(Refusal::Count));
    assert_eq!(found(ROWS - 1, 4.0), Some(Refusal::Count));
    assert_eq!(found(ROWS + 3, 1001.0), Some(Refusal::Limits));
}

#[test]
fn widths_count_in_what_a_polynomial_reaches() {
    let mut words = words();
    words[BODY + 1] = 2.0; // one segment of two powers, 300 wide
    words[BODY + 3] = 2.0;
    words.remove(BODY + 12);
    assert_eq!(refusal(&file(&words)), None);
    words[BODY + 13 + 6] = 4.0;
    assert_eq!(refusal(&file(&words)), Some(Refusal::Body));
}

#[test]
fn a_narrow_segment_hides_no_coefficient_that_overflows_times_a_signal() {
    let mut words = words();
    words[BODY + 1] = 2.0; // one segment of two powers, 1e-306 wide, where 1e307 reaches 10 mm
    words[BODY + 3] = 2.0;
    words[BODY + 11] = 0.0;
    words[BODY + 12] = 1e-306;
    words.remove(BODY + 13);
    assert_eq!(refusal(&file(&words)), None);
    words[BODY + 13 + 12 + 1 + 6] = 1e307; // of the signal, which may be 15 above its reference
    assert_eq!(refusal(&file(&words)), Some(Refusal::Body));
}

#[test]
fn every_number_has_a_name_of_its_own() {
    for names in [&REFUSALS[..], &FAULTS] {
        for (k, (number, text)) in names.iter().enumerate() {
            assert_eq!(*number, k as i32);
            assert!(text.to_str().unwrap().contains(": "));
        }
    }
    let name = |refusal: Refusal| {
        crate::names::text(&REFUSALS, refusal as i32)
            .to_str()
            .unwrap()
    };
    assert!(name(Refusal::Magic).starts_with("magic:"));
    assert!(name(Refusal::Odd).starts_with("odd:"));
    assert!(name(Refusal::Long).starts_with("long:"));
    assert!(name(Refusal::NotFinite).starts_with("not finite:"));
    assert!(name(Refusal::Limits).starts_with("limits:"));
}
