//! The image: a file of numbers, checked as a whole before one of them is used.

/// Why a file is no image for this machine. The numbers are those that `reload-error` shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Refusal {
    /// The file cannot be read.
    Missing = 1,
    /// Nothing in it.
    Empty = 2,
    /// It ends before what it says it holds.
    Short = 3,
    /// Its length is no whole number of words.
    Odd = 4,
    /// It goes on after what it says it holds, or holds more than there may be.
    Long = 5,
    /// It does not begin as an image does.
    Magic = 6,
    /// Another version of the format.
    Version = 7,
    /// Its SHA-256 is another than it says.
    Hash = 8,
    /// It was made for another machine.
    Serial = 9,
    /// A count that is none, or does not fit the rest.
    Count = 10,
    /// A number that is not finite.
    NotFinite = 11,
    /// Its table belongs to another program.
    Program = 12,
    /// Program lines that do not ascend.
    Order = 13,
    /// Segments or coefficients that make no function of position.
    Body = 14,
    /// Limits, ranges or travels that are none.
    Limits = 15,
}
