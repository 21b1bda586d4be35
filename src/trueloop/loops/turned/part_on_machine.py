"""A turned part as it stands in a machine whose errors are known, and COMP_MTG and COMP_PROC as one correction.

The tool stands at commanded + E. What a program says at position P is placed at P + zero of the program in the machine;
the axes stand there less the tool's own vector. COMP_MTG = −E is added to commands; what the control reports of a touch
is corrected by COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG(T_probing, COORDS_CONTROLLER) [6876 §3.3].

P_commanded = P_nominal + COMP_MTG(T_cutting, P) + COMP_PROC(s). COMP_MTG is taken where COMP_PROC sends the tool:
P + COMP_PROC + COMP_MTG(P + COMP_PROC), so that what remains of a known E is its change over the correction's size.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.domain.option import Limits
from trueloop.domain.tool import Machine
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.commanded import Commanded
from trueloop.loops.turned.deviations import SAMPLES
from trueloop.machine.correct import Setup, state_at
from trueloop.machine.model.chain import Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals, means
from trueloop.machine.model.validity import check_state
from trueloop.nc.program.along import points_along
from trueloop.turned.compensation.displaced import CentrePiece, Displacement, magnitude
from trueloop.turned.compensation.limits import check_along, cut_mm
from trueloop.turned.compensation.shift import ZERO, Shift, sampled, weighted_sum
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen

PLANE = (0, 2)
"""The indices of X, Y, Z in a lathe's plane."""
SAME_MM = 1e-9
ALONG_MOVE = 33


@by_content
@dataclass(frozen=True)
class PartOnMachine:
    """A machine model, and how one part is cut and touched there.

    `work_zero_mm`: machine coordinates (x as a radius, y, z) of the program's zero for a tool of no length, with all
    that is in force in the finish pass (work offset, G52, G92); `tool_mm`, `probe_mm`: from the frame of the last axis
    to the programmed point of the tool, to the ball's centre. Signals of the finish cut, of the semi-finish cut and
    while probing. `touched_on`: "machine", whose touches carry its error at `probing`, or "cmm". `semifinish_cut`:
    "uncompensated", then the touched surface carries
    E(semifinish), or "compensated", by the control or by a program that the job does not name. `ball_radius_mm` of the
    probe. Axes and signals in `extrapolate` may leave the range of the model's data. `file` is the one that places the
    part in the machine; None: none does.
    """

    model: MachineModel
    sha256: str
    work_zero_mm: Vector
    tool_mm: Vector
    probe_mm: Vector
    cutting: Signals
    semifinish: Signals
    probing: Signals
    touched_on: str
    semifinish_cut: str
    ball_radius_mm: float = 0.0
    extrapolate: Collection[str] = ()
    file: str | None = None

    @property
    def machine(self) -> Machine:
        """Returns which machine it is."""
        return Machine(self.model.machine.name, self.model.machine.serial)

    @property
    def mark(self) -> str:
        """Returns the mark of the machine in a corrected program."""
        return f"composed of COMP_MTG by model {self.sha256[:16]} and COMP_PROC"

    def as_record(self) -> dict[str, object]:
        """Returns the data by which a record knows it."""
        signals = {"cutting": self.cutting, "semifinish": self.semifinish, "probing": self.probing}
        return {
            "model": self.sha256,
            "machine": self.model.machine.name,
            "serial": self.model.machine.serial,
            **{name: means(of) for name, of in signals.items()},
            "work_zero_mm": list(self.work_zero_mm),
            "tool_mm": list(self.tool_mm),
            "probe_mm": list(self.probe_mm),
            "ball_radius_mm": self.ball_radius_mm,
            "touched_on": self.touched_on,
            "semifinish_cut": self.semifinish_cut,
        }


