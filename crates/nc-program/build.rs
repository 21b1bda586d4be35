//! Writes the tables of controls as Rust: `controls.tsv`, rules and codes that a text or a run confirms, and `codes.tsv`,
//! all codes and names. Of rows that give a word of one control several meanings the first counts, those confirmed before.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

/// In place of a value: what the word does is written out in the runner.
const IN_CODE: &str = "in code";
/// Controls that share most of their codes; `modal` are those of which G90 switches to positions.
const GROUPS: [(&str, &[&str]); 7] = [
    ("fanuc", &["fanuc-lathe", "fanuc-lathe-b", "fanuc-mill"]),
    ("lathes", &["fanuc-lathe", "fanuc-lathe-b", "haas-lathe"]),
    ("lathe-a", &["fanuc-lathe", "haas-lathe"]),
    ("mills", &["fanuc-mill", "haas-mill"]),
    ("iso", &["lathes", "mills"]),
    ("modal", &["mills", "fanuc-lathe-b", "ge2000t", "linuxcnc", "okuma-lathe", "siemens"]),
    ("all", &["iso", "ge2000t", "linuxcnc", "okuma-lathe", "siemens"]),
];

/// What the tables say of a control: its rules, the arms of its G and M codes, and its names with their meanings.
#[derive(Default)]
struct Control {
    rules: String,
    codes: [String; 2],
    names: Vec<(String, String)>,
}

fn main() {
    let [confirmed, codes] = ["controls.tsv", "codes.tsv"].map(|table| {
        println!("cargo::rerun-if-changed={table}");
        fs::read_to_string(table).expect("the tables of controls are part of the crate")
    });
    let mut controls = BTreeMap::new();
    for line in confirmed.lines().skip(1).chain(codes.lines().skip(1)) {
        let [of, words, meaning, ..] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("too few columns: {line}")
        };
        for name in of.split(' ').flat_map(members).filter(|_| meaning != IN_CODE) {
            controls.entry(name).or_insert_with(Control::default).add(words, meaning);
        }
    }
    let text: String = controls.into_iter().map(|(name, control)| control.written(name)).collect();
    let folder = env::var("OUT_DIR").expect("cargo names a folder");
    fs::write(Path::new(&folder).join("controls.rs"), text).expect("the folder can be written");
}

/// The controls of a group; else the control of that name.
fn members(name: &str) -> Vec<&str> {
    match GROUPS.iter().find(|(group, _)| *group == name) {
        Some((_, members)) => members.iter().flat_map(|member| self::members(member)).collect(),
        None => vec![name],
    }
}

impl Control {
    fn add(&mut self, words: &str, meaning: &str) {
        let of_code = |letter: char| words.split(' ').map(|word| pattern(word, letter)).collect::<Option<Vec<_>>>();
        if meaning.starts_with("Name::") {
            self.names.extend(words.split(", ").map(|name| (name.replace('~', "\\t"), meaning.to_owned())));
            return;
        }
        let done = match ['G', 'M'].map(of_code) {
            [Some(codes), _] => arms(&mut self.codes[0], &codes, meaning),
            [_, Some(codes)] => arms(&mut self.codes[1], &codes, meaning),
            _ => writeln!(self.rules, "    {words}: {meaning},"),
        };
        done.expect("memory takes text");
    }

    fn written(mut self, name: &str) -> String {
        let (upper, lower) = (name.replace('-', "_").to_uppercase(), name.replace('-', "_"));
        let [g, m] = self.codes;
        let mut text = format!(
            "/// What {name} does beyond the meaning of codes.\npub const {upper}: Rules = Rules {{\n{}    ..Rules::USUAL\n}};\n\
             /// M codes of {name}.\npub fn {lower}_m(number: u16) -> Option<M> {{\n    Some(match number {{\n{m}        _ => return None,\n    }})\n}}\n",
            self.rules
        );
        if !g.is_empty() {
            text += &format!(
                "/// G codes of {name}, given ten times their number.\n#[allow(unreachable_patterns, clippy::match_overlapping_arm)]\n\
                 pub fn {lower}_g(tenths: u16) -> Option<G> {{\n    Some(match tenths {{\n{g}        _ => return None,\n    }})\n}}\n"
            );
        }
        // The first that fits counts: those of one letter stand together, the more of their text is fixed the sooner.
        let fixed = |name: &str| name.bytes().filter(|byte| !b" #".contains(byte)).count();
        self.names.sort_by_key(|(name, _)| (name.bytes().next(), usize::MAX - fixed(name)));
        let names: String =
            self.names.iter().map(|(name, meaning)| format!("    (\"{name}\", {meaning}),\n")).collect();
        if !names.is_empty() {
            text += &format!("pub(crate) const {upper}_NAMES: Names = Names::of(&[\n{names}]);\n");
        }
        text
    }
}

fn arms(out: &mut String, codes: &[String], meaning: &str) -> std::fmt::Result {
    codes.iter().try_for_each(|code| writeln!(out, "        {code} => {meaning},"))
}

/// The pattern of a code, `G54`, or of whole numbers from one to another, `G54..G59`: of G ten times the number.
fn pattern(word: &str, letter: char) -> Option<String> {
    let scale = if letter == 'G' { 10 } else { 1 };
    let number = |code: &str| {
        let (whole, tenth) = code.strip_prefix(letter)?.split_once('.').unwrap_or((code.strip_prefix(letter)?, "0"));
        Some(whole.parse::<u32>().ok()? * scale + tenth.parse::<u32>().ok()?)
    };
    match word.split_once("..") {
        Some((first, last)) if scale == 1 => Some(format!("{}..={}", number(first)?, number(last)?)),
        Some((first, last)) => {
            Some(format!("{}..={} if tenths.is_multiple_of({scale})", number(first)?, number(last)?))
        }
        None => number(word).map(|code| code.to_string()),
    }
}
