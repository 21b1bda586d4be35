"""Parts cut after a correction beside those before: what is deterministic, what random, the worst [MPM Table 2]."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding
from trueloop.geometry.surface import Surface
from trueloop.loops.surface.correction import SurfaceInputs
from trueloop.loops.surface.surface import Part, Work, kept_parts, model_of
from trueloop.statistics import rms


@dataclass(frozen=True)
class Spread:
    """Deviations in mm: root mean square, least, greatest."""

    rms_mm: float
    low_mm: float
    high_mm: float

    @property
    def worst_mm(self) -> float:
        """The one farthest from zero, with its sign."""
        return self.high_mm if self.high_mm >= -self.low_mm else self.low_mm


@dataclass(frozen=True)
class PartFigures:
    """One part: all its deviations, and what of them is deterministic and random."""

    name: str
    measured: Spread
    deterministic: Spread
    random: Spread


@dataclass(frozen=True, eq=False)
class Group:
    """The parts of one job. `kept` are those that `model.exclude` does not name."""

    name: str
    kept: tuple[Part, ...]
    figures: tuple[PartFigures, ...]

    @property
    def worst(self) -> int:
        """Which part has the worst deviation."""
        return int(np.argmax([abs(part.measured.worst_mm) for part in self.figures]))

    def over_all(self, of: Callable[[PartFigures], Spread]) -> Spread:
        """All parts taken together: root mean square over parts, least and greatest of all."""
        spreads = [of(part) for part in self.figures]
        together = rms(np.array([spread.rms_mm for spread in spreads]))
        return Spread(together, min(s.low_mm for s in spreads), max(s.high_mm for s in spreads))

    def deterministic_mm(self, u: Array, v: Array) -> Array:
        """The mean of the parts' deterministic deviations on a grid of parameters in [0, 1]."""
        return np.asarray(np.mean([part.separation.deterministic.grid_mm(u, v) for part in self.kept], axis=0))


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both groups on one nominal surface."""

    surface: Surface
    before: Group
    after: Group

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The remarks on the parts of both."""
        return tuple(finding for group in (self.before, self.after) for part in group.kept for finding in part.findings)


def require_comparable(before: SurfaceInputs, after: SurfaceInputs) -> None:
    """Raises SRF-COMPARE for different surfaces or alignments."""
    a, b = before.surface.control_mm, after.surface.control_mm
    off = float(np.max(np.abs(a - b))) if a.shape == b.shape else np.inf
    if off > 0 or before.surface.flipped != after.surface.flipped:
        what = "its normals are turned over" if off == 0 else f"control points differ by {off:g} mm"
        raise Code.SRF_COMPARE.refusal(
            f"this is another nominal surface than that of the job before: {what}",
            hint="both jobs name the nominal surface of the drawing, also where a corrected one was machined",
        )
    if before.options.best_fit != after.options.best_fit:
        raise Code.SRF_COMPARE.refusal(
            f"gauging.alignment is {_alignment(after)!r} here and {_alignment(before)!r} in the job before",
            hint="deviations with and without location and orientation cannot be set beside each other",
        )


def _alignment(inputs: SurfaceInputs) -> str:
    return "best-fit" if inputs.options.best_fit else "datum"


def group_of(inputs: SurfaceInputs, work: Work) -> Group:
    """The parts taken apart. Raises SRF-PARTS where none is left."""
    parts = model_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=work)
    kept = tuple(kept_parts(parts, inputs.options))
    if not kept:
        raise Code.SRF_PARTS.refusal(f"0 of {len(parts)} parts are left to compare", hint="leave one in: model.exclude")
    found = []
    for part in kept:
        apart = part.separation
        deterministic = apart.measured_mm - apart.random_mm
        spreads = (_spread(values) for values in (apart.measured_mm, deterministic, apart.random_mm))
        found.append(PartFigures(part.deviations.name, *spreads))
    return Group(inputs.name, kept, tuple(found))


def _spread(values_mm: Array) -> Spread:
    return Spread(rms(values_mm), float(np.min(values_mm)), float(np.max(values_mm)))