@by_content
@dataclass(frozen=True)
class Standing:
    """A tool, or the probe, in the machine at some temperatures."""

    part: PartOnMachine
    signals: Signals
    tool_mm: Vector

    def state(self, at_mm: Array, travel: Array) -> State:
        """Axes with the tool at positions (n, 2), going `travel` (n, 2) or (2,). Raises MCH-TRAVEL and MCH-RANGE."""
        model, count = self.part.model, len(at_mm)
        points, ways = np.zeros((count, 3)), np.zeros((count, 3))
        points[:, PLANE], ways[:, PLANE] = at_mm, travel
        setup = Setup({1: self.part.work_zero_mm}, {-1: self.tool_mm}, self.signals)
        one = np.ones(count, dtype=np.intp)
        state = state_at(model, setup, points, one, -one, ways)
        try:
            check_state(model, state, self.part.extrapolate)
        except TrueloopError as refused:
            override = None if refused.override is None else "machine.extrapolate in the job"
            raise refused.code.refusal(
                refused.message, hint=refused.hint, override=override, values=refused.values
            ) from refused
        return state

    def error_mm(self, at_mm: Array, travel: Array) -> Array:
        """Returns E, (n, 2): the tool's position less the commanded one."""
        with in_file(self.part.file):
            return np.asarray(self.part.model.error_mm(self.state(at_mm, travel))[:, PLANE])

    def sensitivities(self, at_mm: Array, travel: Array, normal: Array) -> Array:
        """Returns DE along normals (n, 2) by every coefficient of the model, (n, coefficients)."""
        with in_file(self.part.file):
            rows = self.part.model.sensitivities(self.state(at_mm, travel))[:, PLANE, :]
        return np.asarray(np.einsum("ni,nik->nk", normal, rows))


@dataclass(frozen=True)
class InMachine:
    """A job's finish pass in the machine: tools of both cuts, the probe; `travel` (2,): sense of x, z, 0: not known."""

    finishing: Standing
    semifinishing: Standing
    probing: Standing
    travel: Array

    @property
    def part(self) -> PartOnMachine:
        """Returns the part from which it was made."""
        return self.finishing.part

    @property
    def comp_mtg(self) -> "CompMtg":
        """Returns COMP_MTG(T_cutting) as a displacement of the nose centre."""
        return CompMtg(self.finishing, self.travel)


@by_content
@dataclass(frozen=True)
class CompMtg:
    """COMP_MTG = −E of a tool that stands in the machine, going `travel` (2,), as a displacement of its path."""

    standing: Standing
    travel: Array

    def displacement_mm(self, at_mm: Array) -> Array:
        """Returns COMP_MTG at positions of the nose centre, (n, 2) to (n, 2)."""
        return -self.standing.error_mm(at_mm, self.travel)


def placed(part: PartOnMachine, matched: Commanded) -> InMachine:
    """Places the part where the finish pass of its program runs.

    Raises MCH-FRAME where the program's zero moves in the pass, MCH-PROGRAM where an axis turns round in it whose model
    tells forward and return travel apart.
    """
    with in_file(part.file):
        _require_one_zero(matched)
        travel = _travel(part, matched)
    finishing = Standing(part, part.cutting, part.tool_mm)
    return InMachine(
        finishing,
        replace(finishing, signals=part.semifinish),
        replace(finishing, signals=part.probing, tool_mm=part.probe_mm),
        travel,
    )


def _require_one_zero(matched: Commanded) -> None:
    path, moves = matched.path, slice(min(c.move for c in matched.cuts), max(c.move for c in matched.cuts) + 1)
    if (moved_mm := float(np.ptp(path.origin_mm[moves], axis=0).max())) > SAME_MM:
        raise Code.MCH_FRAME.refusal(
            f"the program's zero moves by {moved_mm:g} mm in the finish pass: where the part stands is not one place",
            hint="cut the finish pass in one coordinate system, and say in machine.work_zero_mm where its zero lies",
        )


def _travel(part: PartOnMachine, matched: Commanded) -> Array:
    ways = np.zeros(2)
    cuts = sorted(cut.move for cut in matched.cuts)
    along = [points_along(matched.path, np.intp(k), np.linspace(0.0, 1.0, ALONG_MOVE))[:, PLANE] for k in cuts]
    gone = np.concatenate([np.diff(points, axis=0) for points in along])
    for k, axis in enumerate("XZ"):
        signs = set(np.sign(gone[np.abs(gone[:, k]) > matched.resolution_mm / ALONG_MOVE, k]))
        if len(signs) == 1:
            ways[k] = signs.pop()
        elif signs and any(term.both_ways and term.name.axis == axis for term in part.model.terms):
            raise Code.MCH_PROGRAM.refusal(
                f"{axis} turns round in the finish pass of {len(cuts)} moves, and the model tells both ways apart",
                hint="correct the machine's error by `trueloop machine compensate`, or take a model without both_ways",
            )
    return ways


