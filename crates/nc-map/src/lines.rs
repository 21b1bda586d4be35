//! New lines after a block, numbered as the program numbers its blocks.

use std::collections::HashSet;
use std::sync::OnceLock;

use nc_program::{Program, Word, WordKind};

/// A number further on than this many blocks is not looked for.
const FURTHER: usize = 100;

/// The numbers of all blocks of a program, looked for once: a search for one, or a jump, is to find the block that had it.
#[derive(Debug, Default)]
pub struct BlockNumbers(OnceLock<HashSet<usize>>);

impl BlockNumbers {
    fn of(&self, program: &Program) -> &HashSet<usize> {
        self.0.get_or_init(|| program.words().iter().filter_map(|word| number_of(program, word)).collect())
    }
}

/// Writes blocks after one, each on its line: N0420 is followed by N0421, N0422 …, without numbers where they do not fit
/// before the next number, another block has one of them, or the program has none. A number that is to stand at the `last`
/// of them is the only one.
pub fn new_lines(
    program: &Program,
    block: usize,
    texts: &[Vec<u8>],
    last: Option<&Word>,
    taken: &BlockNumbers,
    out: &mut Vec<u8>,
) {
    let free = |own: usize| (1..=texts.len()).all(|step| !taken.of(program).contains(&(own + step)));
    let numbers = numbers(program, block, texts.len()).filter(|(own, ..)| last.is_none() && free(*own));
    for (index, text) in texts.iter().enumerate() {
        out.extend(line_ending(program.source()));
        if let Some((number, letter, width, space)) = numbers {
            out.push(letter);
            out.extend(format!("{:0width$}", number + 1 + index).bytes());
            out.extend(space);
        }
        if let Some(number) = last.filter(|_| index + 1 == texts.len()) {
            out.extend(program.text(number));
            out.push(b' ');
        }
        out.extend(text);
    }
}

/// Number of the block, its letter, its width, and the space after it, where `count` numbers fit after it.
fn numbers(program: &Program, block: usize, count: usize) -> Option<(usize, u8, usize, &[u8])> {
    let number = |block: usize| program.words_of(block).iter().find_map(|word| Some((word, number_of(program, word)?)));
    let (word, own) = number(block)?;
    let next = (block + 1..program.blocks().len()).take(FURTHER).find_map(number);
    if next.is_some_and(|(_, next)| next <= own + count) {
        return None;
    }
    let rest = program.source().get(word.end()..)?;
    let space = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    let letter = *program.text(word).first()?;
    Some((own, letter, usize::from(word.length) - 1, if space == 0 { b" " } else { rest.get(..space)? }))
}

/// The number of a block, by its word N. Numbers without a letter are the control's: it counts anew.
fn number_of(program: &Program, word: &Word) -> Option<usize> {
    let is_number = word.letter == b'N' && word.kind == WordKind::Number && (0.0..1e9).contains(&word.value);
    (is_number && !program.text(word)[0].is_ascii_digit()).then_some(word.value as usize)
}

/// That of the source.
pub(crate) fn line_ending(source: &[u8]) -> &'static [u8] {
    match memchr::memchr(b'\n', source) {
        Some(at) if at > 0 && source.get(at - 1) == Some(&b'\r') => b"\r\n",
        _ => b"\n",
    }
}
