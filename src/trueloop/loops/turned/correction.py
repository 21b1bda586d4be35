"""One process-intermittent correction and its inputs.

The prediction of a part by memory before its finish cut, kept beside the correction so that it can be judged
afterwards.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, by_content
from trueloop.domain.characteristic import Characteristic, Judged
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Ran
from trueloop.domain.option import MemoryUse
from trueloop.domain.part import PartType
from trueloop.domain.proposal import HeldTool
from trueloop.domain.record import GIVEN, CutWith, Record, sha256_of
from trueloop.domain.tool import Edge, Machine
from trueloop.geometry.profile import Profile
from trueloop.geometry.setup_frame import SetupFrame
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.error_sources import FeatureSources
from trueloop.loops.turned.in_force import NOTHING, InForce
from trueloop.loops.turned.part_on_machine import PartOnMachine, Zero
from trueloop.memory.edge.learnt import IN_FULL, MemoryOptions
from trueloop.memory.made_part import Expected, MadePart
from trueloop.nc.match.cutters import CuttingEdge
from trueloop.nc.program.program import Program
from trueloop.statistics import rms
from trueloop.turned.compensation.decide import Decision
from trueloop.turned.compensation.displaced import CentrePiece
from trueloop.turned.compensation.shift import Shift, unasked_u_mm
from trueloop.turned.compensation.targets import CorrectionTable, Prediction
from trueloop.turned.error_curve.curve import Budget
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.fit.nose_fit import NoseModel
from trueloop.turned.options import Options
from trueloop.turned.program.by_tool import ByTool
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.wording import wording


@by_content
@dataclass(frozen=True)
class FromMemory:
    """The prediction of one part by earlier parts of an edge, and its use.

    `edge` in words. `applied`: the correction of the features `features`, by index, is by memory and today's touches
    `points`; else it is by these touches alone. `keep` are the touches, by name, that are enough for the next part
    and for judging it. `expected` is the prediction, at its contact angles; None: none was made. `alarms` say how
    today's touches contradict earlier parts; then these are not used.
    """

    edge: str
    use: MemoryUse
    applied: bool
    features: tuple[int, ...] = ()
    points: tuple[str, ...] = ()
    keep: tuple[str, ...] = ()
    expected: Expected | None = None
    alarms: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def taken_off_mm(self, feature_index: NDArray[np.intp], arc_length_mm: Array) -> Array:
        """Returns the share from memory of what a correction of weight 1 takes off at places, (n,): without a touch of
        today.

        Positive where material is taken off; zero where the correction is not by memory.
        """
        taken, known = np.zeros(len(feature_index)), self.expected
        if not self.applied or known is None:
            return taken
        for index in self.features:
            rows = feature_index == index
            taken[rows] = known.along(known.weight * known.memory_mm, index, arc_length_mm[rows])
        return taken

    def share(self, feature: int) -> float:
        """Returns the share of one feature's correction that is from memory, from 0 to 1: its RMS over both RMS."""
        if not self.applied or self.expected is None or feature not in self.features:
            return 0.0
        known, rows = self.expected, self.expected.rows(feature)
        memory, whole = known.memory_mm[rows], known.mean_mm[rows]
        from_memory, from_touches = rms(memory), rms(whole - memory)
        return from_memory / (from_memory + from_touches) if from_memory + from_touches > 0.0 else 0.0

    def words(self, profile: Profile) -> tuple[str, ...]:
        """Describes the shares of memory and of today's touches, how many of these suffice, and alarms."""
        if self.expected is None and not self.edge:
            return self.notes
        if self.expected is None:
            return tuple(wording("Memory of edge {edge}: {note}", edge=self.edge, note=note) for note in self.notes)
        head = wording("Memory of edge {edge}, inspected parts: {n}.", edge=self.edge, n=self.expected.parts)
        return (head, *self._shares(profile), *self._alarmed(), *self._enough(), *self.notes)

    def _shares(self, profile: Profile) -> tuple[str, ...]:
        if not self.applied:
            return ()
        touches = len(self.points)
        return tuple(
            wording(
                "{feature}: {memory:.0f} % of the correction is from memory, {touched:.0f} % from {n} touches.",
                feature=profile.names[i],
                memory=100.0 * (share := self.share(i)),
                touched=100.0 * (1.0 - share),
                n=touches,
            )
            for i in self.features
        )

    def _alarmed(self) -> tuple[str, ...]:
        if not self.alarms:
            if self.applied:
                return ()
            return (wording("The correction is by today's touches alone; memory gives its band."),)
        own = wording(
            "Today's touches contradict earlier parts: the correction is by today's {n} touches alone. Look "
            "what happened, and touch all points before cutting.",
            n=len(self.points),
        )
        return (own, *self.alarms)

    def _enough(self) -> tuple[str, ...]:
        if self.alarms or self.expected is None or not self.points:
            return ()
        enough = wording(
            "Touches that would have been enough: {enough} of {n}.",
            enough=self.expected.enough_touches,
            n=len(self.points),
        )
        if len(self.keep) == len(self.points):
            return (enough,)
        kept = wording("To touch on the next part, as a check too: {points}.", points=", ".join(self.keep))
        return (enough, kept)