@dataclass(frozen=True)
class CutBefore:
    """The cut whose surface was measured. `carried`: the surface carries the machine's error."""

    nose_radius_mm: float
    allowance_mm: float
    carried: bool


@dataclass(frozen=True)
class Zero:
    """The machine's errors where the part's z counts from, along +z of the program, mm: as touched, as cut."""

    probed_mm: float = 0.0
    cut_in_mm: float = 0.0


@dataclass(frozen=True)
class Surface:
    """The machine's errors in measurements and in the surface that was measured, along the normals, (n,), mm.

    `touches`: part errors as they are, E(T_probing) added to what the control reported. `reported_mm`: that without.
    `cut_in_mm`: E of the cut before, which the surface carries; it is not an error of the process. `cut_in_seen_mm`:
    the same at the places of each reading of a gauge.
    """

    touches: ErrorVectors
    reported_mm: Array
    cut_in_mm: Array
    cut_in_seen_mm: tuple[Array, ...]

    @classmethod
    def plain(cls, reported: ErrorVectors) -> "Surface":
        """Returns the measurements of a part of whose machine nothing is known."""
        none = tuple(np.zeros(len(observation.weight)) for observation in reported.seen)
        return cls(reported, reported.error_mm, np.zeros(len(reported.error_mm)), none)


def surface_of(
    machine: InMachine, profile: Profile, reported: ErrorVectors, before: CutBefore, zero: Zero | None = None
) -> Surface:
    """Returns measurements of a part that was cut in a machine, with the machine's errors taken out of them.

    COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG(T_probing, COORDS_CONTROLLER), normal component, for touches of the
    machine's own probe; gauges and measuring machines measure the part elsewhere. What a reference touch or the datum
    of readings makes zero stays zero: its share is taken off all others. `zero`: where another edge cuts that place.
    """
    normal = reported.outward_normal
    zero = zero_of(machine, profile, reported, before) or zero or Zero()
    probed = np.where(reported.by_probe, _probed(machine, reported.nominal_mm, normal, before), 0.0)
    probed = np.where(reported.by_gauge, 0.0, probed - normal[:, 1] * zero.probed_mm)
    cut_in, *seen = (
        _cut_in(machine, at_mm, n, before) - n[:, 1] * zero.cut_in_mm
        for at_mm, n in [
            (reported.nominal_mm, normal),
            *(_places(profile, observation) for observation in reported.seen),
        ]
    )
    actual = replace(reported, error_mm=reported.error_mm + probed)
    return Surface(actual, reported.error_mm, cut_in, tuple(seen))


def zero_of(machine: InMachine, profile: Profile, reported: ErrorVectors, before: CutBefore) -> Zero | None:
    """Returns the machine's errors where z counts from: reference touch or datum; None: not among these."""
    reference = np.flatnonzero(reported.at_reference)
    if len(reference):
        at_mm, normal = reported.nominal_mm[reference], reported.outward_normal[reference]
        probed = _probed(machine, at_mm, normal, before)
    elif datum := [observation for observation in reported.seen if observation.standard_u_mm == 0.0]:
        at_mm, normal = _places(profile, datum[0])
        probed = np.zeros(1)
    else:
        return None
    cut_in = _cut_in(machine, at_mm, normal, before)
    return Zero(float(probed[0] / normal[0, 1]), float(cut_in[0] / normal[0, 1]))


def _probed(machine: InMachine, at_mm: Array, normal: Array, before: CutBefore) -> Array:
    """Returns E of the machine's probe along the normals, (n,); 0 where touches were taken elsewhere."""
    if machine.part.touched_on != "machine":
        return np.zeros(len(normal))
    ball_mm = at_mm + (before.allowance_mm + machine.part.ball_radius_mm) * normal
    return _along(machine.probing.error_mm(ball_mm, -np.sign(np.round(normal, 9))), normal)


def _cut_in(machine: InMachine, at_mm: Array, normal: Array, before: CutBefore) -> Array:
    """Returns E of the cut before along the normals, (n,); 0 where the surface does not carry it."""
    if not before.carried:
        return np.zeros(len(normal))
    nose_mm = at_mm + (before.allowance_mm + before.nose_radius_mm) * normal
    return _along(machine.semifinishing.error_mm(nose_mm, machine.travel), normal)


