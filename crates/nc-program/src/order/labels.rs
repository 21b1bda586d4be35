//! Numbers by which blocks and programs are called: N and O at a block's start.

use std::collections::HashMap;
use std::ops::Range;

use crate::dialect::{FlowStyle, G};
use crate::reading::names;
use crate::reading::program::{Program, Word, WordKind};

/// Where each number stands.
#[derive(Debug, Default)]
pub(crate) struct Labels {
    blocks: HashMap<u32, Vec<usize>>,
    /// Number and block of each program, in order.
    programs: Vec<(u32, usize)>,
    names: HashMap<String, Vec<usize>>,
    named_programs: Vec<(String, usize)>,
    /// P and Q of each finishing cycle; NaN where they are computed.
    finished: Vec<[f64; 2]>,
}

/// Which way a jump looks for its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Forward,
    Backward,
    /// Forward, then from the start.
    Either,
}

/// The O or N number that a block starts with.
pub(crate) fn label(program: &Program, block: usize) -> Option<(u8, u32)> {
    let word = program.words_of(block).first()?;
    let labels = word.kind == WordKind::Number && matches!(word.letter, b'N' | b'O');
    let value = word.value.round();
    (labels && (0.0..=99_999_999.0).contains(&value)).then_some((word.letter, value as u32))
}

impl Labels {
    /// Reads them all.
    pub fn read(program: &Program) -> Self {
        let mut labels = Self::default();
        for block in 0..program.blocks().len() {
            match label(program, block) {
                Some((b'O', number)) => labels.programs.push((number, block)),
                Some((_, number)) => labels.blocks.entry(number).or_default().push(block),
                None => {}
            }
            labels.note_names(program, block);
            labels.note_finished(program, block);
        }
        labels
    }

    fn note_finished(&mut self, program: &Program, block: usize) {
        let words = program.words_of(block);
        if words.iter().any(|word| word.letter == b'G' && program.code(word) == Some(G::FinishContour)) {
            let value = |letter: u8| words.iter().rev().find(|word| word.letter == letter).map(|word| word.value);
            self.finished.push([b'P', b'Q'].map(|letter| value(letter).unwrap_or(f64::NAN)));
        }
    }

    /// Whether a finishing cycle names these ends of a contour, or may do so.
    pub fn finishes(&self, ends: [f64; 2]) -> bool {
        let same = |known: &[f64; 2]| (0..2).all(|end| known[end].is_nan() || known[end] == ends[end]);
        self.finished.iter().any(same)
    }

    fn note_names(&mut self, program: &Program, block: usize) {
        if let Some(name) = program_name(program, block) {
            self.named_programs.push((name, block));
        }
        if let Some(label) = section_label(program, block) {
            self.names.entry(label).or_default().push(block);
        }
        for word in program.words_of(block).iter().take(2).filter(|word| word.kind == WordKind::Label) {
            let text = program.text(word);
            let bare = if program.dialect().rules.sequence_names { text } else { &[] };
            let text = text.strip_suffix(b":").unwrap_or(bare).trim_ascii_end();
            self.names.entry(lower(text)).or_default().push(block);
        }
    }

    /// The block with that label in the program that a block is of.
    pub fn section(&self, label: &str, from: usize) -> Option<usize> {
        let of_program = self.program_around(from);
        self.names.get(label)?.iter().copied().find(|block| of_program.contains(block))
    }

    /// Block at which the program of that name starts.
    pub fn named_program(&self, name: &str) -> Option<usize> {
        self.named_programs.iter().find(|(known, _)| known == name).map(|(_, block)| *block)
    }

    /// The block that a jump from a block leads to: one with that label, or with that N number, of the same program.
    pub fn target(&self, text: &[u8], from: usize, direction: Direction) -> Option<usize> {
        let name = lower(text);
        let number =
            name.strip_prefix('n').unwrap_or(&name).parse().ok().and_then(|number: u32| self.blocks.get(&number));
        let all = self.names.get(&name).or(number)?;
        let of_program = self.program_around(from);
        let mut here = all.iter().copied().filter(|block| of_program.contains(block));
        let forward = here.clone().find(|block| *block > from);
        match direction {
            Direction::Forward => forward,
            Direction::Backward => here.rfind(|block| *block <= from),
            Direction::Either => forward.or_else(|| here.next()),
        }
    }

