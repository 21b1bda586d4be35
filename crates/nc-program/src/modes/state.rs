//! What a run knows between two blocks, and takes along from one part of a program to the next.

use crate::dialect::{ToolOffset, G};
use crate::drilling::called_cycle::{CalledHole, Defined};
use crate::drilling::hole::Hole;
use crate::drilling::pattern_def::PatternPlace;
use crate::modes::frame::Frame;
use crate::modes::modal::{Modal, Motion, Plane};
use crate::modes::rotary::{rotary_letters, Rotary};
use crate::modes::unit::Unit;
use crate::order::macro_call::ModalMacro;
use crate::reading::program::{Program, Word};
use crate::run::Options;
use crate::shapes::contouring::Contouring;
use crate::shapes::spline::SplineData;
use crate::turning::pass::Passes;
use crate::turning::rough_cycle::RoughData;
use crate::turning::thread_cycle::ThreadData;
use crate::values::parameters::{Key, Store};

/// The state of the control; and what was met or said already.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub modal: Modal,
    /// States put away by the program, and whether its subroutine's end brings each back.
    pub saved: Vec<(Modal, Option<usize>)>,
    pub unit: Unit,
    pub diameter_is_known: bool,
    /// A word of the program has chosen the plane XY.
    pub xy_is_stated: bool,
    /// Y has moved in it.
    pub xy_is_milled: bool,
    pub frame: Frame,
    /// Where the tool is, in the frame in force.
    pub position: [f64; 3],
    /// Where the last touch was, as the program called it, mm: NaN along axes that moved towards it, and before the first.
    pub touched: [f64; 3],
    /// Corners and lines that wait for the next move.
    pub contouring: Contouring,
    /// The pole of polar coordinates, in the frame in which it was set.
    pub pole: [f64; 3],
    /// Radius and angle about the pole as they were said last, in mm and radians.
    pub polar_said: [f64; 2],
    /// X and Y are polar coordinates (G16).
    pub polar: bool,
    /// A loop of O words was left by `break`, and no `do` loop ended since.
    pub broke: bool,
    /// The plane of moves about the pole, where a block sets it (Klartext).
    pub pole_plane: Plane,
    pub store: Store,
    /// Parameters without a value that were reported already.
    pub undefined: Vec<Key<'static>>,
    /// Letters of axes that the path is without, that were reported already.
    pub other_axes: Vec<u8>,
    /// Tape marks met.
    pub tape_marks: usize,
    /// The last D word of a mill whose registers of radii D calls.
    pub radius_called: Option<f64>,
    /// The edge of the tool in use, and the plane in which its lengths were taken.
    pub edge: (i32, Plane),
    /// Lengths of tools that the program states, mm, by their numbers.
    pub defined_tools: Vec<(i32, f64)>,
    /// What the call of the tool adds to its radius, mm.
    pub oversize: f64,
    /// The drilling cycle in force.
    pub hole: Option<Hole>,
    /// The motion that stays in force when a drilling cycle ends.
    pub under_cycle: Motion,
    /// Compensation was switched, and no move in its plane has come since.
    pub switched: bool,
    /// The feed holds over a move.
    pub steady_feed: bool,
    /// F was said by FU: a revolution until the next F.
    pub feed_by_revolution: bool,
    /// Feed of every corner that follows, in program units; zero without one.
    pub corner_feed: f64,
    /// The feed that the call of the tool gave (Klartext), mm; negative where it gave none.
    pub tool_feed: f64,
    /// Parameters of the machine that were asked for already.
    pub asked: Vec<&'static str>,
    /// The simple turning cycle in force.
    pub passes: Option<Passes>,
    /// What the first block of a threading cycle said.
    pub thread: ThreadData,
    /// What the first block of a roughing cycle said.
    pub rough: RoughData,
    /// How far a grooving cycle's tool goes back after a peck, mm; NaN where no block said it.
    pub groove_back: f64,
    /// The contour that a cycle named for those that follow.
    pub contour_name: Option<String>,
    /// The next move leads to a contour: a line of it is at rapid.
    pub comes_at_rapid: bool,
    pub spline: SplineData,
    /// The macros that moves call: those of the program the last of them, whose own moves call the one before.
    pub modal_macros: Vec<ModalMacro>,
    /// The cycle that runs after each move (MCALL).
    pub modal_cycle: Option<CalledHole>,
    /// The cycle defined last (CYCL DEF).
    pub defined: Defined,
    /// The labels of the contours that cycles mill (CYCL DEF 14).
    pub contour_labels: Vec<String>,
    /// The places of the pattern defined last (PATTERN DEF).
    pub pattern_places: Vec<PatternPlace>,
    /// Drilling cycles retract to the plane R.
    pub retracts_to_plane: bool,
    /// Block of the O number of the program being run; `None` before the first.
    pub program_start: Option<usize>,
}

