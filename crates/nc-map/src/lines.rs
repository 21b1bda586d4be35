//! New lines after a block, numbered as the program numbers its blocks.

use nc_program::{Program, Word, WordKind};

/// A number further on than this many blocks is not looked for.
const FURTHER: usize = 100;

/// Writes blocks after one, each on its line: N0420 is followed by N0421, N0422 …, without numbers where they do not fit
/// before the next number or the program has none. A number that is to stand at the `last` of them is the only one.
pub(crate) fn new_lines(program: &Program, block: usize, texts: &[Vec<u8>], last: Option<&Word>, out: &mut Vec<u8>) {
    let numbers = numbers(program, block, texts.len()).filter(|_| last.is_none());
    for (index, text) in texts.iter().enumerate() {
        out.extend(line_ending(program.source()));
        if let Some((number, width, space)) = numbers {
            out.extend(format!("N{:0width$}", number + 1 + index).bytes());
            out.extend(space);
        }
        if let Some(number) = last.filter(|_| index + 1 == texts.len()) {
            out.extend(program.text(number));
            out.push(b' ');
        }
        out.extend(text);
    }
}

/// Number of the block, its width, and the space after it, where `count` numbers fit after it.
fn numbers(program: &Program, block: usize, count: usize) -> Option<(usize, usize, &[u8])> {
    let number = |block: usize| {
        let is_number = |word: &&Word| word.letter == b'N' && word.kind == WordKind::Number;
        let word = program.words_of(block).iter().find(is_number)?;
        // Numbers without a letter are the control's: it counts anew.
        let word = Some(word).filter(|word| !program.text(word)[0].is_ascii_digit())?;
        (0.0..1e9).contains(&word.value).then_some((word, word.value as usize))
    };
    let (word, own) = number(block)?;
    let next = (block + 1..program.blocks().len()).take(FURTHER).find_map(number);
    if next.is_some_and(|(_, next)| next <= own + count) {
        return None;
    }
    let rest = program.source().get(word.end()..)?;
    let space = rest.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    Some((own, usize::from(word.length) - 1, if space == 0 { b" " } else { rest.get(..space)? }))
}

/// That of the source.
pub(crate) fn line_ending(source: &[u8]) -> &'static [u8] {
    match memchr::memchr(b'\n', source) {
        Some(at) if at > 0 && source.get(at - 1) == Some(&b'\r') => b"\r\n",
        _ => b"\n",
    }
}
