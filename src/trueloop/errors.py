"""The error catalogue: every error a user can cause has a code, the values with units, a place and a hint.

A function that refuses its input raises `TrueloopError`, made by its code: `Code.GEO_NAME.refusal(…)`. The command line
prints it and takes its exit status from the code's area. A test produces every code (`tests/errors/`).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path

Values = Mapping[str, float | str | Sequence[float] | Sequence[str]]
"""The values of an error, by name with the unit as suffix: `{"size_um": 160.2, "limit_um": 150.0}`.

Plain numbers and texts, or lists of them: JSON takes them as they are. x is a radius, a code's names are always the
same (`Code.values`), and every number stands in the message, rounded there.
"""


class Code(StrEnum):
    """The codes, by area, each with its meaning and the names of the values that its errors carry.

    The letters name the area, so that a user sees where to look. A code whose errors have no values in common names
    none: the message alone has them.
    """

    meaning: str
    values: tuple[str, ...]

    def __new__(cls, value: str, meaning: str = "", values: str = "") -> "Code":
        """A code is its text; `meaning` completes "this is about …"; `values`: names with units, apart by blanks."""
        code = str.__new__(cls, value)
        code._value_ = value
        code.meaning = meaning
        code.values = tuple(values.split())
        return code

    def refusal(
        self,
        message: str,
        *,
        hint: str,
        place: "Place | None" = None,
        override: str | None = None,
        values: Values | None = None,
    ) -> "TrueloopError":
        """Returns the error of this code, to be raised. Its value `file` is that of `place`, unless it is given."""
        if "file" in self.values and place is not None and place.file is not None:
            named: Values = {"file": Path(place.file).name, **(values or {})}
        else:
            named = values or {}
        return TrueloopError(self, message, hint=hint, place=place, override=override, values=named)

    # GEO: nominal profile
    GEO_EMPTY = "GEO-EMPTY", "no features"
    GEO_VALUE = "GEO-VALUE", "a coordinate that is not a finite number", "feature"
    GEO_NAME = "GEO-NAME", "a feature's name empty or used twice", "feature"
    GEO_LENGTH = "GEO-LENGTH", "a feature without length", "feature length_mm"
    GEO_ARC = "GEO-ARC", "an arc whose ends do not fit centre and sweep", "feature radius_mm"
    GEO_CURVE = "GEO-CURVE", "a curve that is not smooth, or has no value where it is needed", "feature"
    GEO_CURVE_END = "GEO-CURVE-END", "a curve that does not run through its stated ends", "feature off_mm"
    GEO_CURVE_FIT = "GEO-CURVE-FIT", "points through which no smooth curve keeps their tolerance", "feature off_mm"
    GEO_AXIS = "GEO-AXIS", "the profile goes beyond the spindle axis", "feature x_mm"
    GEO_GAP = "GEO-GAP", "consecutive features do not meet", "gap_mm"
    GEO_ORDER = "GEO-ORDER", "a chain in the order of the other side", "start_x_mm start_z_mm end_x_mm end_z_mm"
    GEO_CROSSING = "GEO-CROSSING", "the chain crosses or touches itself", "features x_mm z_mm"
    GEO_JUNCTION = "GEO-JUNCTION", "a junction by design that the geometry contradicts", "features"
    GEO_NOSE = "GEO-NOSE", "a concave arc not larger than the nose, or no nose radius at all", "nose_radius_mm"
    GEO_NARROW = "GEO-NARROW", "the nose does not fit between features", "features nose_radius_mm x_mm z_mm"
    GEO_SHARP = "GEO-SHARP", "a corner too sharp to offset", "features turn_deg x_mm z_mm"
    GEO_DXF = "GEO-DXF", "a drawing that cannot be read as a profile"
    GEO_DXF_UNIT = "GEO-DXF-UNIT", "a drawing without a length unit", "insunits"
    GEO_DXF_CHOICE = "GEO-DXF-CHOICE", "several chains, a branch or a closed outline"
    GEO_STEP = "GEO-STEP", "a solid whose section is no turned profile"

    # NC: programs
    NC_COMPENSATED = "NC-COMPENSATED", "G41 or G42 where it cannot be followed, or on the wrong side", "compensation"
    NC_BORE = "NC-BORE", "a pass on the other side than is stated: a bore, or an outside"
    NC_NO_CONTOUR = "NC-NO-CONTOUR", "no feed moves that could be a finish pass"
    NC_NO_MATCH = "NC-NO-MATCH", "a feature that no pass cuts whole", "feature"
    NC_AMBIGUOUS = "NC-AMBIGUOUS", "a feature that several passes cut", "feature lines"
    NC_TOOLS = "NC-TOOLS", "a feature that several tools cut, none of them surely last", "feature tools"
    NC_EDGE = "NC-EDGE", "a corner of a groove tool that cannot touch what it cuts", "feature tool"
    NC_NO_TOOL = "NC-NO-TOOL", "a tool of the job that its program does not call", "tool"
    NC_FILE = "NC-FILE", "a program or an offsets file that cannot be read"
    NC_DIALECT = "NC-DIALECT", "a dialect that does not exist, or a program whose dialect is not clear"
    NC_PARAMETER = "NC-PARAMETER", "a parameter without a value, or a value for one that does not exist"
    NC_EXPRESSION = "NC-EXPRESSION", "an expression without a value"
    NC_WORD = "NC-WORD", "text that the dialect does not know"
    NC_CODE = "NC-CODE", "a G or M code that the dialect does not know"
    NC_DUPLICATE = "NC-DUPLICATE", "a word twice in a block, or two codes of one modal group"
    NC_NUMBER = "NC-NUMBER", "a number written in a way that the control does not take"
    NC_MISPLACED = "NC-MISPLACED", "a word or code without effect where it stands"
    NC_ARC = "NC-ARC", "an arc that cannot exist"
    NC_ARC_FIT = "NC-ARC-FIT", "an arc whose end is not on its circle"
    NC_TANGENT = "NC-TANGENT", "a joint of an arc that is neither tangent nor a corner", "turn_deg"
    NC_FEED = "NC-FEED", "a cut without a feed, or a feed that cannot be"
    NC_RAPID = "NC-RAPID", "a rapid move that passes through the part"
    NC_BLEND = "NC-BLEND", "a path mode in which the control may round corners without a bound"
    NC_OPAQUE = "NC-OPAQUE", "a code that is known, whose motion is not part of the path"
    NC_FLOW = "NC-FLOW", "loops, branches or calls that do not fit together"
    NC_UNIT = "NC-UNIT", "a program that does not state its unit of length"
    NC_DIAMETER = "NC-DIAMETER", "whether X is a diameter is left to machine data"
    NC_TOOL = "NC-TOOL", "compensation by a tool whose radius or tip is not known"
    NC_GOUGE = "NC-GOUGE", "a corner or an arc that the compensated tool does not fit into"
    NC_ENTRY = "NC-ENTRY", "compensation that cannot begin or change as programmed"
    NC_LIMIT = "NC-LIMIT", "a bound on size, blocks, depth, moves or decimals"
    NC_EDIT = "NC-EDIT", "a block that cannot be changed as the correction needs"
    NC_OFFSET = "NC-OFFSET", "a contour that cannot be moved by a tool offset or work offset"
    NC_MAP = "NC-MAP", "a block to which a field of displacements cannot be applied"
    NC_FIELD = "NC-FIELD", "a field of displacements that cannot be read, or is not known at a position"

    # TCH: touches
    TCH_FILE = "TCH-FILE", "a file of touches that cannot be read, or has none"
    TCH_COLUMN = "TCH-COLUMN", "a column of touches that is missing, unknown or there twice"
    TCH_NUMBER = "TCH-NUMBER", "a value of a touch that is no finite number"
    TCH_FEATURE = "TCH-FEATURE", "a touch on a feature that the part does not have", "point feature"
    TCH_OFF_PROFILE = (
        "TCH-OFF-PROFILE",
        "a touch whose nominal point is not on its feature, or whose error is not credible",
        "point off_mm limit_mm",
    )
    TCH_UNIT = "TCH-UNIT", "touches in another unit than their columns name"
    TCH_DIAMETER = "TCH-DIAMETER", "diameters among radii, or the reverse", "factor_x factor_z"
    TCH_SIGN = (
        "TCH-SIGN",
        "errors whose sign is reversed: against what was measured, or after the finish cut",
        "ratio correlation",
    )
    TCH_DUPLICATE = "TCH-DUPLICATE", "two touches of one point", "point"
    TCH_ORDER = "TCH-ORDER", "touches that are not in order along the profile", "points along_mm"
    TCH_REFERENCE = "TCH-REFERENCE", "a z reference that is no touch, or that does not face z", "point"
    TCH_PLAN = "TCH-PLAN", "gauging points that cannot be placed"

    # MSR: inspection files of gauges, measuring machines and controls
    MSR_FILE = "MSR-FILE", "an inspection file that cannot be read"
    MSR_COUNTED = "MSR-COUNTED", "an inspection file that counts good and bad instead of sizes", "file"
    MSR_SIZE = "MSR-SIZE", "an inspection file that holds more than is read of one file"
    MSR_FORMAT = "MSR-FORMAT", "an inspection file in no known format", "file"
    MSR_FRAME = "MSR-FRAME", "features of one part in coordinate systems whose relation is not stated", "statement"
    MSR_NUMBER = "MSR-NUMBER", "a value of an inspection file that is no number, or may be two", "text"
    MSR_TIME = "MSR-TIME", "a time of an inspection file that is none, or may be two", "text"
    MSR_EXCHANGED = "MSR-EXCHANGED", "a lower limit above the upper one", "lower upper"
    MSR_UNIT = "MSR-UNIT", "an inspection file whose unit of length is not stated, or stated twice", "file"
    MSR_MEANING = "MSR-MEANING", "an inspection file that does not say what its numbers are", "file"
    MSR_MAPPING = "MSR-MAPPING", "a mapping of an inspection file with a key that is wrong"
    MSR_PART = "MSR-PART", "an inspection of which too little is on the part", "matched values"
    MSR_SCALE = "MSR-SCALE", "an inspection that fits the part when it is multiplied", "factor fitting values"
    MSR_EXCLUDED = "MSR-EXCLUDED", "limits that exclude the nominal value, or every value", "characteristic"
    MSR_PLACES = "MSR-PLACES", "one characteristic with two nominal values or in two places", "characteristic"
    MSR_SERIAL = "MSR-SERIAL", "several parts in one file and none chosen, or one that is not there", "serials"
    MSR_NONE = "MSR-NONE", "inspection files without a reading that says anything of the part's errors"
    MSR_VALUE = "MSR-VALUE", "a value of an inspection file that is missing, there twice or half", "file"
    MSR_COLUMN = "MSR-COLUMN", "a column of gauge readings that is missing, unknown, or there twice"
    MSR_FEATURE = "MSR-FEATURE", "a reading of a feature that the part does not have", "feature"
    MSR_PLACE = "MSR-PLACE", "a reading whose place is missing, or not on its feature", "feature"
    MSR_KIND = "MSR-KIND", "a reading whose quantity its feature does not have", "feature quantity"
    MSR_NOMINAL = "MSR-NOMINAL", "a reading too far from nominal to be of this part", "feature actual nominal"
    MSR_TWICE = "MSR-TWICE", "a radius among diameters, an included angle, or the reverse", "feature factor"
    MSR_UNCERTAINTY = "MSR-UNCERTAINTY", "an uncertainty that no measurement has", "characteristic u_um limit_um"
    MSR_OLD = "MSR-OLD", "readings from before the last correction", "measured_at corrected_at"

    # OFS: tool offsets and the tool tables of controls
    OFS_FILE = "OFS-FILE", "a tool table that cannot be read"
    OFS_FORMAT = "OFS-FORMAT", "a tool table in no known format", "file"
    OFS_NUMBER = "OFS-NUMBER", "a number of a tool table that is none", "text"
    OFS_UNIT = "OFS-UNIT", "a tool table whose unit is not known, or another than stated"
    OFS_TOOL = "OFS-TOOL", "a tool without a number, not in the table, or another than the program's", "tool"
    OFS_ROWS = "OFS-ROWS", "two rows of one tool", "tool lines"
    OFS_NAME = "OFS-NAME", "a tool of another name", "tool expected found"
    OFS_NOSE = "OFS-NOSE", "a nose radius in the table that is not the job's", "tool table_mm job_mm"
    OFS_ROW = "OFS-ROW", "a row, or a whole table, that does not take the number"
    OFS_CHANGED = "OFS-CHANGED", "offsets that have changed since the correction was made", "tool"
    OFS_TWICE = "OFS-TWICE", "an offset that is in the table already", "tool record"
    OFS_NONE = "OFS-NONE", "a correction that changes no tool offset"
    OFS_WORDS = "OFS-WORDS", "a control whose words for a tool offset are not known, or not clear", "control"

    # PRB: probing plans, programs and logs
    PRB_FILE = "PRB-FILE", "a probe file that is missing or wrong"
    PRB_CALIBRATION = "PRB-CALIBRATION", "a probe that is not calibrated, or not credibly"
    PRB_REACH = (
        "PRB-REACH",
        "a point that ball or stem cannot reach without touching something else",
        "point feature obstacle x_mm z_mm clearance_mm margin_mm",
    )
    PRB_BALL = (
        "PRB-BALL",
        "a ball larger than the groove it is to touch in",
        "point feature obstacle ball_diameter_mm overlap_mm",
    )
    PRB_SECOND = (
        "PRB-SECOND",
        "a second, slow touch for a control that cannot be programmed to make one",
        "control feed_mm_per_min",
    )
    PRB_AXIS = (
        "PRB-AXIS",
        "a macro that measures along one axis, and a surface that faces neither",
        "point feature normal",
    )
    PRB_LOG = "PRB-LOG", "a log that cannot be read"
    PRB_OTHER = (
        "PRB-OTHER",
        "touches that belong to no point of the plan: another job's log",
        "touches others x_mm z_mm nearest_mm",
    )
    PRB_MISSING = "PRB-MISSING", "points without a touch", "points"
    PRB_MISSED = "PRB-MISSED", "probing moves that met nothing, logged as touches", "moves missed overtravel_mm point"
    PRB_TWICE = "PRB-TWICE", "several touches at one point", "point lines"
    PRB_TRIALS = (
        "PRB-TRIALS",
        "a log that does not hold every point the same number of times, twice at least",
        "touches points fewest most",
    )
    PRB_ORDER = "PRB-ORDER", "touches in another order than the plan's", "point before"
    PRB_RETRACT = (
        "PRB-RETRACT",
        "touches where the approach began: the probe was triggered, or never switched on",
        "touches retracted stand_off_mm",
    )
    # FIT: error curves
    FIT_POINTS = "FIT-POINTS", "fewer touches than the curve that was asked for needs", "touches"
    FIT_VALUE = "FIT-VALUE", "a touch that is no finite number"
    FIT_ORDER = "FIT-ORDER", "touches of a feature unordered, or two in one place", "points arc_length_mm"
    FIT_OUTSIDE = "FIT-OUTSIDE", "a touch beyond the feature it was given to", "point feature beyond_mm limit_mm"
    FIT_KNOTS = "FIT-KNOTS", "a knot at every r-th touch with r below 2"
    FIT_ANGLE = (
        "FIT-ANGLE",
        "a contact angle outside the fitted range of a nose model",
        "angle_deg lowest_deg highest_deg",
    )
    FIT_CONDITIONS = "FIT-CONDITIONS", "prescribed values or slopes that contradict each other"

    # CMP: compensation and its limits
    CMP_SIZE = "CMP-SIZE", "a correction larger than the limit", "size_um limit_um"
    CMP_SLOPE = "CMP-SLOPE", "a correction steeper than the limit", "slope_um_per_mm limit_um_per_mm"
    CMP_SCATTER = "CMP-SCATTER", "touches that scatter by more than the limit", "scatter_um limit_um"
    CMP_AGE = "CMP-AGE", "measurements older than the limit, or from the future", "age_h"
    CMP_TWICE = "CMP-TWICE", "a program or file that is corrected already", "comment"
    CMP_OTHER_PROGRAM = (
        "CMP-OTHER-PROGRAM",
        "measurements that belong to another program",
        "expected_sha256 found_sha256",
    )
    CMP_ALLOWANCE = "CMP-ALLOWANCE", "a part that measures as if an allowance were still on", "size_um"
    CMP_CUT_WITH = "CMP-CUT-WITH", "it is not stated what cut the measured part", "corrections"
    CMP_RAPID = "CMP-RAPID", "a rapid move that the correction would bring closer to the part", "closer_um"
    CMP_STOCK = "CMP-STOCK", "roughing that stays and would cut into the corrected contour", "below_um"
    CMP_READ_BACK = "CMP-READ-BACK", "a written program that, read again, is not what was intended"

    # TOL: tolerances and characteristics
    TOL_TEXT = "TOL-TEXT", "a tolerance that cannot be read", "tolerance"
    TOL_FIT = "TOL-FIT", "a tolerance class that ISO 286 does not have", "tolerance"
    TOL_SIZE = "TOL-SIZE", "a size that a tolerance class or general tolerance is not for", "tolerance nominal_mm"
    TOL_ZONE = (
        "TOL-ZONE",
        "limits without anything between them, or that the profile itself lies outside of",
        "characteristic",
    )
    TOL_NOMINAL = "TOL-NOMINAL", "a nominal that is not the profile's", "characteristic nominal_mm profile_mm"
    TOL_FEATURE = "TOL-FEATURE", "a characteristic of a feature that the part does not have", "characteristic feature"
    TOL_PLACE = "TOL-PLACE", "a characteristic that its feature cannot have", "characteristic feature"
    TOL_TWICE = "TOL-TWICE", "the same characteristic twice", "characteristic"

    # SRF: surfaces, their deviations and patterns
    SRF_SURFACE = "SRF-SURFACE", "knots, control points and weights that make no patch"
    SRF_DEGENERATE = "SRF-DEGENERATE", "a place without a normal", "x_mm y_mm z_mm"
    SRF_SETUP = (
        "SRF-SETUP",
        "a best fit that moves a part too far or leaves motions out, or a pattern that a motion makes",
        "part setup_mm",
    )
    SRF_GRID = "SRF-GRID", "a point grid that no surface can be fitted to"
    SRF_POINTS = "SRF-POINTS", "too few points measured on a surface", "part"
    SRF_UNIT = "SRF-UNIT", "points in another unit than mm", "part"
    SRF_SIGN = "SRF-SIGN", "points on the wrong side: normals into the material, or the ball's radius left in"
    SRF_OFF = "SRF-OFF", "points too far off the surface", "part limit_mm"
    SRF_OUTSIDE = "SRF-OUTSIDE", "points beyond the edge of the face", "part"
    SRF_DUPLICATE = "SRF-DUPLICATE", "a point measured twice", "part points"
    SRF_HOLES = "SRF-HOLES", "a grid that lacks points", "part missing"
    SRF_BALL = "SRF-BALL", "a ball larger than a hollow, or no ball", "ball_radius_mm"
    SRF_CAD = "SRF-CAD", "a CAD file that cannot be read or written"
    SRF_CAD_KERNEL = "SRF-CAD-KERNEL", "the CAD kernel is not installed"
    SRF_CAD_CHOICE = "SRF-CAD-CHOICE", "several faces, none chosen", "file faces"
    SRF_TRIM = "SRF-TRIM", "a corrected surface that cannot be trimmed as its nominal face was"
    SRF_CUTTER = "SRF-CUTTER", "a cutter that is none", "radius_mm corner_mm"
    SRF_GOUGE = "SRF-GOUGE", "a cutter that would cut into the corrected surface", "depth_um limit_um x_mm y_mm z_mm"
    SRF_TOLERANCE = (
        "SRF-TOLERANCE",
        "a corrected surface that cannot be fitted as closely as wanted",
        "left_um limit_um",
    )
    SRF_PROGRAM = "SRF-PROGRAM", "a program whose moves cannot be corrected for a surface"
    SRF_PATH = "SRF-PATH", "a tool path that cannot be made"
    SRF_FILE = "SRF-FILE", "points that cannot be read"
    SRF_TWICE = "SRF-TWICE", "two parts of one name, or one part twice"
    SRF_BATCH = "SRF-BATCH", "a batch that its workers could not finish"
    SRF_COMPARE = "SRF-COMPARE", "jobs whose parts cannot be set beside each other"
    SRF_PARTS = "SRF-PARTS", "too few parts for a pattern"
    SRF_OUTLIER = "SRF-OUTLIER", "a part unlike the others", "p_value"
    SRF_DRIFT = "SRF-DRIFT", "a pattern that changes from part to part", "p_value"
    SRF_STORED = "SRF-STORED", "parts in the store that are of another surface under the same name", "part"
    SRF_SUPPORT = "SRF-SUPPORT", "a part of the face that measurements do not support, or too much of it"
    SRF_MODEL = "SRF-MODEL", "a model that the points cannot determine, or that none satisfies"

    # MIL: milled parts
    MIL_NOMINAL = "MIL-NOMINAL", "a measured size whose nominal value is not the job's", "feature nominal_mm job_mm"
    MIL_NONE = "MIL-NONE", "a file that measured no feature of the job", "readings features"
    MIL_LARGE = "MIL-LARGE", "a deviation too large to be an error of the cut", "name deviation_um limit_um"
    MIL_ENTRY = "MIL-ENTRY", "a number to enter that is too large", "entry change limit"
    MIL_ENTERED = "MIL-ENTERED", "parts of which it is not stated what had been entered", "measurement file"
    MIL_CONTRADICTED = "MIL-CONTRADICTED", "a part that was not cut with the stated numbers", "part entry off u"
    MIL_DEVICE = "MIL-DEVICE", "a ring gauge of a device that measured nothing", "device devices"
    MIL_RECORD = "MIL-RECORD", "a record that is not of this part's entries", "file"
    MIL_CUT = "MIL-CUT", "a feature that several passes could have cut last", "feature"
    MIL_NOT_CUT = "MIL-NOT-CUT", "a feature that no pass of the program cuts", "feature"
    MIL_SIDE = "MIL-SIDE", "a wall whose tool runs where the material is stated to be", "feature kind"
    MIL_STATED = "MIL-STATED", "a stated value that the program contradicts", "stated program"
    MIL_SET = "MIL-SET", "a work offset that the program sets itself", "work_offset"
    MIL_LEVELS = "MIL-LEVELS", "a face that is cut at several heights", "feature levels_mm"
    MIL_REGISTER = "MIL-REGISTER", "a register of a radius or length that several tools use", "register tools"
    MIL_PROBE = "MIL-PROBE", "a part that a probing program cannot measure as stated"
    MIL_CORNER = "MIL-CORNER", "an inside corner that the tool would not fit into", "tool corner_mm"

    # MCH: machine models
    MCH_NAME = "MCH-NAME", "no axis error of ISO 230-1", "name"
    MCH_STRUCTURE = "MCH-STRUCTURE", "no kinematic chain"
    MCH_AXIS = "MCH-AXIS", "an axis or axis error the machine does not have"
    MCH_BASIS = "MCH-BASIS", "no function of position"
    MCH_SIGNAL = "MCH-SIGNAL", "a temperature or speed the model needs is not given", "signals"
    MCH_HISTORY = "MCH-HISTORY", "the past of a signal that is felt later is not given"
    MCH_LAG = "MCH-LAG", "a time constant that was not found within its bounds", "lag constant_s"
    MCH_DATA = "MCH-DATA", "too few readings, or none that move an axis"
    MCH_COLLINEAR = "MCH-COLLINEAR", "parameters that the readings cannot separate, or hardly", "parameters"
    MCH_FILE = "MCH-FILE", "data that cannot be read"
    MCH_UNIT = "MCH-UNIT", "units unknown, missing or mixed"
    MCH_PROGRAM = "MCH-PROGRAM", "a program that cannot be corrected by a machine model"
    MCH_SHAPE = "MCH-SHAPE", "inspections of different points", "counts"
    MCH_FRAME = "MCH-FRAME", "a work offset or tool whose place in the machine is not given"
    MCH_TRAVEL = "MCH-TRAVEL", "a position the machine cannot reach", "axis travel unit"
    MCH_RANGE = "MCH-RANGE", "a position or temperature outside what the model was found at", "name found known unit"
    MCH_TABLE = "MCH-TABLE", "what a control's table cannot hold", "rows limit axis"
    MCH_MACHINE = "MCH-MACHINE", "a model for another machine", "machine serial expected_serial"
    MCH_OFFERED = "MCH-OFFERED", "a model of a machine that is offered and was not accepted", "sha256"
    MCH_PATTERN = "MCH-PATTERN", "a pattern of plates that is not known to repeat", "plates"
    MCH_RUN = "MCH-RUN", "a run of readings that contradicts the others", "runs"
    MCH_SCATTER = "MCH-SCATTER", "readings that scatter by far less than their stated uncertainty", "scatter"
    MCH_OUTLIER = "MCH-OUTLIER", "a reading far off the model", "run reading off unit"
    # REC: records of corrections
    REC_FILE = "REC-FILE", "a file that is no record of a correction"
    REC_SCHEMA = "REC-SCHEMA", "a record that a later version of trueloop wrote"
    REC_KEY = "REC-KEY", "a key of a record that is missing or has a wrong value"

    # SIM: the simulator
    SIM_FILE = "SIM-FILE", "a machine file that is missing or wrong"
    SIM_ALLOWANCE = "SIM-ALLOWANCE", "nothing left on for the finish cut", "allowance_mm"
    SIM_NOSE = "SIM-NOSE", "a worn nose that is no nose, or another than the job's"
    SIM_TRANSFER = (
        "SIM-TRANSFER",
        "what the finish cut does otherwise, by tables that do not go together",
        "angles errors",
    )
    SIM_MILL = "SIM-MILL", "a surface's job that the virtual mill cannot cut"

    # DIA: causes of errors
    DIA_NONE = "DIA-NONE", "a part or a part type of which the store holds nothing that a diagnosis could use"
    DIA_FEW = "DIA-FEW", "fewer parts or points than a diagnosis needs", "count needed"
    DIA_POINTS = "DIA-POINTS", "points of a feature that do not determine an error asked for", "feature"
    DIA_SIGNAL = "DIA-SIGNAL", "parts of which a temperature that the model needs was not kept", "signal parts"
    DIA_ALIKE = "DIA-ALIKE", "tools, positions or temperatures that are too much alike to tell causes apart"
    DIA_PART = "DIA-PART", "an inspection of another part, or of another machine", "part"
    DIA_MODEL = "DIA-MODEL", "parts cut under another model of the machine than the one given", "part"
    DIA_CLOCK = "DIA-CLOCK", "times of a part that contradict each other", "part"
    DIA_UNSTABLE = "DIA-UNSTABLE", "a fixturing that spreads, drifts or steps", "what size_um limit_um"
    DIA_MOVED = "DIA-MOVED", "a probe or a part that was moved between inspections", "part"
    DIA_GAIN = "DIA-GAIN", "parts on which another share of the correction arrived than was recorded", "gain"
    DIA_STANDARD = "DIA-STANDARD", "a standard part without calibrated values, or not under standard conditions"
    DIA_WORSE = "DIA-WORSE", "a refined model that is no better on parts left out"

    # MON: charts and capability
    MON_NONE = "MON-NONE", "a characteristic of which the store holds no values", "characteristic"
    MON_FEW = "MON-FEW", "too few values for a chart", "count"
    MON_LIMITS = "MON-LIMITS", "limits that say nothing of capability"

    # CTL: controls and what they write
    CTL_LINUXCNC = "CTL-LINUXCNC", "LinuxCNC is missing or does not come up"
    CTL_DIALECT = "CTL-DIALECT", "a program for another control than the one that shall run it", "dialect"
    CTL_PROGRAM = "CTL-PROGRAM", "the control stopped a program with an error", "said block"
    # LNK: links to controls
    LNK_FILE = "LNK-FILE", "settings of links that cannot be read"
    LNK_REACH = "LNK-REACH", "a control that is not reached, or breaks off", "where"
    LNK_NAME = "LNK-NAME", "a program's name that a control has not, or may not have", "name"
    LNK_EXISTS = "LNK-EXISTS", "another program of that name at the control", "name"
    LNK_RUNNING = "LNK-RUNNING", "a program that runs, is loaded, or may run, and would be replaced", "name"
    LNK_CHANGED = "LNK-CHANGED", "a program that somebody changed at the control meanwhile", "name"
    LNK_DIFFERS = "LNK-DIFFERS", "a program that did not come back from the control as it was sent", "name lines"
    LNK_LIBRARY = "LNK-LIBRARY", "a control maker's library that is not there, or is another", "where"
    LNK_LINE = "LNK-LINE", "a serial line that is held, silent, broken, or cannot be opened", "where"
    LNK_CODE = "LNK-CODE", "a character that a line's code does not have, or a byte that is none", "line column"

    # MTC: MTConnect
    MTC_NAME = "MTC-NAME", "a name or axis that a device model cannot have", "name"
    MTC_ADDRESS = "MTC-ADDRESS", "an address at which the adapter cannot listen", "host port"
    MTC_AGENT = "MTC-AGENT", "an agent that does not answer, or not as one", "url"

    # FAC: the factory
    FAC_UNKNOWN = "FAC-UNKNOWN", "an order, part, step, program or run that there is not", "what name"
    FAC_ROLE = "FAC-ROLE", "a request that the role does not allow", "role needed"
    FAC_MACHINE = "FAC-MACHINE", "the key of one machine used for another", "machine key_of"
    FAC_STALE = "FAC-STALE", "something that somebody changed since it was read", "expected found"
    FAC_PLAN = "FAC-PLAN", "an order that cannot be made by its route"
    FAC_ORDERED = "FAC-ORDERED", "a part that has an order already", "serial"
    FAC_RELEASE = "FAC-RELEASE", "a program that is not released", "program"
    FAC_STATE = "FAC-STATE", "a step or part that is too far, or not far enough", "state"
    FAC_CUT = "FAC-CUT", "a step of which nobody knows whether it was made"
    FAC_HELD = "FAC-HELD", "a part that a person holds", "serial"
    FAC_ARM = "FAC-ARM", "an order armed elsewhere than at its machine, or for too many parts", "parts"
    FAC_PROGRAM = "FAC-PROGRAM", "another program than the one accepted", "accepted found"
    FAC_READBACK = "FAC-READBACK", "a control that holds another program than was sent"
    FAC_TOUCHES = "FAC-TOUCHES", "touches that are missing, or of another part, program or stage", "run"
    FAC_CALIBRATION = "FAC-CALIBRATION", "a probe whose calibration is old or not known", "machine limit_s"
    FAC_TEMPERATURE = "FAC-TEMPERATURE", "temperatures that are old or not known", "machine limit_s"
    FAC_CORRECTOR = "FAC-CORRECTOR", "a corrector that is not as planned", "planned found"
    FAC_ALARM = "FAC-ALARM", "an alarm that has to be acknowledged before a finish cut", "alarm"

    # CEL: the cell client beside a control
    CEL_FILE = "CEL-FILE", "settings, key or certificates of a cell that cannot be used"
    CEL_WITNESS = "CEL-WITNESS", "a program that cannot witness its own run"
    CEL_JOURNAL = "CEL-JOURNAL", "a journal that is damaged, in use, or cannot be written"
    CEL_SERVICE = "CEL-SERVICE", "a service that is not reached, or refuses what it is told"
    CEL_OFFER = "CEL-OFFER", "a block that is for another machine, or not the text that it names"

    # SRV: the service
    SRV_TLS = "SRV-TLS", "a service that others could reach without encryption", "host"
    SRV_PACKAGE = "SRV-PACKAGE", "a package that the service needs and that is not installed", "package"
    SRV_ADDRESS = "SRV-ADDRESS", "an address or port that the service or the manual cannot listen at", "host port"
    SRV_SIGN_IN = "SRV-SIGN-IN", "a request of nobody: no session, or one that has ended"
    SRV_LOGIN = "SRV-LOGIN", "a name or password that is wrong, or an account that is disabled"
    SRV_OIDC = "SRV-OIDC", "a sign-in by an identity provider that is not taken"
    SRV_PROVIDER = "SRV-PROVIDER", "an identity provider that is not reached, not safe, or answers wrongly"
    SRV_DELAY = "SRV-DELAY", "too many attempts or connections", "retry_after_s"
    SRV_ROLE = "SRV-ROLE", "an address that the role does not open", "role needed"
    SRV_KEY = "SRV-KEY", "a key that is unknown, ended, expired or for something else"
    SRV_ORIGIN = "SRV-ORIGIN", "a change that another site asked for, or nobody knows which", "origin"
    SRV_HOST = "SRV-HOST", "a host name that is not the service's", "host"
    SRV_REQUEST = "SRV-REQUEST", "a request whose parameters or body do not fit"
    SRV_UNKNOWN = "SRV-UNKNOWN", "an address or a thing that there is not", "name"
    SRV_METHOD = "SRV-METHOD", "a method that an address does not take", "method"
    SRV_LARGE = "SRV-LARGE", "a request that is too large", "limit_bytes"
    SRV_FILE = "SRV-FILE", "a file that cannot be read in the time and the memory that the service gives it", "file"
    SRV_ONCE = "SRV-ONCE", "a POST without the key by which it is done once"
    SRV_REUSED = "SRV-REUSED", "a key of a POST that was used for another, or whose outcome is not known", "key"
    SRV_STALE = "SRV-STALE", "a change of something that somebody changed meanwhile", "expected found"
    SRV_MATCH = "SRV-MATCH", "a change without the ETag of what it changes"
    SRV_CURSOR = "SRV-CURSOR", "a place in a list that the service did not give"
    SRV_ACCOUNT = "SRV-ACCOUNT", "an account that cannot be made, found or changed so", "name"
    SRV_PASSWORD = "SRV-PASSWORD", "a password that is too short, too long or too easily guessed", "length shortest"
    SRV_KEYS = "SRV-KEYS", "a key that cannot be made or is not there"
    SRV_MANUAL = "SRV-MANUAL", "a manual that did not come with the package"
    SRV_INTERNAL = "SRV-INTERNAL", "a fault of the service", "number"

    # RTC: real-time correction. Images
    RTC_MODEL = "RTC-MODEL", "a machine that an image cannot hold: its axes, or their travel", "axes"
    RTC_SIGNAL = "RTC-SIGNAL", "signals that an image cannot hold, or whose range is not known", "signals"
    RTC_LIMIT = "RTC-LIMIT", "a correction beyond what the component would let pass", "largest_um limit_um"
    RTC_IMAGE = "RTC-IMAGE", "a file that is no image", "refusal"
    # Real-time correction: tables by program line
    RTC_LINE = "RTC-LINE", "a line of a program that does not say where it is in the cut", "line times"
    RTC_PATH_MODE = "RTC-PATH-MODE", "a path mode by which the control joins blocks"
    RTC_TABLE = "RTC-TABLE", "a correction that no table can hold"
    # Real-time correction: the component and its lines of HAL
    RTC_BUILD = "RTC-BUILD", "the component cannot be compiled or installed"
    RTC_HAL = "RTC-HAL", "a configuration of LinuxCNC that the corrector cannot be put into"
    # Real-time correction: signals, watching
    RTC_SOURCE = "RTC-SOURCE", "a source of signals that cannot be read"
    RTC_CONNECTION = "RTC-CONNECTION", "a running LinuxCNC that cannot be reached"
    RTC_SAMPLES = "RTC-SAMPLES", "samples of a run that cannot be judged"

    # JOB: job files
    JOB_MISSING = "JOB-MISSING", "a job, or a file that it names, that is not there"
    JOB_SYNTAX = "JOB-SYNTAX", "a job that is no TOML"
    JOB_EXISTS = "JOB-EXISTS", "a new job where there is one already", "file"
    JOB_TOOLS = "JOB-TOOLS", "a job of several tools where one is wanted", "tools"
    JOB_SETUPS = "JOB-SETUPS", "a job of several set-ups where one is wanted", "setups"
    JOB_KEY = "JOB-KEY", "a key of a job that is unknown, missing, or has a value that it cannot have", "key"

    # SET: set-ups of one part
    SET_DATUM = "SET-DATUM", "a set-up that does not say where its program's zero is on the part", "setup"
    SET_MIRROR = "SET-MIRROR", "a program that fits the part with its Z the other way round", "setup"
    SET_CUTS = "SET-CUTS", "a set-up whose program cuts nothing of the part", "setup"
    SET_FEATURE = "SET-FEATURE", "a feature that is cut in several set-ups", "feature setups"
    SET_EDGE = "SET-EDGE", "an edge of two set-ups that its number alone names", "setups tool"
    SET_OFFSET = "SET-OFFSET", "a correction by an offset that set-ups share, or whose sign is not known", "setup tool"

    # STO: the store of parts, tools, inspections and corrections
    STO_FILE = "STO-FILE", "a store that is missing, or a file that is no store"
    STO_SCHEMA = "STO-SCHEMA", "a store or an export that another version of trueloop wrote"
    STO_BUSY = "STO-BUSY", "a store that another program keeps locked"
    STO_WRITE = "STO-WRITE", "a store that cannot be written: read-only, or no room left"
    STO_TEXT = "STO-TEXT", "a text or number that the database cannot keep"
    STO_DIFFERS = "STO-DIFFERS", "a value that is stored already, with another content"
    STO_PROGRAM = "STO-PROGRAM", "a cut whose program is not of the correction that it names", "serial correction"
    STO_STAGE = "STO-STAGE", "an inspection of another stage of the part, or a part that had come further", "serial"
    STO_LINK = "STO-LINK", "an inspection for which no correction of its part is stored", "serial"
    STO_CLOCK = "STO-CLOCK", "times that go back: an inspection before the cut that it shows", "earlier later"
    STO_PATTERN = "STO-PATTERN", "points that are not those of the part's other inspection", "serial points"
    STO_UNIT = "STO-UNIT", "errors of another size than the part's other inspection has", "size_um other_um"
    STO_EDGE = "STO-EDGE", "a cut of an edge that is not stated", "serial"
    STO_ORDER = "STO-ORDER", "parts of an edge of which the order is in doubt", "serials"
    STO_OPEN = "STO-OPEN", "corrections of which no finish inspection was kept", "serials"
    STO_UNKNOWN = "STO-UNKNOWN", "something that is not in the store"
    STO_EXISTS = "STO-EXISTS", "a new store where there is one, or another file, already", "store"
    STO_IMPORT = "STO-IMPORT", "a file that no store can take in"
    STO_EXPORT = "STO-EXPORT", "an export of a store that is not whole, or was changed", "line"
    STO_PART = "STO-PART", "an inspection whose part is not stated", "file"
    STO_SEVERAL = "STO-SEVERAL", "a name that several parts in the store have", "name"
    STO_DAMAGED = "STO-DAMAGED", "a row of a store that is not what was kept, or cannot be read", "row"
    STO_LOST = "STO-LOST", "a row that names what is not in the store, or is superseded", "row named"
    STO_OTHER_PART = "STO-OTHER-PART", "a file that is stored already, as an inspection of another part", "file"
    STO_DRIVER = "STO-DRIVER", "a store in PostgreSQL without the package that connects to it"

    # LAB: labels of parts and programs
    LAB_FORM = "LAB-FORM", "text that is not the label of a part or a program", "label character"
    LAB_LINK = "LAB-LINK", "a label that contradicts what it is linked with", "label in_label in_link"

    # EDG: cutting edges and their events
    EDG_UNKNOWN = "EDG-UNKNOWN", "a tool or an edge that no event in the store names", "tool known"
    EDG_OTHER = "EDG-OTHER", "a job that states another edge than the one that is mounted", "stated mounted"
    EDG_ENDED = "EDG-ENDED", "a cut by an edge that was turned away or removed before", "edge ended_at"
    EDG_POCKET = "EDG-POCKET", "a pocket that holds another tool, or one number in several machines", "tool held"
    EDG_CORNER = "EDG-CORNER", "a corner that cuts already, or did before", "corner"
    EDG_VALUE = "EDG-VALUE", "a mounting without nose radius, or a value that no edge can have", "name"
    EDG_TIME = "EDG-TIME", "an event later than the clock", "at now"
    EDG_PAST = "EDG-PAST", "an event earlier than facts that are kept of the same tool", "at kept_at"
    EDG_SETTING = "EDG-SETTING", "touches that are older than the setting of the tool", "set_at measured_at"

    # MEM: what is remembered
    MEM_UNSEEN = "MEM-UNSEEN", "a contact angle far from all that were seen", "angle_deg nearest_deg most_deg"
    MEM_SETTING = "MEM-SETTING", "no touch after a new setting of the tool", "setting"
    MEM_TYPE = "MEM-TYPE", "no touch of a part type that the edge has never cut", "part_type"
    MEM_GAIN = "MEM-GAIN", "corrections that the machine hardly carries out, or the wrong way", "gain"
    MEM_PART = "MEM-PART", "a part that the edge has not cut", "last_part"
    MEM_ALARM = "MEM-ALARM", "a finished part that is not as predicted", "serial probability"

    # SER: series of parts
    SER_PART = "SER-PART", "a part that enters a series without a name or a serial number", "part"
    SER_NONE = "SER-NONE", "parts without a size that a series could follow"
    SER_NOMINAL = "SER-NOMINAL", "values that are exactly nominal, as if filled in and not measured", "part"
    SER_UNIT = "SER-UNIT", "a part in another unit than those before it", "part characteristic value_mm"
    SER_AGAIN = "SER-AGAIN", "a part of a series that was inspected before", "part"
    SER_ORDER = "SER-ORDER", "parts whose order is in doubt, or a clock that went back"
    SER_REVISION = "SER-REVISION", "a characteristic whose nominal or limits changed", "characteristic"
    SER_UNKNOWN = "SER-UNKNOWN", "a part type or a characteristic that no series is of", "characteristic"
    SER_FEW = "SER-FEW", "a series of fewer than three parts", "characteristic"
    SER_TOOL = "SER-TOOL", "series that say nothing of a job's tool"
    SER_CORRECTED = "SER-CORRECTED", "parts of a series that corrections of their program cut", "part"
    SER_PROPOSAL = "SER-PROPOSAL", "a proposal that the store does not hold", "proposal"
    SER_DECIDED = "SER-DECIDED", "a proposal that was decided already", "proposal"
    SER_SUPERSEDED = "SER-SUPERSEDED", "a proposal of a series that has changed since", "proposal"
    SER_LARGE = "SER-LARGE", "a proposal beyond the limit", "characteristic size_um limit_um"
    SER_OLD = "SER-OLD", "a proposal made too long ago, or in the future", "proposal age_h"
    SER_ALARM = "SER-ALARM", "a proposal of a series with an open alarm", "characteristic"

    # VAL: stored values
    VAL_FORM = "VAL-FORM", "a stored value that cannot be read back"

    # OUT: writing
    OUT_FOLDER = "OUT-FOLDER", "a folder or file that cannot be written"
    OUT_INPUT = "OUT-INPUT", "an output that would overwrite an input", "file input"
    OUT_TWICE = "OUT-TWICE", "two results of one name", "file"
    OUT_BROWSER = "OUT-BROWSER", "a PDF that no browser is there to print", "browser"
    OUT_PDF = "OUT-PDF", "a PDF that the browser did not print", "browser"
    OUT_FRAME = "OUT-FRAME", "a table for a notebook that cannot be made: neither pandas nor polars is installed"
    OUT_FIGURE = "OUT-FIGURE", "a figure that cannot be shown: Plotly is not installed"


@dataclass(frozen=True)
class Place:
    """Where in a user's file: line and column count from 1; None where it does not apply."""

    file: str | None = None
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        parts = [part for part in (self.file, self.line, self.column) if part is not None]
        return ":".join(str(part) for part in parts)


