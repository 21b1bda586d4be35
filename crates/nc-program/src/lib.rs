//! NC programs: read without loss, run to a tool path, every coordinate tied to the word that set it.
//!
//! A program is its bytes. The lexer lays blocks (one a line) and words over them as spans; nothing is copied and
//! nothing is normalised, so writing an unedited program is writing its bytes. A dialect is one constant
//! ([`Dialect`]): how words, comments, parameters and expressions are spelt, and what each code means. The runner
//! knows meanings only, never a dialect's code numbers.
//!
//! Units inside are millimetres, X is a radius. No input makes this crate panic; loops, depth and sizes are bounded.

mod arc;
mod asked;
mod beside;
mod called_cycle;
mod codes;
mod compensate;
mod contouring;
mod contradiction;
pub mod controls;
mod corner;
mod curve;
mod cycle_arguments;
pub mod dialect;
mod drawn;
mod drill;
mod emit;
mod entry;
mod expression;
pub mod finding;
mod flow;
mod follow;
mod frame;
mod frame_names;
mod functions;
mod gather;
mod groove;
mod hole;
mod hole_places;
mod home;
mod labels;
mod lap;
mod letters;
mod level_cuts;
mod lex;
mod lex_names;
mod lint;
mod macro_call;
mod macros;
mod modal;
mod motion;
mod names;
pub mod number;
mod offset;
mod operand;
mod parameters;
mod pass;
mod path;
mod profile_contour;
mod profile_cycle;
mod program;
mod removal;
mod removal_cuts;
mod request;
mod rotary;
mod rough;
mod rough_contour;
mod rough_cycle;
mod rough_pockets;
mod rounding;
mod run;
mod scan;
mod scope;
mod sections;
mod segment;
mod session;
mod setting;
mod spline;
mod state;
mod statement;
mod structured;
pub mod table;
mod thread;
mod thread_cycle;
mod tool;
mod tool_offset;
mod unit;
mod uses;
mod visit;

pub use dialect::Dialect;
pub use emit::Executed;
pub use finding::{Finding, Severity};
pub use hole::{Drilled, Said};
pub use hole_places::Placed;
pub use lint::{first_unknown, lint};
pub use modal::{Compensation, FeedMode, Modal, Motion, Plane, SpindleMode};
pub use parameters::Key;
pub use path::{Arc, MoveKind, Origin, ToolPath, Turned};
pub use program::meaning;
pub use program::{Block, Program, TooLarge, Word, WordKind};
pub use rotary::rotary_letters;
pub use run::{run, Options};
pub use session::{jumps, Session};
pub use statement::{offset_statements, OffsetStatement};
pub use tool::{tip_direction, Tool};
pub use uses::parameters_used;