def edge_words(edge: Edge | None) -> str:
    """Names an edge by its tool, insert and corner."""
    return "" if edge is None else " ".join(text for text in edge.identity if text)


@dataclass(frozen=True)
class Inputs:
    """One job as values: shapes, programs and touches, and who corrects when.

    `machine_tool` is the one that cuts, `edge` the finishing tool's, mounted at `edge_set_at`: None where not stated.
    `touches` are part errors; `inspections` hold them as they were reported: none where no device did. `inputs_sha256`
    names what they were read from; `file` is the job's, which states the rest; None: no file does. `held` is the
    finishing tool as the control knows it. `characteristics` are to be judged; `measured_allowance_mm` is
    what the touches were taken over. `history` are earlier parts of the edge in cutting order, and `memory` says how
    they take part. `called` is the edge whose part this is of a job of several; None: the program's one tool. `setup`
    is the frame in which all of this is, where the part has several set-ups; None: the part's. `no_offset`: why no
    offset of the tool may be entered at the control; "": one may. `in_force` is what cut a finished part that was
    measured. `zero` are the machine's errors where z counts from, of a part of which another edge cuts that place.
    """

    part: PartType
    profile: Profile
    nose_radius_mm: float
    program: Program
    touches: ErrorVectors
    options: Options
    made_at: datetime
    made_by: str = ""
    semifinish: Program | None = None
    allowance_mm: float = 0.0
    parameters: Mapping[str, float] = field(default_factory=dict)
    execute_deleted_blocks: bool = False
    lines: tuple[int, int] | None = None
    inspections: tuple[Inspection, ...] = ()
    program_sha256: str | None = None
    finish_touches: ErrorVectors | None = None
    nose: NoseModel | None = None
    machine: PartOnMachine | None = None
    machine_tool: Machine | None = None
    edge: Edge | None = None
    edge_set_at: datetime | None = None
    held: HeldTool = field(default_factory=lambda: HeldTool(edge=0))
    inputs_sha256: Mapping[str, str] = field(default_factory=dict)
    file: str | None = None
    characteristics: tuple[Characteristic, ...] = ()
    measured_allowance_mm: float = 0.0
    notes: tuple[str, ...] = ()
    history: tuple[MadePart, ...] = ()
    memory: MemoryOptions = IN_FULL
    called: CuttingEdge | None = None
    setup: SetupFrame | None = None
    no_offset: str = ""
    in_force: InForce = NOTHING
    zero: Zero | None = None

    @property
    def part_zero_z_mm(self) -> float:
        """Returns the z from which lengths count: the part's zero."""
        return 0.0 if self.setup is None else self.setup.z_mm(0.0)

    @property
    def measured_finished(self) -> bool:
        """Returns whether the touches are of the finished part: no semi-finish cut, and nothing left on."""
        return self.semifinish is None and self.allowance_mm == 0.0 and self.measured_allowance_mm == 0.0

    @property
    def run(self) -> Run:
        """Returns the way in which the programs are run."""
        called = None if self.called is None else self.called.called
        return Run(
            parameters=self.parameters,
            execute_deleted_blocks=self.execute_deleted_blocks,
            lines=self.lines,
            called=called,
            number=self.options.tool,
            tip=self.options.tip,
        )

    @property
    def measured_at(self) -> datetime | None:
        """Returns the time of the oldest of the touches and readings, where that is known of all."""
        times = [inspection.measured_at for inspection in self.inspections]
        known = [time for time in times if time is not None]
        return min(known) if known and len(known) == len(times) else None