def _finite(value: object) -> object:
    """JSON has no NaN and no infinity: null."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


class TrueloopError(Exception):
    """A refusal, written for the person who must mend its cause.

    `message` says what was wrong with the values and units; `hint` how to mend it; `override` names the option that
    lets the user go on all the same, where there is one. `values` are those that the code names.

    >>> try:
    ...     trueloop.read_touches("touch.csv")
    ... except trueloop.TrueloopError as error:
    ...     error.code.value, error.place.file
    ('TCH-FILE', 'touch.csv')
    """

    def __init__(
        self,
        code: Code,
        message: str,
        *,
        hint: str,
        place: Place | None = None,
        override: str | None = None,
        values: Values | None = None,
    ) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.hint = hint
        self.place = place or Place()
        self.override = override
        self.values = dict(values or {})

    def __reduce__(self) -> tuple[object, ...]:
        """How it travels from one process to another: Python would forget the arguments given by name."""
        return _remade, (self.code, self.message, self.hint, self.place, self.override, self.values)

    @property
    def json_values(self) -> dict[str, object]:
        """Returns the values with null for NaN and infinity, which JSON does not have."""
        return {name: _finite(value) for name, value in self.values.items()}

    def in_file(self, file: str, line: int | None = None) -> "TrueloopError":
        """Returns the error with the file named: numerics know nothing of files, their callers do."""
        place = replace(self.place, file=self.place.file or file, line=self.place.line or line)
        return _remade(self.code, self.message, self.hint, place, self.override, self.values)

    def __str__(self) -> str:
        where = f"{self.place}: " if str(self.place) else ""
        override = f" (override: {self.override})" if self.override else ""
        return _shown(f"{where}{self.code}: {self.message}\n  hint: {self.hint}{override}")


@contextmanager
def in_file(file: str | Path | None, line: int | None = None) -> Iterator[None]:
    """Refusals from inside that name no file get this one, and the line; without a file they stay as they are."""
    try:
        yield
    except TrueloopError as error:
        if file is None or error.place.file is not None:
            raise
        raise error.in_file(str(file), line) from error


def _remade(code: Code, message: str, hint: str, place: Place, override: str | None, values: Values) -> TrueloopError:
    return TrueloopError(code, message, hint=hint, place=place, override=override, values=values)


class Severity(StrEnum):
    """How much a finding matters."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


