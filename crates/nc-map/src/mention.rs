//! Whether a text says a word: a comment that tells what was done to a program.

/// Whether a word of ASCII letters stands in a text, in capitals or not.
pub fn mentions(text: &[u8], word: &[u8]) -> bool {
    let Some(first) = word.first() else { return true };
    let begins = |at: usize| text.get(at..at + word.len()).is_some_and(|found| found.eq_ignore_ascii_case(word));
    memchr::memchr2_iter(first.to_ascii_lowercase(), first.to_ascii_uppercase(), text).any(begins)
}

#[cfg(test)]
mod tests {
    use super::mentions;

    #[test]
    fn capitals_do_not_matter_and_what_is_cut_off_is_no_word() {
        for text in ["trueloop", "N1 (TRUELOOP corrected)", "ttrueloop", "X1 TrueLoop"] {
            assert!(mentions(text.as_bytes(), b"trueloop"), "{text}");
        }
        for text in ["", "trueloo", "true loop", "T1 rueloop"] {
            assert!(!mentions(text.as_bytes(), b"trueloop"), "{text}");
        }
    }
}
