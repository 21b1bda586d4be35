//! Writes the tables of controls as Rust: `controls.tsv`, rules and codes that a text or a run confirms, and `codes.tsv`,
//! all codes and names. Of rows that give a word of one control several meanings the first counts, those confirmed before.
//! A file in `controls/` is a control of its own, by what it does otherwise than the control that its row `like` names.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

/// In place of a value: what the word does is written out in the runner.
const IN_CODE: &str = "in code";
/// In place of a meaning: the control does not know the code, though the one that it is like does.
const UNKNOWN: &str = "unknown";
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

/// A control by its tables: its rules, the arms of its G and M codes, its names with their meanings, and of a control in a
/// file of its own the one that it is like and the marks of its programs.
#[derive(Clone, Default)]
struct Control {
    rules: Vec<(String, String)>,
    codes: [String; 2],
    names: Vec<(String, String)>,
    like: Option<String>,
    marks: Vec<(u32, String)>,
}

fn main() {
    let folder = Path::new("controls");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut files: Vec<_> =
        fs::read_dir(folder).expect("the folder of controls").map(|entry| entry.expect("a file").path()).collect();
    files.sort();
    let mut controls = BTreeMap::new();
    for table in files.iter().map(|file| file.as_path()).chain(["controls.tsv", "codes.tsv"].map(Path::new)) {
        println!("cargo::rerun-if-changed={}", table.display());
        let text = fs::read_to_string(table).expect("the tables of controls are part of the crate");
        for line in text.lines().skip(1) {
            let [of, words, meaning, ..] = line.split('\t').collect::<Vec<_>>()[..] else {
                panic!("too few columns: {line}")
            };
            for name in of.split(' ').flat_map(members).filter(|_| meaning != IN_CODE) {
                controls.entry(name.to_owned()).or_insert_with(Control::default).add(words, meaning);
            }
        }
    }
    let mut text: String = controls.iter().map(|(name, control)| control.with_base(&controls).written(name)).collect();
    let own: Vec<_> =
        controls.iter().filter_map(|(name, control)| Some(control.dialect(name, control.like.as_ref()?))).collect();
    write!(
        text,
        "/// Controls that are data alone.\npub(crate) static IN_FILES: [Dialect; {}] = [{}];\n",
        own.len(),
        own.concat()
    )
    .expect("memory takes text");
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
        match (words, ['G', 'M'].map(of_code)) {
            ("like", _) => self.like = Some(meaning.to_owned()),
            ("mark", _) => {
                let (points, mark) = meaning.split_once(' ').expect("points and a pattern");
                self.marks.push((points.parse().expect("a number of points"), mark.to_owned()));
            }
            (_, [Some(codes), _]) => arms(&mut self.codes[0], &codes, meaning),
            (_, [_, Some(codes)]) => arms(&mut self.codes[1], &codes, meaning),
            _ => self.rules.push((words.to_owned(), meaning.to_owned())),
        }
    }

    /// With the rules, codes and names of the control that it is like behind its own.
    fn with_base(&self, controls: &BTreeMap<String, Self>) -> Self {
        let mut whole = self.clone();
        if let Some(base) = &self.like {
            let base = controls.get(base).expect("the control that it is like");
            let known = |rule: &str| self.rules.iter().any(|(own, _)| own == rule);
            whole.rules.extend(base.rules.iter().filter(|(rule, _)| !known(rule)).cloned());
            whole.names.extend(base.names.iter().cloned());
            for (own, others) in whole.codes.iter_mut().zip(&base.codes) {
                own.push_str(others);
            }
        }
        whole
    }

    /// The dialect of a control that is like another.
    fn dialect(&self, name: &str, like: &str) -> String {
        let (upper, lower, base) = (constant(name), function(name), constant(like));
        let marks: String = self.marks.iter().map(|(points, mark)| format!("({points}, {mark:?}), ")).collect();
        format!(
            "Dialect {{ name: {name:?}, like: {like:?}, marks: &[{marks}], rules: {upper}, g: {lower}_g, m: {lower}_m, \
             ..dialect::{base} }}, "
        )
    }

    fn written(mut self, name: &str) -> String {
        let (upper, lower) = (constant(name), function(name));
        let [g, m] = self.codes;
        let rules: String = self.rules.iter().map(|(rule, value)| format!("    {rule}: {value},\n")).collect();
        let mut text = format!(
            "/// What {name} does beyond the meaning of codes.\npub const {upper}: Rules = Rules {{\n{rules}    ..Rules::USUAL\n}};\n\
             /// M codes of {name}.\n#[allow(unreachable_patterns, clippy::match_overlapping_arm)]\n\
             pub fn {lower}_m(number: u16) -> Option<M> {{\n    Some(match number {{\n{m}        _ => return None,\n    }})\n}}\n",
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

/// The name of a control as a constant.
fn constant(name: &str) -> String {
    name.replace('-', "_").to_uppercase()
}

/// The name of a control as the beginning of a function's.
fn function(name: &str) -> String {
    name.replace('-', "_")
}

fn arms(out: &mut String, codes: &[String], meaning: &str) {
    let value = if meaning == UNKNOWN { "return None" } else { meaning };
    codes.iter().try_for_each(|code| writeln!(out, "        {code} => {value},")).expect("memory takes text");
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