class Unseen(StrEnum):
    """Part of a program that a finding says is missing from its path: nothing that moves, the work of a macro or a
    cycle, moves of a cycle in force or defined before, or touches and what they set.
    """

    NOTHING = ""
    BLOCK = "block"
    MOVES = "moves"
    TOUCHES = "touches"


@dataclass(frozen=True)
class Finding:
    """Something noticed that does not stop the work: same code, place, hint and values as an error would have."""

    severity: Severity
    code: Code
    message: str
    hint: str
    place: Place = Place()
    values: Values = field(default_factory=dict, hash=False)
    unseen: Unseen = Unseen.NOTHING

    def as_error(self) -> TrueloopError:
        """The refusal of what it is about, where that does stop the work."""
        return TrueloopError(self.code, self.message, hint=self.hint, place=self.place, values=self.values)

    def in_file(self, file: str | None) -> "Finding":
        """Returns the place with the file named, where it names none."""
        return replace(self, place=replace(self.place, file=self.place.file or file))

    def __str__(self) -> str:
        where = f"{self.place}: " if str(self.place) else ""
        return _shown(f"{where}{self.severity} {self.code}: {self.message}\n  hint: {self.hint}")


def _shown(text: str) -> str:
    """Fit for a terminal, which control characters of a program or of a file's name would command."""
    return "".join(letter if letter.isprintable() or letter == "\n" else "?" for letter in text)
