//! What G and M codes mean. The runner knows these meanings, no control's numbers.

use crate::drilling::drill::Drill;
use crate::drilling::hole_places::Pattern;
use crate::drilling::milled::Pocket;
use crate::modes::modal::{Compensation, FeedMode, Motion, Plane, SpindleMode};
use crate::shapes::curve::PoleFrom;
use crate::turning::lap::Lap;
use crate::turning::pass::Pass;
use crate::turning::profile_cycle::Profile;
use crate::turning::removal::Removal;
use crate::turning::rough::Rough;

/// What a G code means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum G {
    /// Sets the motion of this and later blocks.
    Motion(Motion),
    /// The head of a program, whose last word is its unit: `BEGIN PGM PLATE MM`.
    Heading,
    /// Names the contours of the milling cycles behind it: `CYCL DEF 14.1 CONTOUR LABEL1 /2`.
    ContourLabels,
    /// Names places of holes: `PATTERN DEF POS1 (X+25 Y+33 Z+0)`.
    DefinePattern,
    /// Runs the cycle defined last at those places.
    CallPattern,
    /// Calls the program of a file: `CALL PGM BORES.H`.
    CallFile,
    /// Its end: `END PGM BORES MM`.
    EndFile,
    /// The feed is that of the tool's call: FAUTO.
    FeedOfTool,
    /// A line of this block is at rapid.
    Fast,
    /// A drilling cycle, until another motion code.
    Drill(Drill),
    /// A lathe's drilling cycle along that axis (0 is X, 2 is Z), until another motion code.
    DrillAlong(Drill, u8),
    /// A simple turning cycle, until another motion code.
    Pass(Pass),
    /// A thread cut in passes.
    Thread,
    /// Drilling cycles retract to the plane R (true) or to where they began (false).
    RetractToPlane(bool),
    /// No motion until the next motion code.
    NoMotion,
    /// Ends a drilling cycle: the motion before it stays in force.
    EndCycle,
    /// Plane of arcs.
    Plane(Plane),
    /// Inch (true) or metric (false).
    Inch(bool),
    /// The same of lengths alone: F stays in the machine's basic unit.
    LengthsInch(bool),
    /// Increments (true) or absolute positions (false).
    Incremental(bool),
    /// Arc centres absolute (true) or from the start point (false).
    CentreAbsolute(bool),
    /// X is a diameter (true) or a radius (false).
    Diameter(bool),
    /// X is a diameter in absolute positions, a radius in increments.
    DiameterOfPositions,
    /// Words on X are diameters (X1) or radii (X0) from here on: nothing moves.
    DiameterByWord,
    /// Unit of feed.
    Feed(FeedMode),
    /// Unit of spindle speed.
    Spindle(SpindleMode),
    /// Both at once.
    SpeedAndFeed(SpindleMode, FeedMode),
    /// The feed holds over the path (true), or changes along it.
    SteadyFeed(bool),
    /// The head of a subprogram: SAVE brings the caller's modes back at its end.
    Procedure,
    /// Cutter compensation.
    Compensation(Compensation),
    /// The same with the tool's diameter in D and its tip in L.
    CompensationGiven(Compensation),
    /// Sets the position register: what the position is called, the tool does not move.
    SetRegister,
    /// Sets the register's offset itself, axis by axis.
    OffsetRegister,
    /// Sets the register's offset of all axes, zero where none is given; adds to it if true.
    Shift(bool),
    /// X and Y of what follows are radius and angle about the zero of the coordinates, in G17; false ends it.
    Polar(bool),
    /// Sets the pole of polar coordinates.
    Pole(PoleFrom),
    /// Takes the register setting back; true forgets it, false keeps it for `RestoreRegister`.
    CancelRegister(bool),
    /// Puts a cancelled register setting back.
    RestoreRegister,
    /// Selects a work offset, from 1.
    WorkOffset(u16),
    /// Selects the one of P among the further ones.
    ExtendedOffset,
    /// This block is in machine coordinates.
    MachineCoordinates,
    /// Tool length offset given in this block.
    ToolOffset,
    /// Tool length offset from the tool table, which a program does not carry: added (true) or taken away.
    ToolTableOffset(bool),
    /// No tool length offset.
    NoToolOffset,
    /// Sets offsets by L and P.
    SetData,
    /// Sets work offsets by L2 and P1 to P6; with anything else data that a path does not follow.
    SetWorkOffset,
    /// To a stored machine position: the first or the second.
    Home(u8),
    /// The same, of the axes that the block names only: without one nothing moves.
    HomeNamed(u8),
    /// The tool's axis to the limit of its travel.
    Retract,
    /// The axes that the block names to a fixed point of the machine, by their own names or the machine's.
    FixedPoint,
    /// Stores the present machine position as the first or the second.
    StoreHome(u8),
    /// Longitudinal turning cycle: X, Z, P1 depth of cut, P2 start of the exit taper.
    TurningCycle,
    /// A dwell whose time may be written as a coordinate.
    Dwell,
    /// A dwell of P seconds beside a move.
    Pause,
    /// A cycle that the runner knows but does not take apart: it ends where it began.
    OpaqueCycle,
    /// Such a cycle that stays in force: later coordinates call it again.
    OpaqueMotion,
    /// Such a cycle, or a call of what is not in the program, in this block only.
    OpaqueBlock,
    /// Such a cycle or call that cuts where the block names no axis: holes by the cycle in force.
    OpaqueCut,
    /// Changes where later positions are in a way that the runner does not follow.
    OpaqueMode,
    /// Turns the plane by R about a point: G68.
    Rotate,
    /// Ends that.
    EndRotation,
    /// Multiplies coordinates: G51.
    Scale,
    /// Ends that.
    EndScale,
    /// Mirrors axes at the positions named, or at zero.
    Mirror(bool),
    /// Ends that.
    EndMirror,
    /// Goes to the first point of a contour, on a way of the control's own.
    Approach,
    /// Leaves a contour so and ends compensation: to the point that the block names, or to one that follows from the contour.
    Leave(bool),
    /// Turns, scales or mirrors what follows; without influence where its values are those of a reset.
    Turn,
    /// The same, which takes shifts away, too.
    TurnAnew,
    /// The length of a tool, in the program.
    DefineTool,
    /// Calls the program of P with arguments.
    CallMacro,
    /// Calls it after each move that follows.
    ModalMacro,
    /// No macro after moves any more.
    EndModalMacro,
    /// Grooves side by side, in pecks along that axis (0 is X, 2 is Z).
    Groove(u8),
    /// A cycle from where the tool stands to X and Z, by passes of the control's own.
    OwnCycle,
    /// A round pocket about where the block goes, by circles of the control's own.
    CirclePocket,
    /// Goes on at the block of a name, on a condition where the word has one: GOTO, IF.
    GoToName,
    /// Goes on with the block before: `$`.
    Continued,
    /// A drilling cycle by its arguments, here: CYCLE81.
    HoleCycle(Drill),
    /// A pocket by its arguments: POCKET3, POCKET4.
    MillPocket(Pocket),
    /// The cycle behind it runs after each move: MCALL.
    ModalCycle,
    /// A cycle of that number is defined by Q parameters; `None` where it is not followed.
    DefineCycle(Option<(u16, Drill)>),
    /// Gives such a cycle the value of a numbered line.
    CycleLine,
    /// Runs it.
    CallCycle,
    /// Runs it at the block's place.
    CallCycleAt,
    /// A hole pattern by its arguments.
    Pattern(Pattern),
    /// Ends the shift of the datum (TRANS DATUM RESET).
    ResetDatum,
    /// Touches the work or the tool and sets what the control knows of them: TCH PROBE.
    Probe,
    /// Gives a parameter a value of the control's own.
    SystemData,
    /// Ends the points of a spline, which is cut.
    EndSpline,
    /// Runs the blocks from N of P to N of Q, then goes back to where it began.
    FinishContour,
    /// Roughs out the contour between N of P and N of Q; these blocks are passed over.
    RoughContour(Rough),
    /// Lathe auto-programming: contours by their sequence name.
    Lap(Lap),
    /// Roughs out or finishes the contour that its arguments name, or names it.
    Removal(Removal),
    /// Runs on, or roughs out, the contour of the subroutine that Q names.
    Profile(Profile),
    /// Sets how closely or how fast the path is followed, where the letter has one of these values; else who knows.
    Setting(u8, &'static [f64]),
    /// The same by the arguments of a cycle: CYCLE832.
    ToleranceCycle,
    /// A swivelled plane by the arguments of a cycle; without arguments none: CYCLE800().
    Swivel,
    /// Selects a preset, the number of which stands in its text or in the line after it.
    Preset,
    /// A place of the machine counted from a point of its builder's.
    BuilderCoordinates,
    /// Runs the program of this file whose name stands behind it: CALL of OSP.
    CallNamed,
    /// Its words limit travel, or draw the blank (G1901); nothing moves.
    Limits,
    /// Without influence on the path.
    Inert,
}

/// What an M code means to the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum M {
    /// Ends the program.
    End,
    /// Runs the program of the number P, L times.
    CallProgram,
    /// Runs the blocks from N of P, L times.
    CallBlock,
    /// Goes back from a call; to N of P where that is given.
    Return,
    /// Runs a program that is not in this file (M198), or jumps by a signal of the machine (M96).
    Elsewhere,
    /// Puts the modal state away.
    SaveState,
    /// Puts it away and brings it back when the subroutine ends.
    SaveStateUntilReturn,
    /// Brings it back.
    RestoreState,
    /// Puts the tool of T into the spindle.
    ChangeTool,
    /// Runs the cycle defined last at the end of the move.
    CallCycle,
    /// The same after each move from here on.
    CallCycleAlways,
    /// Without influence on the path.
    Inert,
}
