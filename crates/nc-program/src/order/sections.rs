//! Flow control of Klartext: sections called or repeated by their label, jumps where two values compare.

use crate::finding;
use crate::order::flow::{Flow, Statement};
use crate::reading::names;
use crate::run::Runner;

/// How two values may compare.
const COMPARED: [&str; 4] = [" equ ", " ne ", " gt ", " lt "];

impl Runner<'_> {
    /// Executes a line of these; gives the block to go on with.
    pub(crate) fn follow_label(&mut self, statement: &Statement) -> usize {
        self.next = statement.block + 1;
        let text = self.line_text(statement.arguments);
        match statement.flow {
            Flow::Label if text.trim() == "0" => {
                self.go_back();
            }
            Flow::CallLabel => self.call_section(statement, &text),
            Flow::Compare => self.compare(statement, &text),
            _ => {}
        }
        self.next
    }

    /// The rest of the line in lower case, without a comment.
    pub(crate) fn line_text(&self, at: usize) -> String {
        let end = self.program.blocks().get(self.block).map_or(at, |block| block.end as usize);
        let text = self.program.source().get(at..end).unwrap_or(&[]);
        let text: String = text.iter().map(|byte| char::from(byte.to_ascii_lowercase())).collect();
        text.split(';').next().unwrap_or("").to_owned()
    }

    /// `CALL LBL 5`, which comes back at LBL 0; `CALL LBL 5 REP 3`, which runs what lies between three times more.
    fn call_section(&mut self, statement: &Statement, text: &str) {
        let named = text.rfind('"').map(|quote| quote + 1); // REP may be part of a name
        let (label, times) = text.split_at(named.or_else(|| text.find("rep")).unwrap_or(text.len()));
        let Some(start) = self.section(statement, label) else { return };
        if times.trim().is_empty() {
            return self.visit(start, 1);
        }
        let Some(times) = times.trim().strip_prefix("rep").and_then(repetitions) else {
            let message = "the number of repetitions is no whole number".into();
            return self.refuse(finding::FLOW, statement.at, message, "write CALL LBL 1 REP 3");
        };
        if start > statement.block {
            let message = "REP repeats what lies between its label and its own line, but the label stands behind it";
            let hint = "write the label before the line, or CALL LBL without REP once for each run";
            return self.refuse(finding::FLOW, statement.at, message.into(), hint);
        }
        self.repeat_from(start, times);
    }

    /// Runs what lies between a block and this one so many times more.
    pub(crate) fn repeat_from(&mut self, start: usize, times: u64) {
        if self.counts_again(times) {
            self.next = start;
        }
    }

    /// Runs the blocks from one to another so many times, wherever they are.
    pub(crate) fn repeat_between(&mut self, first: usize, last: usize, times: u64) {
        if self.counts_again(times) {
            self.visit_contour((first, last), self.block, None, false);
        }
    }

    /// Whether this block, which repeats others, is to do so once more.
    fn counts_again(&mut self, times: u64) -> bool {
        let here = self.block;
        if !self.counters.iter().any(|(block, _)| *block == here) {
            self.counters.push((here, times));
        }
        if let Some((_, left)) = self.counters.iter_mut().find(|(block, left)| *block == here && *left > 0) {
            *left -= 1;
            return true;
        }
        self.counters.retain(|(block, _)| *block != here);
        false
    }

    fn section(&mut self, statement: &Statement, label: &str) -> Option<usize> {
        let label = label.trim_matches(['"', ' ', '\t']);
        let label = label.strip_prefix("lbl").unwrap_or(label).trim_matches(['"', ' ', '\t']);
        let found = self.labels().section(label, self.block);
        if found.is_none() {
            let message = format!("there is no LBL {} in this program", finding::excerpt(label.as_bytes()));
            self.refuse(finding::FLOW, statement.at, message, "write LBL with that number at the section's start");
        }
        found
    }

    /// `IF +Q1 EQU +Q3 GOTO LBL 5`.
    #[allow(clippy::float_cmp)] // the control compares exactly
    fn compare(&mut self, statement: &Statement, text: &str) {
        let Some((condition, label)) = text.split_once("goto") else {
            let message = "a comparison without a jump".into();
            return self.refuse(finding::FLOW, statement.at, message, "write FN 9: IF +Q1 EQU +Q2 GOTO LBL 5");
        };
        let found = COMPARED.iter().find_map(|word| Some((condition.find(word)?, *word)));
        let start = names::skip(self.program.source(), statement.arguments, |byte| byte == b' ');
        let (Some((offset, word)), true) = (found, condition.trim_start().starts_with("if")) else {
            let message = "a comparison that is not known".into();
            return self.refuse(finding::FLOW, statement.at, message, "write IF, then EQU, NE, GT or LT");
        };
        let (left, _) = self.value(start + 2);
        let (right, _) = self.value(statement.arguments + offset + word.len());
        let holds = match word {
            " equ " => left == right,
            " ne " => left != right,
            " gt " => left > right,
            _ => left < right,
        };
        if holds {
            if let Some(block) = self.section(statement, label) {
                self.next = block;
            }
        }
    }
}

/// `3`; `3/3` as older controls write it, where the second number counts down as the section is run.
fn repetitions(text: &str) -> Option<u64> {
    let (all, left) = text.split_once('/').unwrap_or((text, text));
    (all.trim() == left.trim()).then(|| all.trim().parse().ok()).flatten()
}
