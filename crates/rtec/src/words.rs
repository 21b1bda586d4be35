//! The image's words: 64-bit floats, read where they lie.

use error_eval::{Six, Vector};

use crate::image::Refusal;

/// A float as it lies in the file: bytes, so that it may lie anywhere.
pub(crate) type Word = [u8; 8];

/// The number of a word.
#[inline(always)]
pub(crate) const fn number(word: &Word) -> f64 {
    f64::from_le_bytes(*word)
}

/// The numbers of several.
#[inline(always)]
pub(crate) fn numbers<const N: usize>(words: &[Word; N]) -> [f64; N] {
    words.map(f64::from_le_bytes)
}

/// A whole number not above `most`.
pub(crate) fn whole(value: f64, most: usize) -> Option<usize> {
    let count = value as usize; // saturates; NaN is 0
    (count as f64 == value && count <= most).then_some(count)
}

/// Takes words one after the other.
pub(crate) struct Reader<'a> {
    left: &'a [Word],
}

impl<'a> Reader<'a> {
    pub(crate) const fn new(words: &'a [Word]) -> Self {
        Self { left: words }
    }

    /// So many words. Fewer are left: [`Refusal::Count`].
    pub(crate) fn take(&mut self, count: usize) -> Result<&'a [Word], Refusal> {
        let (taken, left) = self.left.split_at_checked(count).ok_or(Refusal::Count)?;
        self.left = left;
        Ok(taken)
    }

    /// So many groups of `N` words.
    pub(crate) fn groups<const N: usize>(
        &mut self,
        count: usize,
    ) -> Result<&'a [[Word; N]], Refusal> {
        let words = count.checked_mul(N).ok_or(Refusal::Count)?;
        Ok(self.take(words)?.as_chunks().0)
    }

    /// One group of `N` numbers.
    pub(crate) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], Refusal> {
        let group = self.groups(1)?.first().ok_or(Refusal::Count)?;
        Ok(numbers(group))
    }

    /// X, Y, Z.
    pub(crate) fn vector(&mut self) -> Result<Vector, Refusal> {
        self.numbers()
    }

    /// A whole number not above `most`.
    pub(crate) fn count(&mut self, most: usize) -> Result<usize, Refusal> {
        let [value] = self.numbers()?;
        whole(value, most).ok_or(Refusal::Count)
    }

    /// Whether all words are taken.
    pub(crate) fn is_done(&self) -> bool {
        self.left.is_empty()
    }
}

/// Six errors, or a power of each.
pub(crate) type SixWords = [Word; 6];

/// Adds `share` times the rows to `sum`.
pub(crate) fn add_rows(sum: &mut [Six], rows: &[SixWords], share: f64) {
    for (sum, row) in sum.iter_mut().zip(rows) {
        for (sum, word) in sum.iter_mut().zip(row) {
            *sum += share * number(word);
        }
    }
}