def _places(profile: Profile, reading: Seen) -> tuple[Array, Array]:
    """Returns the places of a reading and the normals there, (n, 2)."""
    pairs = list(zip(reading.feature_index.tolist(), reading.arc_length_mm.tolist(), strict=True))
    at_mm = [profile.features[i].point_mm(s) for i, s in pairs]
    return np.array(at_mm), np.array([profile.features[i].outward_normal(s) for i, s in pairs])


def of_process(
    machine: InMachine, profile: Profile, in_force: Sequence[Shift], nose_radius_mm: float
) -> tuple[Shift, ...]:
    """Returns the process's share of a composed correction in force: its contour less COMP_MTG at that temperature."""
    kept = []
    for feature, shift in zip(profile.features, in_force, strict=True):
        s = np.linspace(0.0, feature.length_mm, SAMPLES)
        normal = feature.outward_normal(s)
        error_mm = machine.semifinishing.error_mm(feature.point_mm(s) + nose_radius_mm * normal, machine.travel)
        kept.append(weighted_sum(((1.0, shift), (1.0, sampled(s, _along(error_mm, normal))))))
    return tuple(kept)


def check_composed(
    pieces: Sequence[CentrePiece],
    corrections: Sequence[Shift],
    displacements: tuple[Displacement, Displacement],
    limits: Limits,
) -> None:
    """Refuses COMP_MTG, or its sum with COMP_PROC, where it is too large or too steep: CMP-SIZE, CMP-SLOPE.

    `displacements` of the corrected path: COMP_MTG alone, and with it what of COMP_PROC is not a shift of a feature.
    """
    alone, whole = displacements
    for piece in pieces:
        check_along(piece, *magnitude(piece.shifted, ZERO, alone, cut_mm(piece)), limits, "COMP_MTG")
    for piece, own in zip(pieces, corrections, strict=True):
        check_along(piece, *magnitude(piece.shifted, own, whole, cut_mm(piece)), limits, "the composed correction")


def comp_mtg_at(machine: InMachine, touches: ErrorVectors, process_mm: Array, nose_radius_mm: float) -> Array:
    """Returns COMP_MTG along the normal where the nose cuts the touched places, moved by COMP_PROC (n,), (n,)."""
    normal = touches.outward_normal
    at_mm = touches.nominal_mm + (nose_radius_mm + process_mm)[:, None] * normal
    return _along(machine.comp_mtg.displacement_mm(at_mm), normal)


def model_u_mm(machine: InMachine, touches: ErrorVectors, nose_radius_mm: float) -> Array:
    """Returns the standard uncertainty of the next cut's error from that of the model's coefficients, (n,)."""
    probed = touches.by_probe
    covariance = model_covariance(machine, touches.nominal_mm, touches.outward_normal, nose_radius_mm, probed)
    return np.asarray(np.sqrt(np.maximum(np.diag(covariance), 0.0)))


def model_covariance(
    machine: InMachine, nominal_mm: Array, normal: Array, nose_radius_mm: float, probed: Flags | None = None
) -> Array:
    """Returns the covariance of the next cut's errors at places (n, 2) from that of the model's coefficients, (n, n).

    With δ(T) = E true − E modelled, the finished part keeps δ(cutting) − δ(semifinish), + δ(probing) of touches taken
    on the machine: equal temperatures leave one δ of three. `probed` (n,): which places such touches state; None: all.
    """
    at_mm = nominal_mm + nose_radius_mm * normal
    rows = machine.finishing.sensitivities(at_mm, machine.travel, normal)
    rows = rows - machine.semifinishing.sensitivities(at_mm, machine.travel, normal)
    if machine.part.touched_on == "machine":
        ball_mm = nominal_mm + machine.part.ball_radius_mm * normal
        of_touches = machine.probing.sensitivities(ball_mm, -np.sign(np.round(normal, 9)), normal)
        rows = rows + (of_touches if probed is None else of_touches * probed[:, None])
    return np.asarray(rows @ machine.part.model.covariance @ rows.T)


def _along(vectors: Array, normal: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", vectors, normal))
