"""The predicted bands held against the finished parts of [6811]: what trueloop's correction would have left in metal.

NIST measured F after a finish cut that its own correction C had displaced. Had nothing been corrected the finish cut
would have erred by F − C; with trueloop's correction P in the place of C it would have left F − C + P, as far as
cutting a displaced contour displaces the surface by as much. C is rebuilt from the same touches as [6811 §3.2 and §3.3]
says: straight lines on straight features, on arcs the spline of [6517] with a knot at every third point, tangent to a
tangent neighbour. The report prints neither C nor how its knots were counted.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from scripts.nist_parts import NistPart
from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.statistics import rms
from trueloop.turned.error_curve.fit_profile import fit_profile
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.options import FitOptions
from trueloop.units import UM_PER_MM

PUBLISHED = FitOptions(junctions=TangentPolicy.PATH, knot_every=3)
HEAD = """## Do the bands hold on metal?

What trueloop's correction would have left in the metal that NIST cut: the measured error of NIST's finish cut, less the
correction that NIST's program carried, plus trueloop's. NIST's correction is rebuilt as [6811 §3.2–3.3] says: straight
lines on straight features, on arcs a spline with a knot at every third touch, tangent to a tangent neighbour. **Mean**
and **RMS** are of that; **inside** is the share of touches where it lies within the predicted ±U (95 %), first with the
prior for what differs between two cuts (`turned/fit/between_cuts.py`, in force unless the job says otherwise), then
without any. The prior was set from general turning practice before these tables were held against it.

"""
TITLES = ("Part", "Touches", "Mean, µm", "RMS, µm", "Inside", "Inside without the prior")


@dataclass(frozen=True)
class Held:
    """What would have been left at the touches of one part or of several, and the half bands, (n,), mm."""

    name: str
    left_mm: Array
    expanded_u_mm: Array
    without_prior_mm: Array

    @property
    def inside(self) -> float:
        """Share of touches inside the predicted band."""
        return float(np.mean(np.abs(self.left_mm) <= self.expanded_u_mm))

    @property
    def inside_without_prior(self) -> float:
        """The same of a band that takes two cuts for alike."""
        return float(np.mean(np.abs(self.left_mm) <= self.without_prior_mm))

    def __str__(self) -> str:
        mean, root = np.mean(self.left_mm) * UM_PER_MM, rms(self.left_mm) * UM_PER_MM
        shares = (f"{share:.0%}".replace("%", " %") for share in (self.inside, self.inside_without_prior))
        return f"| {' | '.join([self.name, str(len(self.left_mm)), f'{mean:+.1f}', f'{root:.1f}', *shares])} |"


def held(name: str, part: NistPart, correction: Correction) -> Held:
    """One part; all touches but the z reference."""
    budget, chosen = correction.prediction.budget, ~correction.touches.at_reference
    finish = np.array([touch.error_mm for touch in part.finish], dtype=np.float64)
    published = correction.touches.error_mm - fit_profile(part.profile, correction.touches, PUBLISHED).residual_mm
    ours = correction.prediction.before_mm - correction.prediction.after_mm
    left = finish + published - ours
    return Held(name, left[chosen], budget.expanded_u_mm[chosen], budget.alike.expanded_u_mm[chosen])


def together(name: str, parts: Sequence[Held]) -> Held:
    """Several parts as one."""
    columns = ((one.left_mm, one.expanded_u_mm, one.without_prior_mm) for one in parts)
    return Held(name, *(np.concatenate(column) for column in zip(*columns, strict=True)))


def section(results: Sequence[tuple[str, NistPart, Correction]]) -> str:
    """The section of the page: every part, the families, and all."""
    rule = "|".join(["---", *["--:"] * (len(TITLES) - 1)])
    return HEAD + "\n".join([f"| {' | '.join(TITLES)} |", f"|{rule}|", *map(str, _rows(results))]) + "\n"


def _rows(results: Sequence[tuple[str, NistPart, Correction]]) -> Iterator[Held]:
    each = [(part.family.name, held(name, part, correction)) for name, part, correction in results]
    yield from (one for _, one in each)
    for family in dict.fromkeys(name for name, _ in each):
        yield together(f"**all {family}**", [one for name, one in each if name == family])
    yield together("**all parts**", [one for _, one in each])
