//! What the numbers on the pins are called: the one place that says it, for the component and for Python.

use core::ffi::CStr;

/// A number, its name, and its meaning: `name: meaning`.
pub type Named = (i32, &'static CStr);

/// [`crate::corrector::Phase`].
pub const PHASES: [Named; 7] = [
    (0, c"off: not asked for"),
    (
        1,
        c"waiting: asked for, not homed, or drives off, or probing, or a signal out of order",
    ),
    (2, c"ramping: on the way to what is wanted"),
    (3, c"in force: what is wanted is added"),
    (
        4,
        c"frozen: a signal is bad, its last good reading stands in for it",
    ),
    (
        5,
        c"leaving: a signal stayed bad, the correction fades to zero",
    ),
    (
        6,
        c"faulted: zero, or on the way there, until enable goes off",
    ),
];

/// [`crate::corrector::Fault`], 0 for none.
pub const FAULTS: [Named; 11] = [
    (0, c"none: no fault"),
    (1, c"limit: a correction beyond the limit"),
    (
        2,
        c"not a number: a position, tool offset or correction that is none",
    ),
    (3, c"travel: the drive would leave its travel"),
    (4, c"stale: a signal is older than it may be"),
    (
        5,
        c"range: a signal is outside the range in which the model holds, or not a number",
    ),
    (6, c"jump: a signal jumped"),
    (7, c"watchdog: the signals' component is silent"),
    (
        8,
        c"program: another program runs than the one that the table belongs to",
    ),
    (
        9,
        c"off path: a block of the table is cut elsewhere than the table says",
    ),
    (
        10,
        c"settings: a limit, slew or time that is negative or not a number",
    ),
];

/// [`crate::image::Refusal`], 0 for none.
pub const REFUSALS: [Named; 16] = [
    (0, c"none: it is an image"),
    (1, c"missing: the file cannot be read"),
    (2, c"empty: nothing is in it"),
    (3, c"short: it ends before what it says it holds"),
    (4, c"odd: its length is no whole number of words"),
    (
        5,
        c"long: it goes on after what it says it holds, or holds more than 64 MB",
    ),
    (6, c"magic: it does not begin as an image does"),
    (7, c"version: it is of another version of the format"),
    (8, c"hash: its SHA-256 is another than it says"),
    (9, c"serial: it was made for another machine"),
    (10, c"count: a count that is none, or does not fit the rest"),
    (11, c"not finite: a number that is not finite"),
    (
        12,
        c"program: its table belongs to another program, or to none",
    ),
    (13, c"order: program lines that do not ascend"),
    (
        14,
        c"body: segments or coefficients that make no bounded function of position",
    ),
    (15, c"limits: limits, ranges, travels or rows that are none"),
];

/// [`crate::corrector::WaitsFor`], 0 for nothing.
pub const WAITS: [Named; 5] = [
    (0, c"nothing: not waiting"),
    (1, c"homing: until all joints are homed, and none is homing"),
    (2, c"drives: until they are on"),
    (3, c"probing: until it ends"),
    (4, c"signals: until every one is in order"),
];

/// Name and meaning of a number, `unknown: …` where there is none.
#[must_use]
pub fn text(names: &[Named], number: i32) -> &'static CStr {
    let found = names.iter().find(|(known, _)| *known == number);
    found.map_or(c"unknown: no such number", |(_, text)| text)
}
