//! What should be added at a place: minus the machine's error, and what the process' table says there.

use error_eval::Vector;

/// Axes X, Y, Z.
pub const AXES: usize = 3;
/// Signals at most.
pub const SIGNALS: usize = 16;

/// Where the machine is in one period.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// Commanded position of X, Y, Z, machine coordinates, mm.
    pub position: Vector,
    /// How each axis came there: +1 forward, −1 return, 0 not known.
    pub travel: Vector,
    /// Tool offset in force at the control, mm: the tool point is that of the image less this.
    pub tool_offset: Vector,
    /// Signals in the order of the image.
    pub signal: [f64; SIGNALS],
    /// Line of the program that moves; none where no program that the image knows is running.
    pub line: Option<i32>,
}

/// What should be added there, mm, by cause.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    /// −E at the corrected place.
    pub model: Vector,
    /// Of the table, where it has a row.
    pub table: Vector,
    /// Whether the table has blocks of this line.
    pub listed: bool,
    /// Whether it has a row for this place.
    pub on_path: bool,
}

/// What a signal may be, by the image.
#[derive(Clone, Copy, Debug)]
pub struct SignalRange {
    /// Lowest value at which the model holds.
    pub low: f64,
    /// Highest one.
    pub high: f64,
    /// By how much two readings that follow each other may differ at most.
    pub most_step: f64,
}

/// What the corrector asks: an image, or a stand-in of a test.
pub trait Asked {
    /// Signals that the model needs.
    fn signals(&self) -> &[SignalRange];
    /// Largest correction of an axis, mm.
    fn limit(&self) -> f64;
    /// Ends of travel of X, Y, Z, machine coordinates, mm: lowest, highest.
    fn travel(&self) -> [(f64, f64); AXES];
    /// Whether it holds a table, which belongs to one program.
    fn has_table(&self) -> bool;
    /// What should be added at a place.
    fn wanted(&mut self, place: &Place) -> Wanted;
}
