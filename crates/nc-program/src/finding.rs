//! What is noticed in a program: same codes as the errors of the Python package.

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The program cannot be run as it stands, or does not do what it says.
    Error,
    /// Likely a slip.
    Warning,
    /// Worth knowing.
    Note,
}

/// A parameter without a value.
pub const PARAMETER: &str = "NC-PARAMETER";
/// An expression without a value.
pub const EXPRESSION: &str = "NC-EXPRESSION";
/// Text that the dialect does not know.
pub const WORD: &str = "NC-WORD";
/// A G or M code that the dialect does not know.
pub const CODE: &str = "NC-CODE";
/// A word twice in a block.
pub const DUPLICATE: &str = "NC-DUPLICATE";
/// A number written in a way the control does not take.
pub const NUMBER: &str = "NC-NUMBER";
/// A word or code without effect where it stands.
pub const MISPLACED: &str = "NC-MISPLACED";
/// An arc that cannot exist.
pub const ARC: &str = "NC-ARC";
/// An arc whose end is not on its circle.
pub const ARC_FIT: &str = "NC-ARC-FIT";
/// Recognised, but not part of the path.
pub const OPAQUE: &str = "NC-OPAQUE";
/// Flow control that does not fit together.
pub const FLOW: &str = "NC-FLOW";
/// A tool for compensation whose radius or tip is not known.
pub const TOOL: &str = "NC-TOOL";
/// A corner or an arc that the tool does not fit into.
pub const GOUGE: &str = "NC-GOUGE";
/// Compensation that cannot begin or change as it is programmed.
pub const ENTRY: &str = "NC-ENTRY";
/// A cut without a feed, a feed below zero.
pub const FEED: &str = "NC-FEED";
/// A unit that the program does not say.
pub const UNIT: &str = "NC-UNIT";
/// Whether X is a diameter, which the program does not say.
pub const DIAMETER: &str = "NC-DIAMETER";
/// A bound on blocks, depth or moves was reached.
pub const LIMIT: &str = "NC-LIMIT";

/// Notes beyond this many are not kept, and warnings and errors beyond twice and three times as many: a file that is no
/// program would drown the ones that matter.
pub const MOST: usize = 1000;

/// What a finding says is missing from the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// Nothing that moves.
    Nothing,
    /// What a macro, a cycle or a block does.
    Block,
    /// Moves of a cycle that is in force, or was defined before.
    Moves,
    /// Touches, and what they set.
    Touches,
}

impl Unseen {
    /// Its name outside.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "",
            Self::Block => "block",
            Self::Moves => "moves",
            Self::Touches => "touches",
        }
    }
}

/// Something noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// The catalogue's code.
    pub code: &'static str,
    /// What is wrong, with values.
    pub message: String,
    /// How to mend it.
    pub hint: String,
    /// Byte of the source at which it is.
    pub at: usize,
    /// What it says is missing from the path.
    pub unseen: Unseen,
}

/// Adds a finding unless there are too many or it is there already; a warning at its place hides no error.
pub(crate) fn add(findings: &mut Vec<Finding>, finding: Finding) {
    let hides = |other: Severity| finding.severity != Severity::Error || other == Severity::Error;
    let known = |other: &Finding| other.at == finding.at && other.code == finding.code && hides(other.severity);
    let room = match finding.severity {
        Severity::Note => MOST,
        Severity::Warning => 2 * MOST,
        Severity::Error => 3 * MOST,
    };
    if findings.len() < room && !findings.iter().any(known) {
        findings.push(finding);
    }
}

/// Text of the source for a message: at most 40 characters.
pub(crate) fn excerpt(text: &[u8]) -> String {
    text.iter()
        .take(40)
        .map(|byte| if byte.is_ascii_graphic() || *byte == b' ' { char::from(*byte) } else { '?' })
        .collect()
}
