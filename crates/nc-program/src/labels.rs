//! Numbers by which blocks and programs are called: N and O at a block's start.

use std::collections::HashMap;

use crate::program::{Program, WordKind};

/// Where each number stands.
#[derive(Debug, Default)]
pub(crate) struct Labels {
    blocks: HashMap<u32, Vec<usize>>,
    /// Number and block of each program, in order.
    programs: Vec<(u32, usize)>,
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
        }
        labels
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