@by_content
@dataclass(frozen=True)
class Composed:
    """The machine's share of a correction, at the touches along their normals, (n,), mm.

    `reported_mm` is the control's report of the touches, before E(T_probing) was added; `cut_in_mm` is E of the cut
    that made the touched surface; `comp_mtg_mm` and `comp_proc_mm` are the components of the correction,
    what was in force before among them: together they are what the program moves the given contour by.
    """

    reported_mm: Array
    cut_in_mm: Array
    comp_mtg_mm: Array
    comp_proc_mm: Array


@by_content
@dataclass(frozen=True)
class Correction:
    """The correction with its results and inputs: the source of the report and of the files.

    `commanded` and `corrected` are the contours of the finish program and of the corrected one, with the nose-centre
    paths that cut them; `by_offset` says for which features a constant offset takes the place of their error curve,
    `unasked` what their slopes would ask for besides if the nose made the errors. `offsets_program` is None where only
    the contour can be corrected; the notes say why. Where the correction is an offset and there is no such variant, the
    program is run as given, and `wear`, which is known in every case, is entered at the control. `by_tool` is None
    where no offset can carry the correction: a machine model takes part, or none may be entered. `source_name` is the
    file name of the given program; `characteristics` are those that the inputs ask for, judged. `memory` is what
    earlier parts of the edge said; None: there are none, or they were not to be used. `in_force` is by feature what the
    correction in force moved the contour by; this one is the whole. Empty: none was. `joint_name`: the file name of
    the program that carries the corrections of several edges; then `corrected_program` is that one. "": the program has
    one edge. `sources` shares out the errors of every feature, in the profile's order.
    """

    part: str
    profile: Profile
    nose_radius_mm: float
    touches: ErrorVectors
    options: Options
    model: ProfileErrorModel
    decision: Decision
    by_offset: tuple[bool, ...]
    unasked: tuple[Shift, ...]
    commanded: tuple[CentrePiece, ...]
    corrected: tuple[CentrePiece, ...]
    prediction: Prediction
    source_program: bytes
    corrected_program: bytes
    offsets_program: bytes | None
    dialect: str
    source_name: str
    wear: WearOffset
    table: CorrectionTable
    record: Record
    notes: tuple[str, ...]
    composed: Composed | None = None
    characteristics: tuple[Judged, ...] = ()
    by_tool: ByTool | None = None
    memory: FromMemory | None = None
    in_force: tuple[Shift, ...] = ()
    joint_name: str = ""
    sources: tuple[FeatureSources, ...] = ()

    def __repr__(self) -> str:
        """Returns one line: the arrays of a correction fill screens."""
        touches, features = len(self.touches.error_mm), len(self.profile.features)
        return f"<correction of {self.part!r}: {touches} measured places, {features} features, run {self.name_to_run}>"

    @property
    def left_by_offset_mm(self) -> Array:
        """Returns the expected error at the touches with the tool offset alone, (n,), as `prediction.after_mm`."""
        vectors, expected_mm = self.model.vectors, self.model.as_told(self.model.vectors.error_mm)
        machine_mm = -self.composed.comp_mtg_mm if self.composed is not None else 0.0
        left_mm = expected_mm + machine_mm + vectors.outward_normal @ np.array(self.decision.offset_mm)
        for index in range(len(self.profile.features)):
            rows = vectors.of_feature(index)
            left_mm[rows] -= self.given_up_mm(index, vectors.arc_length_mm[rows])
        return np.asarray(left_mm)

    @property
    def cut_with(self) -> CutWith:
        """Returns what cut the part that was measured: a corrected program, an offset, or neither."""
        return self.record.cut_with or GIVEN

    def in_force_mm(self, index: int, arc_length_mm: Array) -> Array:
        """Returns the displacement of feature `index` along its normal by a correction in force, (n,)."""
        moved = self.profile.features[index].outward_normal(arc_length_mm) @ np.array(self.cut_with.offset_mm)
        return np.asarray(moved + (self.in_force[index].value_mm(arc_length_mm) if self.in_force else 0.0))

    def given_up_mm(self, index: int, arc_length_mm: Array) -> Array:
        """Returns the part of that which an offset in its place gives up, (n,)."""
        normal = self.profile.features[index].outward_normal(arc_length_mm)
        return np.asarray(self.in_force_mm(index, arc_length_mm) - normal @ np.array(self.decision.in_force_mm))

    @property
    def commanded_mm(self) -> Array:
        """Returns the part of the errors at the touches that the program that cut them commanded, (n,)."""
        cut_in_mm = self.composed.cut_in_mm if self.composed is not None else 0.0
        return np.asarray(self.touches.error_mm - cut_in_mm - self.model.vectors.error_mm)

    @property
    def programs_sha256(self) -> Mapping[Ran, str]:
        """Hashes of the programs that can be run, by what they are; the given one with `wear` entered has its own."""
        given = self.corrected_program if self.joint_name else self.source_program
        programs = {
            Ran.CORRECTED: self.corrected_program,
            Ran.OFFSETS: self.offsets_program,
            Ran.AS_PROGRAMMED: self.source_program,
            Ran.WEAR: given,
        }
        return {ran: sha256_of(content) for ran, content in programs.items() if content is not None}

    @property
    def recommended(self) -> Ran:
        """Returns the recommended way to carry it out, to which its prediction applies."""
        if not self.decision.by_offset:
            return Ran.CORRECTED
        return Ran.WEAR if self.runs_as_given else Ran.OFFSETS

    @property
    def ending(self) -> str:
        """Returns the ending of the programs' file names."""
        name, _, ending = self.source_name.rpartition(".")
        return f".{ending}" if name and ending else ""

    @property
    def runs_as_given(self) -> bool:
        """Returns whether the given program is run, with `wear` entered at the control."""
        return self.decision.by_offset and self.offsets_program is None

    @property
    def corrected_name(self) -> str:
        """Returns the file name of the corrected program."""
        return f"corrected{self.ending}"

    @property
    def offsets_name(self) -> str:
        """Returns the file name of the variant that changes tool offsets alone."""
        return f"offsets{self.ending}"

    def next_cut(self, index: int, arc_length_mm: Array) -> Budget:
        """Returns the uncertainty of the next cut's error about the curve of feature `index`."""
        unasked = unasked_u_mm(self.unasked[index], arc_length_mm)
        return self.model.curves[index].budget(arc_length_mm).with_more(unasked)

    @property
    def name_to_run(self) -> str:
        """Returns the program to finish with: the tool-offset variant where an offset takes the correction."""
        if self.joint_name or self.runs_as_given:
            return self.joint_name or self.source_name
        return self.offsets_name if self.decision.by_offset else self.corrected_name
