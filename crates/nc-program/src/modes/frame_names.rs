//! Frames of Sinumerik by name: variables that move what follows when a value is given to them.

use crate::finding;
use crate::reading::program::Word;
use crate::run::Runner;

/// Functions whose value is a frame.
const FUNCTIONS: [&[u8]; 5] = [b"CTRANS", b"CROT", b"CSCALE", b"CMIRROR", b"CFINE"];

/// Names of offsets of the tool that a program sets: along its axis or its radius, and by the number of an additive one.
const TOOL_OFFSETS: [&[u8]; 4] = [b"TOFF", b"TOFFL", b"TOFFR", b"DL"];

/// Whether an assignment sets an offset of the tool, or a frame: a system variable of one (`$P_PFRAME`, `$P_UIFR[1]`), a superimposed movement
/// (`$AA_OFF[Z]`), or any variable that gets a frame for its value.
fn sets_frame(text: &[u8]) -> bool {
    let kept: Vec<u8> = text.iter().filter(|byte| !byte.is_ascii_whitespace()).map(u8::to_ascii_uppercase).collect();
    let mut sides = kept.splitn(2, |byte| *byte == b'=');
    let (variable, value) = (sides.next().unwrap_or(&[]), sides.next().unwrap_or(&[]));
    let name = variable.split(|byte| *byte == b'[').next().unwrap_or(&[]);
    let of_system = name.starts_with(b"$P_") && name.windows(2).any(|pair| pair == b"FR");
    let of_tool = TOOL_OFFSETS.contains(&name) && value != b"0";
    of_tool || of_system || name == b"$AA_OFF" || FUNCTIONS.iter().any(|function| value.starts_with(function))
}

impl Runner<'_> {
    /// Says of an assignment that sets a frame that it is not followed; whether it does.
    pub(crate) fn sets_frame(&mut self, word: &Word) -> bool {
        let text = self.program.text(word);
        if !sets_frame(text) {
            return false;
        }
        let message = format!("{}: the path goes on as if it were not there", finding::excerpt(text));
        let hint = "positions after it are not those of the machine; write it without this frame";
        self.warn(finding::OPAQUE, word.start as usize, message, hint);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::sets_frame;

    #[test]
    fn system_frames_and_values_that_are_frames() {
        for text in ["$P_PFRAME[X,TR]=10", "$p_uifr[1] = $P_UIFR[2]", "$P_CHBFR[0]=1", "$AA_OFF[Z]=1", "T=CROT(Z,9)"] {
            assert!(sets_frame(text.as_bytes()), "{text}");
        }
        for text in ["R1=5", "DEPTH=R1+$P_UIFR[1,X,TR]", "$TC_DP3[1,1]=120", "FRAMES=2", "$AC_TIMER[1]=0", ""] {
            assert!(!sets_frame(text.as_bytes()), "{text}");
        }
    }
}
