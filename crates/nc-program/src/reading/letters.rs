//! Sets of address letters.

/// Addresses from `A` to `z`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Letters(u64);

impl Letters {
    /// Those of a text.
    pub const fn of(text: &[u8]) -> Self {
        let (mut bits, mut index) = (0, 0);
        while index < text.len() {
            bits |= bit(text[index]);
            index += 1;
        }
        Self(bits)
    }

    /// Whether a letter is among them.
    #[inline]
    pub const fn has(self, letter: u8) -> bool {
        self.0 & bit(letter) != 0
    }

    /// Whether any letter is among both.
    #[inline]
    pub const fn meets(self, others: Self) -> bool {
        self.0 & others.0 != 0
    }

    /// The letters in order, capitals first.
    pub fn text(self) -> String {
        (b'A'..=b'z').filter(|letter| self.has(*letter)).map(char::from).collect()
    }

    /// Without a letter.
    #[inline]
    pub fn remove(&mut self, letter: u8) {
        self.0 &= !bit(letter);
    }

    /// Whether there is none.
    #[inline]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// One letter more.
    #[inline]
    pub fn add(&mut self, letter: u8) {
        self.0 |= bit(letter);
    }
}

/// None for a byte that is no address.
#[inline]
const fn bit(letter: u8) -> u64 {
    match 1u64.checked_shl(letter.wrapping_sub(b'A') as u32) {
        Some(bit) => bit,
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::Letters;

    #[test]
    fn a_set_has_its_letters_and_no_others() {
        let mut letters = Letters::of(b"AZor");
        letters.add(b'z');
        let found: Vec<u8> = (0..=255).filter(|byte| letters.has(*byte)).collect();
        assert_eq!(found, b"AZorz");
        assert!(letters.meets(Letters::of(b"XYZ")) && !letters.meets(Letters::of(b"XY0")));
    }
}
