"""A turned part as it stands in a machine whose errors are known: E in the part's plane, at the places of one job.

The tool stands at commanded + E. What a program says at position P is placed at P + zero of the program in the machine;
the axes stand there less the tool's own vector. COMP_MTG = −E is added to commands; what the control reports of a touch
is corrected by COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG(T_probing, COORDS_CONTROLLER) [6876 §3.3].
"""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.domain.machine import Machine
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.loops.turned.commanded import Commanded
from trueloop.machine.correct import Setup, state_at
from trueloop.machine.model.chain import Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals, means
from trueloop.machine.model.validity import check_state
from trueloop.nc.program.along import points_along

PLANE = (0, 2)
"""Of X, Y, Z those of a lathe's plane."""
SAME_MM = 1e-9
SAMPLES = 33


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
        """Which one it is."""
        return Machine(self.model.machine.name, self.model.machine.serial)

    @property
    def mark(self) -> str:
        """What a corrected program says of it."""
        return f"composed of COMP_MTG by model {self.sha256[:16]} and COMP_PROC"

    def as_record(self) -> dict[str, object]:
        """By which a record knows it."""
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
            raise TrueloopError(
                refused.code, refused.message, hint=refused.hint, override=override, values=refused.values
            ) from refused
        return state

    def error_mm(self, at_mm: Array, travel: Array) -> Array:
        """E, (n, 2): where the tool is less where it is sent."""
        with in_file(self.part.file):
            return np.asarray(self.part.model.error_mm(self.state(at_mm, travel))[:, PLANE])

    def sensitivities(self, at_mm: Array, travel: Array, normal: Array) -> Array:
        """DE along normals (n, 2) by every coefficient of the model, (n, coefficients)."""
        with in_file(self.part.file):
            rows = self.part.model.sensitivities(self.state(at_mm, travel))[:, PLANE, :]
        return np.asarray(np.einsum("ni,nik->nk", normal, rows))


@dataclass(frozen=True)
class InMachine:
    """One job's finish pass placed in the machine: the tool when finishing and semi-finishing, and the probe.

    `travel` (2,): which way x and z go in the finish pass, 0 where it is not known.
    """

    finishing: Standing
    semifinishing: Standing
    probing: Standing
    travel: Array

    @property
    def part(self) -> PartOnMachine:
        """What it was made of."""
        return self.finishing.part

    @property
    def comp_mtg(self) -> "CompMtg":
        """COMP_MTG(T_cutting) as a displacement of the nose centre."""
        return CompMtg(self.finishing, self.travel)


@by_content
@dataclass(frozen=True)
class CompMtg:
    """COMP_MTG = −E of a tool that stands in the machine, going `travel` (2,), as a displacement of its path."""

    standing: Standing
    travel: Array

    def displacement_mm(self, at_mm: Array) -> Array:
        """COMP_MTG at positions of the nose centre, (n, 2) to (n, 2)."""
        return -self.standing.error_mm(at_mm, self.travel)


def placed(part: PartOnMachine, matched: Commanded) -> InMachine:
    """The part where the finish pass of its program runs.

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
        raise TrueloopError(
            Code.MCH_FRAME,
            f"the program's zero moves by {moved_mm:g} mm in the finish pass: where the part stands is not one place",
            hint="cut the finish pass in one coordinate system, and say in machine.work_zero_mm where its zero lies",
        )


def _travel(part: PartOnMachine, matched: Commanded) -> Array:
    ways = np.zeros(2)
    cuts = sorted(cut.move for cut in matched.cuts)
    along = [points_along(matched.path, np.intp(k), np.linspace(0.0, 1.0, SAMPLES))[:, PLANE] for k in cuts]
    gone = np.concatenate([np.diff(points, axis=0) for points in along])
    for k, axis in enumerate("XZ"):
        signs = set(np.sign(gone[np.abs(gone[:, k]) > matched.resolution_mm / SAMPLES, k]))
        if len(signs) == 1:
            ways[k] = signs.pop()
        elif signs and any(term.both_ways and term.name.axis == axis for term in part.model.terms):
            raise TrueloopError(
                Code.MCH_PROGRAM,
                f"{axis} turns round in the finish pass of {len(cuts)} moves, and the model tells both ways apart",
                hint="correct the machine's error by `trueloop machine compensate`, or take a model without both_ways",
            )
    return ways