/// Whether a program that states no plane is a lathe's, which begins in G18: it names X and Z, and Y nowhere.
fn turns(program: &Program) -> bool {
    let names = |letter| program.words().iter().any(|word| word.letter == letter);
    let states_plane = |word: &Word| matches!(program.code(word), Some(G::Plane(_)));
    names(b'X') && names(b'Z') && !names(b'Y') && !program.words().iter().any(states_plane)
}

impl State {
    /// The modes that the program put away last; which tool is selected and in the spindle no program takes back.
    pub fn restore_saved(&mut self) {
        if let Some((modal, _)) = self.saved.pop() {
            let Modal { tool, spindle_tool, .. } = self.modal;
            self.modal = Modal { tool, spindle_tool, ..modal };
        }
    }

    /// Before the first block.
    pub fn new(program: &Program, options: &Options) -> Self {
        let (dialect, mut store) = (program.dialect(), Store::default());
        for (key, value) in &options.parameters {
            store.set(key.clone(), *value);
        }
        let mut rotary = options.rotary.unwrap_or_else(|| rotary_letters(program));
        let by_c = dialect.rules.corner_letters.and_then(|parameter| options.machine_parameter(parameter));
        if by_c.is_some_and(|value| value != 0.0) {
            rotary.remove(b'C'); // a corner
        }
        let mut modal = options.initial.unwrap_or(dialect.initial);
        if dialect.rules.diameter_is_machine_data && turns(program) {
            modal.plane = Plane::Zx;
        }
        Self {
            modal,
            saved: Vec::new(),
            unit: Unit::new(options.unit_is_known),
            diameter_is_known: options.diameter_is_known || !dialect.rules.diameter_is_machine_data,
            xy_is_stated: false,
            xy_is_milled: false,
            frame: Frame {
                rotary: Rotary::new(rotary),
                ..Frame::new(&options.work_offsets, dialect.tool_offset == ToolOffset::Code)
            },
            position: options.position,
            touched: [f64::NAN; 3],
            contouring: Contouring::default(),
            pole: [0.0; 3],
            polar_said: [f64::NAN; 2],
            polar: false,
            broke: false,
            pole_plane: modal.plane,
            store,
            undefined: Vec::new(),
            other_axes: Vec::new(),
            tape_marks: 0,
            radius_called: None,
            edge: (1, dialect.initial.plane),
            defined_tools: Vec::new(),
            oversize: 0.0,
            hole: None,
            under_cycle: dialect.rules.starts_with,
            switched: false,
            steady_feed: true,
            feed_by_revolution: false,
            corner_feed: 0.0,
            tool_feed: -1.0,
            asked: Vec::new(),
            passes: None,
            thread: ThreadData::NONE,
            rough: RoughData::NONE,
            groove_back: f64::NAN,
            contour_name: None,
            comes_at_rapid: false,
            spline: SplineData::default(),
            modal_macros: Vec::new(),
            modal_cycle: None,
            defined: Defined::default(),
            contour_labels: Vec::new(),
            pattern_places: Vec::new(),
            retracts_to_plane: dialect.rules.retracts_to_plane,
            program_start: None,
        }
    }

    /// For the blocks of the next part: none of them is the program's own O number.
    pub fn going_on(self) -> Self {
        Self { program_start: self.program_start.map(|_| usize::MAX), ..self }
    }
}
