//! Images for tests: a model with one signal, and a table of two blocks.

extern crate std;

use std::vec::Vec;

use sha2::{Digest, Sha256};

/// Content of the program that the table belongs to.
pub(crate) const PROGRAM: &[u8] = b"N10 G1 X50 Z-10\nN20 Z-30\n";
/// Where numbers stand among the words.
pub(crate) const SLOPE: usize = 16;
pub(crate) const BODY: usize = SLOPE + 18 + 1;
pub(crate) const ROWS: usize = BODY + 11 + 3 + 12 + 13 + 7;

/// The words of a good image. E of X: EXX = 0.010 in the first segment, 0.010 + 1e-4 (z + 100) in the second, and with the
/// signal above 20 by one 0.001 more.
pub(crate) fn words() -> Vec<f64> {
    let mut words = Vec::new();
    words.extend([0.150, 0.1, 0.0, 200.0, -1.0, 1.0, -300.0, 0.0]);
    words.extend([0.0, 0.0, -50.0]);
    words.extend([1.0, 20.0, 15.0, 35.0, 2.0]);
    words.extend([0.0; 18]);
    words.extend([1.0, 2.0, 3.0, 1.0, 1.0, 1.0]);
    words.extend([0.0, 0.0, 120.0, 0.0, 0.0, 0.0]);
    words.extend([-300.0, -100.0, 0.0]);
    words.extend([0.010, 0.0, 0.0, 0.0, 0.0, 0.0]);
    words.extend([0.020, 0.0, 0.0, 0.0, 0.0, 0.0]);
    words.push(0.0);
    words.extend([0.001, 0.0, 0.0, 0.0, 0.0, 0.0]);
    words.extend([0.001, 0.0, 0.0, 0.0, 0.0, 0.0]);
    words.extend([2.0, 1.0, 0.0, 2.0, 2.0, 2.0, 3.0, 5.0]);
    words.extend([25.0, 0.0, 0.010, 0.0, 25.0, -10.0, 0.012, 0.001]);
    words.extend([25.0, -10.0, 0.012, 0.001, 25.0, -20.0, 0.0, 0.0]);
    words.extend([25.0, -30.0, -0.010, 0.0]);
    words
}

/// The file of these words, for the machine `4711`.
pub(crate) fn file(words: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::from(*b"TLRTEC\r\n");
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(1024_u32.to_le_bytes());
    bytes.extend((1024 + 8 * words.len() as u64).to_le_bytes());
    bytes.resize(1024, 0);
    bytes[128..132].copy_from_slice(b"4711");
    bytes[224..256].copy_from_slice(&Sha256::digest(PROGRAM));
    bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    hash(&mut bytes);
    bytes
}

/// Puts the hash in.
pub(crate) fn hash(bytes: &mut [u8]) {
    let hash = Sha256::digest(&bytes[64..]);
    bytes[32..64].copy_from_slice(&hash);
}
