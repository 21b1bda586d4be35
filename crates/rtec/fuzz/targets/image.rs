//! Bytes as an image: read as they are, and with length and hash made right, so that the reader comes to the numbers. What is
//! taken is stepped through places within and beyond it: every number that comes of it is finite, every correction within
//! its limit.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rtec::corrector::{Corrector, Inputs, Settings};
use rtec::image::{Expected, Image};
use rtec::wanted::{Asked, Place, SIGNALS};
use sha2::{Digest, Sha256};

fuzz_target!(|bytes: &[u8]| {
    let _ = Image::read(bytes, Expected::default());
    let mended = mended(bytes);
    let Ok(mut image) = Image::read(&mended, Expected::default()) else {
        return;
    };
    let ranges = image.signals().to_vec();
    for share in [0.0, 0.5, 1.0] {
        let mut signal = [0.0; SIGNALS];
        for (signal, range) in signal.iter_mut().zip(&ranges) {
            *signal = range.low + share * (range.high - range.low);
        }
        ask(&mut image, signal);
        step(&mut image, signal);
    }
});

/// The same with magic, version, length and hash of an image.
fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut mended = bytes.to_vec();
    mended.resize(bytes.len().max(1024).next_multiple_of(8), 0);
    mended[..8].copy_from_slice(b"TLRTEC\r\n");
    mended[8..12].copy_from_slice(&1_u32.to_le_bytes());
    mended[12..16].copy_from_slice(&1024_u32.to_le_bytes());
    let count = mended.len() as u64;
    mended[16..24].copy_from_slice(&count.to_le_bytes());
    mended[24..32].fill(0);
    let hash = Sha256::digest(&mended[64..]);
    mended[32..64].copy_from_slice(&hash);
    mended
}

fn ask(image: &mut Image<'_>, signal: [f64; SIGNALS]) {
    for travel in [-1.0, 0.0, 1.0] {
        for at in [-1e6, -100.0, -1.0, 0.0, 0.5, 25.0, 1e6] {
            let place = Place {
                position: [at; 3],
                travel: [travel; 3],
                tool_offset: [0.0, at, -at],
                signal,
                line: Some(1),
            };
            let wanted = image.wanted(&place);
            assert!(wanted.model.iter().all(|part| part.is_finite()));
            assert!(wanted.table.iter().all(|part| part.is_finite()));
        }
    }
}

fn step(image: &mut Image<'_>, signal: [f64; SIGNALS]) {
    let limit = image.limit();
    let settings = Settings {
        slew_mm_per_s: 1e6,
        ..Settings::default()
    };
    let mut corrector = Corrector::new();
    for heartbeat in 0..20 {
        let inputs = Inputs {
            position: [f64::from(heartbeat), 0.0, -f64::from(heartbeat)],
            signal,
            period_s: 1e-3,
            heartbeat,
            line: 1,
            program: 1,
            enable: true,
            homed: true,
            machine_on: true,
            ..Inputs::default()
        };
        let outputs = corrector.step(image, &inputs, &settings);
        assert!(outputs.correction.iter().all(|part| part.abs() <= limit));
    }
}