    /// The blocks of the named program that a block is of.
    fn program_around(&self, from: usize) -> Range<usize> {
        let index = self.named_programs.partition_point(|(_, block)| *block <= from);
        let start =
            index.checked_sub(1).and_then(|before| self.named_programs.get(before)).map_or(0, |(_, block)| *block);
        start..self.named_programs.get(index).map_or(usize::MAX, |(_, block)| *block)
    }

    /// Block of the O number of a program.
    pub fn program(&self, number: u32) -> Option<usize> {
        self.programs.iter().find(|(known, _)| *known == number).map(|(_, block)| *block)
    }

    /// The block of a number: looked for after `from`, then from the start of the program that `from` is in. Says too
    /// whether that program has the number more than once.
    pub fn block(&self, number: u32, from: usize) -> Option<(usize, bool)> {
        let index = self.programs.partition_point(|(_, block)| *block <= from);
        let start = index.checked_sub(1).and_then(|before| self.programs.get(before)).map_or(0, |(_, block)| *block);
        let end = self.programs.get(index).map_or(usize::MAX, |(_, block)| *block);
        let all = self.blocks.get(&number)?;
        let here = all.get(all.partition_point(|block| *block < start)..all.partition_point(|block| *block < end))?;
        let after = here.get(here.partition_point(|block| *block <= from)).or(here.first())?;
        Some((*after, here.len() > 1))
    }
}

/// The name at the head of a program: `%_N_SHAFT_MPF`, `%MPF 100`, `OSHAFT` of an OSP, `BEGIN PGM SHAFT MM`.
pub(crate) fn program_name(program: &Program, block: usize) -> Option<String> {
    let found = program.blocks().get(block)?;
    if program.dialect().rules.sequence_names {
        let first = program.words_of(block).first().filter(|word| word.letter == b'O');
        return first.map(|word| lower(program.text(word)));
    }
    if program.dialect().flow == FlowStyle::Labels {
        let head = program.words_of(block).iter().find(|word| program.code(word) == Some(G::Heading))?;
        let text = lower(program.text(head));
        return Some(text.strip_prefix("begin pgm")?.trim().rsplit_once(' ')?.0.trim().to_owned());
    }
    if !found.tape_mark || program.dialect().flow != FlowStyle::Structured {
        return None;
    }
    let line = program.source().get(found.start as usize..found.end as usize)?.trim_ascii();
    let name = lower(line.strip_prefix(b"%")?.trim_ascii());
    let bare = name.strip_prefix("_n_").unwrap_or(&name);
    let bare = bare.strip_suffix("_mpf").or_else(|| bare.strip_suffix("_spf")).unwrap_or(bare);
    let bare = bare.strip_prefix("spf").map_or(bare.to_owned(), |number| format!("l{}", number.trim()));
    bare.bytes().next().is_some_and(names::is_name).then_some(bare)
}

/// In lower case: names are the same in either.
pub(crate) fn lower(text: &[u8]) -> String {
    text.iter().map(|byte| char::from(byte.to_ascii_lowercase())).collect()
}

/// The name of the program that a word calls, and how often: of an OSP by Q, `CALL OSLOT Q3`. `None` where arguments stand
/// behind it.
pub(crate) fn called(program: &Program, word: &Word) -> (String, Option<u64>) {
    let text = lower(program.text(word));
    if word.kind != WordKind::Name {
        let end = text.find(|byte| !u8::try_from(byte).is_ok_and(names::is_name)).unwrap_or(text.len());
        let arguments: String = text[end..].split_whitespace().collect();
        return (text[..end].to_owned(), Some(1).filter(|_| arguments.is_empty() || arguments == "()"));
    }
    let mut parts = text.get("call".len()..).unwrap_or("").split_ascii_whitespace();
    let (name, repeats, more) = (parts.next().unwrap_or(""), parts.next().unwrap_or("q1"), parts.next());
    (name.to_owned(), repeats.strip_prefix('q').filter(|_| more.is_none()).and_then(|times| times.parse().ok()))
}

/// `LBL 5`, `LBL "POCKET"`: the label of a block.
fn section_label(program: &Program, block: usize) -> Option<String> {
    let flow = |word: &&Word| word.kind == WordKind::Flow && program.dialect().flow == FlowStyle::Labels;
    let word = program.words_of(block).iter().find(flow)?;
    let text = lower(program.text(word));
    text.strip_prefix("lbl").map(|label| label.trim_matches(['"', ' ', '\t']).to_owned())
}
