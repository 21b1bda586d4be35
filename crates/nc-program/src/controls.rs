//! What controls make of the same words: rules, codes and names of each, from `codes.tsv` and from `controls.tsv`, which
//! names the evidence.

use crate::dialect::{self, Dialect, Name, Names, PoleFrom, G, M};
use crate::drilling::drill::Drill;
use crate::drilling::hole_places::Pattern;
use crate::drilling::milled::Pocket;
use crate::modes::modal::{Compensation, FeedMode, Motion, Plane, SpindleMode};
use crate::order::flow::Flow;
use crate::shapes::spline::Spline;
use crate::turning::lap::Lap;
use crate::turning::level_cuts::Pockets;
use crate::turning::pass::Pass;
use crate::turning::profile_cycle::Profile;
use crate::turning::removal::Removal;
use crate::turning::rough::Rough;

include!(concat!(env!("OUT_DIR"), "/controls.rs"));

/// A parameter of the machine that decides what a word means, by the name under which a user gives its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// As the control's maker numbers it: `3401#0`, `MD10240`, `SETTING162`.
    pub name: &'static str,
    /// What its values mean.
    pub says: &'static str,
}

/// What F counts without a decimal point, in mm and in inch, where the parameter is 0; 1 means whole units at any value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeedSteps {
    /// The parameter that decides.
    pub parameter: Parameter,
    /// Of a feed a minute.
    pub per_minute: [f64; 2],
    /// Of a feed a revolution.
    pub per_revolution: [f64; 2],
    /// Of an inverse time.
    pub inverse_time: f64,
}

/// What a move to a place of the machine (G53) does while positions are increments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineIncrements {
    /// It goes there all the same.
    Positions,
    /// It goes by the increments, from where it is.
    Increments,
    /// The control stops, or does not obey the code.
    Refused,
}

/// What controls do differently with the same codes.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// The motion in force at the start; `None` where none is known to be.
    pub starts_with: Motion,
    /// The parameter that says which: 0 rapid, 1 a line.
    pub start_motion: Option<Parameter>,
    /// The parameter that says whether lengths without a decimal point count steps of the control (0) or whole units (1).
    pub point: Option<Parameter>,
    /// The same of F.
    pub feed_point: Option<FeedSteps>,
    /// The parameter that says in which unit F counts where a code switches the unit of lengths alone: 0 inch, 1 mm.
    pub basic_unit: Option<Parameter>,
    /// The parameter that says whether a shift leaves what was added to the one before (1) or takes it away (0).
    pub kept_fine: Option<Parameter>,
    /// The parameter that says whether an increment goes by a shift that came since its axis moved (1), or not (0).
    pub skipped_shift: Option<Parameter>,
    /// On a straight move R rounds its corner, I and K break it.
    pub plain_corners: bool,
    /// The parameter that says whether I and K (0) or C (1) do that.
    pub corner_letters: Option<Parameter>,
    /// Parameters of G51: the step of its factors (0: 0.00001, 1: 0.001), and whether the tool's axis is scaled (1).
    pub scale: Option<[Parameter; 2]>,
    /// The parameter that says whether scaling leaves the tool's axis as it is (1) or scales it, too (0).
    pub plane_scaling: Option<Parameter>,
    /// The parameter that says whether angles of ATAN are counted from 0 to 360 degrees (0) or from -180 to 180 (1).
    pub arc_tangent: Option<Parameter>,
    /// Part of an inch that F counts a minute.
    pub inch_feed: f64,
    /// An inverse time is said anew in every cut.
    pub inverse_time_each_cut: bool,
    /// G54 with P names one of the further work offsets.
    pub offset_by_p: bool,
    /// The letter, beside Q, of the block at which a program called by M98 begins.
    pub begins_at: u8,
    /// A move to a place of the machine is at rapid, whatever motion is in force.
    pub machine_moves_rapid: bool,
    /// What one does under increments.
    pub machine_increments: MachineIncrements,
    /// A return to the reference point takes the tool's length away.
    pub home_ends_length: bool,
    /// The unit may not change after a length.
    pub unit_once: bool,
    /// An absolute arc centre needs both its words.
    pub centre_whole: bool,
    /// A local shift (G52) holds in the work offset in which it is written; each has its own.
    pub shift_of_each_offset: bool,
    /// T of six digits names tool and offset by three digits each.
    pub six_digit_tools: bool,
    /// The letter of an arc's radius.
    pub radius_letter: u8,
    /// Compensation begins on a straight move.
    pub straight_entry: bool,
    /// It ends on one.
    pub straight_exit: bool,
    /// Most digits of a length; 0 where there is no bound.
    pub most_digits: u8,
    /// What a slash in the middle of a block leaves out: the words after it.
    pub slash_within: bool,
    /// Orientations of a lathe tool's tip are counted with the turret in front of the axis, as LinuxCNC does.
    pub tip_in_front: bool,
    /// Compensation begins square to the second move's start; else square to the first move's end.
    pub enters_beside_next: bool,
    /// Angle (rad) by which compensation may make an arc longer before a corner or its end: in a program in mm, and in
    /// inch.
    pub longer_arc: Option<[f64; 2]>,
    /// R of a drilling cycle counts from where the cycle begins, and one without Q makes no pecks.
    pub drills_from_start: bool,
    /// A drilling cycle without R feeds from where it begins.
    pub drills_without_plane: bool,
    /// Pecks are by Q, or by I, J and K; K does not count holes.
    pub pecks_by_k: bool,
    /// Drilling cycles retract to the plane R (G99) from the start on; else to where they began (G98).
    pub retracts_to_plane: bool,
    /// Whether X is a diameter at the start is machine data: a turning program has to say it.
    pub diameter_is_machine_data: bool,
    /// The lead of a tapered thread counts along the thread; else along the axis on which it is longer.
    pub lead_along_thread: bool,
    /// Blocks may have names behind N: `NLAP1`.
    pub sequence_names: bool,
    /// A name before an equals sign is a variable, but for those that begin with N, O, S or V.
    pub local_names: bool,
}

impl Rules {
    /// Those of most controls.
    pub const USUAL: Self = Self {
        starts_with: Motion::None,
        start_motion: None,
        point: None,
        feed_point: None,
        basic_unit: None,
        kept_fine: None,
        skipped_shift: None,
        plain_corners: false,
        corner_letters: None,
        scale: None,
        plane_scaling: None,
        arc_tangent: None,
        inch_feed: 1.0,
        inverse_time_each_cut: false,
        offset_by_p: false,
        begins_at: b'Q',
        machine_moves_rapid: false,
        machine_increments: MachineIncrements::Positions,
        home_ends_length: false,
        unit_once: false,
        centre_whole: false,
        shift_of_each_offset: false,
        six_digit_tools: false,
        radius_letter: b'R',
        straight_entry: false,
        straight_exit: false,
        most_digits: 0,
        slash_within: false,
        tip_in_front: false,
        enters_beside_next: true,
        longer_arc: None,
        drills_from_start: false,
        drills_without_plane: false,
        pecks_by_k: false,
        retracts_to_plane: false,
        diameter_is_machine_data: false,
        lead_along_thread: false,
        sequence_names: false,
        local_names: false,
    };

    /// Every parameter of the machine that decides.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter> {
        let feed = self.feed_point.map(|steps| steps.parameter);
        let all = [
            self.start_motion,
            self.point,
            feed,
            self.basic_unit,
            self.kept_fine,
            self.skipped_shift,
            self.corner_letters,
            self.plane_scaling,
            self.arc_tangent,
        ];
        all.into_iter().flatten().chain(self.scale.into_iter().flatten())
    }
}
