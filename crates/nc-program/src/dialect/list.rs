//! The dialects: one constant a control. What its codes and names mean is in `codes.tsv` and `controls.tsv`, and which of them
//! are confirmed, and by what, in docs/dialects.md.

use super::{
    common_classes, Blanks, Class, Dialect, FlowStyle, Functions, Letters, Names, Naming, Parameters, ToolOffset,
};
use crate::controls;
use crate::modes::modal::{FeedMode, Modal, Plane};

/// The properties of a dialect that states no others.
const PLAIN: Dialect = Dialect {
    name: "",
    like: "",
    marks: &[],
    names: Names::NONE,
    formulas: false,
    classes: common_classes(&[]),
    brackets: (b'[', b']'),
    parameters: Parameters { mark: 0, named: Naming::None, computed: false, unset_is_zero: false },
    functions: Functions::None,
    blanks: Blanks::End,
    decimal_comma: false,
    turns: false,
    line_angle: b"",
    about_pole: false,
    flow: FlowStyle::None,
    increments: None,
    tool_offset: ToolOffset::Unknown,
    rules: controls::Rules::USUAL,
    other_axes: Letters::of(b""),
    letters: Letters::of(b""),
    cycle_letters: Letters::of(b""),
    g: |_| None,
    m: |_| None,
    initial: Modal::INITIAL,
    resolution: (1e-4, 1e-3),
    comment: ("(", ")"),
};

/// The state at the start of most lathes.
const TURNS: Modal = Modal { diameter: true, plane: Plane::Zx, feed_mode: FeedMode::PerRevolution, ..Modal::INITIAL };

/// GE Mark Century 2000T, as in the turning programs of NISTIR 6811, Appendix A. X is a diameter, I a radius; arc centres are
/// signed offsets from the start point, so an arc may turn through more than a quadrant. Parameters P1, P2, … of a cycle are
/// words of its block; others are variables.
pub const GE2000T: Dialect = Dialect {
    name: "ge2000t",
    classes: common_classes(&[(b'!', Class::LineComment), (b'(', Class::Statement)]),
    brackets: (b'(', b')'),
    parameters: Parameters { mark: b'P', ..PLAIN.parameters },
    decimal_comma: true,
    rules: controls::GE2000T,
    letters: Letters::of(b"FGIJKMNPQRSTXYZ"),
    g: controls::ge2000t_g,
    m: controls::ge2000t_m,
    initial: Modal { inch: true, diameter: true, plane: Plane::Zx, ..Modal::INITIAL },
    resolution: (1e-5, 1e-4),
    comment: ("! ", ""),
    ..PLAIN
};

