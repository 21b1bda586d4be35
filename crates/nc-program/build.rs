//! Writes `controls.tsv`, what each control makes of the same words, as Rust: a constant of rules and a table of codes a
//! control.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

const TABLE: &str = "controls.tsv";
/// In place of a value: what the word does is written out in the dialect's own code.
const IN_CODE: &str = "in code";

fn main() {
    println!("cargo::rerun-if-changed={TABLE}");
    let table = fs::read_to_string(TABLE).expect("the table of controls is part of the crate");
    let mut controls: BTreeMap<&str, [String; 2]> = BTreeMap::new();
    for line in table.lines().skip(1) {
        let [names, item, value, ..] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("too few columns: {line}")
        };
        for name in names.split(' ').filter(|_| value != IN_CODE) {
            let [rules, codes] = controls.entry(name).or_default();
            let done = match tenths(item) {
                Some(code) => writeln!(codes, "        {code} => Some({value}),"),
                None => writeln!(rules, "    {item}: {value},"),
            };
            done.expect("memory takes text");
        }
    }
    let mut text = String::new();
    for (name, [rules, codes]) in controls {
        let (upper, lower) = (name.replace('-', "_").to_uppercase(), name.replace('-', "_"));
        let rules = format!("/// What {name} does beyond the meaning of codes.\npub const {upper}: Rules = Rules {{\n{rules}    ..Rules::USUAL\n}};\n\n");
        text.push_str(&rules);
        if !codes.is_empty() {
            write!(
                text,
                "/// Codes that {name} understands in a way of its own, given ten times their number.\n\
                 pub fn {lower}(tenths: u16) -> Option<G> {{\n    match tenths {{\n{codes}        _ => None,\n    }}\n}}\n\n"
            )
            .expect("memory takes text");
        }
    }
    let folder = env::var("OUT_DIR").expect("cargo names a folder");
    fs::write(Path::new(&folder).join("controls.rs"), text).expect("the folder can be written");
}

/// Ten times the number of a G code; `None` for the name of a rule.
fn tenths(item: &str) -> Option<u32> {
    let (whole, tenth) = item.strip_prefix('G')?.split_once('.').unwrap_or((item.strip_prefix('G')?, "0"));
    Some(whole.parse::<u32>().ok()? * 10 + tenth.parse::<u32>().ok()?)
}
