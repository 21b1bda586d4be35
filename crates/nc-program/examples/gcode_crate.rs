//! The crate `gcode`, beside which benches/nc_rivals.py times ours: `gcode_crate PROGRAM` parses the program once for
//! every line of its standard input and answers with the number of blocks; `gcode_crate` alone parses its standard input
//! and tells every block: line from 0, words, and the block as the crate writes it, with tabs between.

use std::io::{self, BufRead, Write};

use gcode::{Block, Code, Value};

fn main() -> io::Result<()> {
    match std::env::args().nth(1) {
        Some(path) => time(&std::fs::read_to_string(path)?),
        None => tell(&io::read_to_string(io::stdin())?),
    }
}

fn time(source: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    for line in io::stdin().lock().lines() {
        line?;
        writeln!(out, "{}", blocks(source).len())?;
        out.flush()?;
    }
    Ok(())
}

/// None of a program in which anything is wrong to the crate.
fn blocks(source: &str) -> Vec<Block> {
    gcode::parse(source).map_or_else(|_| Vec::new(), |program| program.blocks)
}

fn tell(source: &str) -> io::Result<()> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    for block in blocks(source) {
        writeln!(out, "{}\t{}\t{}", block.span.line, words(&block).join(" "), block.to_string().trim_end())?;
    }
    out.flush()
}

/// Letter and value of each, the value as the crate keeps it.
fn words(block: &Block) -> Vec<String> {
    let mut words: Vec<String> = block.line_number.iter().map(|number| format!("N{number}")).collect();
    for code in &block.codes {
        let (letter, number, arguments) = match code {
            Code::General(code) => ('G', code.number, &code.args),
            Code::Miscellaneous(code) => ('M', code.number, &code.args),
            Code::ToolChange(code) => ('T', code.number, &code.args),
            _ => continue,
        };
        words.push(format!("{letter}{number}"));
        words.extend(arguments.iter().map(|argument| word(argument.letter, &argument.value)));
    }
    words.extend(block.word_addresses.iter().map(|found| word(found.letter, &found.value)));
    words
}

fn word(letter: char, value: &Value) -> String {
    match value {
        Value::Literal(number) => format!("{letter}{}", f64::from(*number)),
        _ => format!("{letter}nan"),
    }
}