/// RS-274 as LinuxCNC 2.9 reads it.
pub const LINUXCNC: Dialect = Dialect {
    name: "linuxcnc",
    classes: common_classes(&[
        (b';', Class::LineComment),
        (b'(', Class::Comment),
        (b'#', Class::Parameter),
        (b'@', Class::Letter),
        (b'^', Class::Letter),
    ]),
    parameters: Parameters { mark: b'#', named: Naming::Brackets, computed: true, unset_is_zero: true },
    functions: Functions::Rs274,
    blanks: Blanks::WithinNumber,
    turns: true,
    flow: FlowStyle::OWords,
    tool_offset: ToolOffset::Code,
    rules: controls::LINUXCNC,
    other_axes: Letters::of(b"ABCUVW"),
    letters: Letters::of(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"),
    g: controls::linuxcnc_g,
    m: controls::linuxcnc_m,
    initial: Modal { inch: true, ..Modal::INITIAL },
    resolution: (1e-6, 1e-5),
    ..PLAIN
};

/// Fanuc series 16 to 31 with custom macro B, milling. What the manuals leave to the machine's parameters (numbers without a
/// point, offsets of T) is reported where a program depends on it. Most M codes are the machine builder's.
pub const FANUC_MILL: Dialect = Dialect {
    name: "fanuc-mill",
    classes: common_classes(&[
        (b';', Class::BlockEnd),
        (b'(', Class::Comment),
        (b'#', Class::Parameter),
        (b',', Class::Comma),
        (b':', Class::Letter),
    ]),
    parameters: Parameters { mark: b'#', computed: true, ..PLAIN.parameters },
    functions: Functions::Macro,
    blanks: Blanks::BeforeNumber,
    flow: FlowStyle::Macro,
    tool_offset: ToolOffset::Code,
    rules: controls::FANUC_MILL,
    other_axes: Letters::of(b"ABC"),
    letters: Letters::of(b"ABCDEFGHIJKLMNOPQRSTXYZ"),
    g: controls::fanuc_mill_g,
    m: controls::fanuc_mill_m,
    ..PLAIN
};

/// Turning, code system A: X, Z absolute, U, W increments, G98/G99 feed a minute and a revolution.
pub const FANUC_LATHE: Dialect = Dialect {
    name: "fanuc-lathe",
    letters: Letters::of(b"ACDEFGHIJKLMNOPQRSTUVWXYZ"),
    line_angle: b"Aa",
    rules: controls::FANUC_LATHE,
    increments: Some(*b"UVW"),
    tool_offset: ToolOffset::InT,
    other_axes: Letters::of(b"CH"),
    g: controls::fanuc_lathe_g,
    m: controls::fanuc_lathe_m,
    initial: TURNS,
    ..FANUC_MILL
};

/// Turning, code system B: G90/G91, G94/G95 as in milling, cycles G77 to G79.
pub const FANUC_LATHE_B: Dialect = Dialect {
    name: "fanuc-lathe-b",
    g: controls::fanuc_lathe_b_g,
    m: controls::fanuc_lathe_b_m,
    rules: controls::FANUC_LATHE_B,
    increments: None,
    other_axes: Letters::of(b"CHUW"),
    ..FANUC_LATHE
};

/// Haas turning: as Fanuc, but for G28 alone, which sends every axis home, M97, and codes of its own.
pub const HAAS_LATHE: Dialect = Dialect {
    name: "haas-lathe",
    g: controls::haas_lathe_g,
    m: controls::haas_lathe_m,
    rules: controls::HAAS_LATHE,
    initial: Modal { motion: controls::HAAS_LATHE.starts_with, ..TURNS },
    ..FANUC_LATHE
};

/// Haas milling.
pub const HAAS_MILL: Dialect = Dialect {
    name: "haas-mill",
    g: controls::haas_mill_g,
    m: controls::haas_mill_m,
    rules: controls::HAAS_MILL,
    initial: Modal { motion: controls::HAAS_MILL.starts_with, ..Modal::INITIAL },
    ..FANUC_MILL
};

/// Siemens Sinumerik 840D, turning and milling. No control and no simulator has confirmed a path. What hangs on machine
/// data, such as diameters at the start, a program has to say: DIAMON or DIAMOF, G17 or G18.
pub const SIEMENS: Dialect = Dialect {
    name: "siemens",
    names: controls::SIEMENS_NAMES,
    formulas: true,
    classes: common_classes(&[(b';', Class::LineComment), (b'_', Class::Name), (b'$', Class::Name)]),
    brackets: (b'(', b')'),
    parameters: Parameters { mark: b'R', named: Naming::Plain, computed: true, unset_is_zero: false },
    functions: Functions::Siemens,
    line_angle: b"n",
    flow: FlowStyle::Structured,
    tool_offset: ToolOffset::Edge(b'D'),
    rules: controls::SIEMENS,
    other_axes: Letters::of(b"ABCUVWlo"),
    letters: Letters::of(b"ABCDFGHIJKLMNPRSTUVWXYZ"),
    g: controls::siemens_g,
    m: controls::siemens_m,
    initial: Modal { motion: controls::SIEMENS.starts_with, ..Modal::INITIAL },
    resolution: (1e-5, 1e-4),
    comment: ("; ", ""),
    ..PLAIN
};

/// Heidenhain Klartext (TNC 426 to TNC 640), milling. No control and no simulator has confirmed a path. A block's function
/// says how its coordinates move: nothing of it stays in force but feed, compensation and the pole.
pub const HEIDENHAIN: Dialect = Dialect {
    name: "heidenhain",
    names: controls::HEIDENHAIN_NAMES,
    formulas: true,
    classes: {
        let own =
            [(b';', Class::LineComment), (b'*', Class::LineComment), (b'(', Class::Comment), (b'~', Class::Space)];
        let mut classes = common_classes(&own);
        (classes[b'R' as usize], classes[b'M' as usize]) = (Class::Name, Class::Name);
        let mut digit = b'0' as usize;
        while digit <= b'9' as usize {
            classes[digit] = Class::Digit;
            digit += 1;
        }
        classes
    },
    brackets: (b'(', b')'),
    parameters: Parameters { mark: b'Q', named: Naming::Plain, computed: true, unset_is_zero: false },
    functions: Functions::Klartext,
    decimal_comma: true,
    blanks: Blanks::BeforeNumber,
    about_pole: true,
    flow: FlowStyle::Labels,
    tool_offset: ToolOffset::Call,
    rules: controls::HEIDENHAIN,
    other_axes: Letters::of(b"ABCUVW"),
    letters: Letters::of(b"ABCFMNQRSTUVWXYZ"),
    m: controls::heidenhain_m,
    resolution: (1e-5, 1e-4),
    comment: ("; ", ""),
    ..PLAIN
};

/// Okuma OSP, turning, with its lathe auto-programming (LAP). Attachments, the second turret and flow control are said and
/// not followed.
pub const OKUMA_LATHE: Dialect = Dialect {
    name: "okuma-lathe",
    names: controls::OKUMA_LATHE_NAMES,
    formulas: true,
    classes: common_classes(&[(b'(', Class::Comment), (b'$', Class::Name)]),
    parameters: Parameters { mark: b'V', named: Naming::Plain, computed: true, unset_is_zero: false },
    functions: Functions::Macro,
    tool_offset: ToolOffset::Edge(b'u'),
    rules: controls::OKUMA_LATHE,
    other_axes: Letters::of(b"CUWY"),
    letters: Letters::of(b"ABCDEFGHIJKLMNOPQSTUVWXYZ"),
    cycle_letters: Letters::of(b"AB"),
    g: controls::okuma_lathe_g,
    m: controls::okuma_lathe_m,
    initial: TURNS,
    ..PLAIN
};
