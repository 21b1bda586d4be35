//! NC programs: read without loss, run to a tool path, every coordinate tied to the word that set it.
//!
//! A program is its bytes. The lexer lays blocks (one a line) and words over them as spans; nothing is copied and
//! nothing is normalised, so writing an unedited program is writing its bytes. A dialect is one constant
//! ([`Dialect`]): how words, comments, parameters and expressions are spelt, and what each code means. The runner
//! knows meanings only, never a dialect's code numbers.
//!
//! Units inside are millimetres, X is a radius. No input makes this crate panic; loops, depth and sizes are bounded.

mod compensation;
pub mod controls;
pub mod dialect;
mod drilling;
mod emit;
pub mod finding;
mod lint;
mod modes;
mod motion;
mod order;
mod path;
mod reading;
mod run;
mod session;
mod shapes;
pub mod table;
mod turning;
mod values;

pub use dialect::Dialect;
pub use drilling::hole::{Drilled, Said};
pub use drilling::hole_places::Placed;
pub use drilling::milled::Space;
pub use emit::Executed;
pub use finding::{Finding, Severity};
pub use lint::{first_unknown, lint};
pub use modes::linear::Linear;
pub use modes::modal::{Compensation, FeedMode, Modal, Motion, Plane, SpindleMode};
pub use modes::rotary::rotary_letters;
pub use modes::tool::{tip_direction, Tool};
pub use order::macro_call::calls_touch;
pub use path::{Arc, MoveKind, Origin, ToolPath, Turned};
pub use reading::number;
pub use reading::program::meaning;
pub use reading::program::{Block, Program, TooLarge, Word, WordKind};
pub use reading::statement::{offset_statements, OffsetStatement};
pub use run::{run, Options};
pub use session::{jumps, Session};
pub use shapes::arc::through;
pub use values::parameters::Key;
pub use values::uses::{parameters_used, place_read};
