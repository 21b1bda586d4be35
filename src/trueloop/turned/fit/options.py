"""The user's options of the fit."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated

from trueloop.domain.option import Option
from trueloop.turned.fit.between_cuts import NONE, BetweenCuts
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.spline import EndConditions


class BadTouches(StrEnum):
    """The treatment of a touch that the others contradict beyond doubt: it is left out, or all touches are kept."""

    LEAVE_OUT = "leave-out"
    KEEP = "keep"


@dataclass(frozen=True)
class FitOptions:
    """The options of a fit; the defaults need none.

    `knot_every`: r, a knot at every r-th touch of an arc [6517 Eq. 5], and straight lines on lines; None lets the
    leave-one-out error choose, and lines bend where their touches show a bow.
    `knot_every_on`: r of single arcs, by feature name. `prescribed`: values and slopes at the ends of features, by
    name; a tangent neighbour's value stands above them, and a contradiction is refused. `repeatability_mm`: None takes
    the scatter of the touches about the curves less the probe's share (`process_scatter`), which holds when touches
    scatter as cuts do. `alike_over_mm`: over which length that is alike (None: the touches say, module `likeness`).
    `between_cuts`: what comes out differently from cut to cut, which the scatter within one part does not show
    (`between_cuts.PRIOR` where nothing is known of it). These widen what is predicted of the next cut and change no
    curve. `straight`: names of lines whose curves follow no bow, because their moves could not.
    """

    junctions: Annotated[
        TangentPolicy,
        Option(
            "compensation.junctions",
            'At tangent junctions, `"part"`: the predicted part is tangent; `"path"`: the compensation curve is, as '
            "published.",
        ),
    ] = TangentPolicy.PART
    knot_every: Annotated[
        int | None,
        Option(
            "compensation.knot_every",
            "A spline knot at every how manieth touch, but none on the last touch of an arc, and lines stay straight, "
            "as published; left out, the leave-one-out error chooses, and lines follow a bow that their touches show.",
            least=1,
            unit="points",
        ),
    ] = None
    knot_every_on: Mapping[str, int] = field(default_factory=dict)
    prescribed: Mapping[str, EndConditions] = field(default_factory=dict)
    straight: tuple[str, ...] = ()
    bad_touches: Annotated[
        BadTouches,
        Option(
            "compensation.bad_touches",
            "What becomes of a touch that the others contradict beyond doubt (see below): left out of the fit "
            '(`"leave-out"`), or `"keep"`: none is looked for.',
        ),
    ] = BadTouches.LEAVE_OUT
    repeatability_mm: Annotated[
        float | None,
        Option(
            "compensation.repeatability_um",
            "Standard deviation of the process from one cut to the next, known from earlier parts; left out, the "
            "touches' scatter about the curves less the probe's share (`repeatability_diameter_um`, "
            "`repeatability_face_um`), which holds when touches scatter as cuts do. Changes the predicted bands and no "
            "correction.",
            least=0,
        ),
    ] = None
    alike_over_mm: Annotated[
        float | None,
        Option(
            "compensation.alike_over_mm",
            "Over how many millimetres along a cut the process's scatter is alike (ℓ of exp(−d²/2ℓ²) at the distance "
            "d), known from earlier parts; 0: touches have nothing of it in common. Left out, the touches say how "
            "probable each length up to 2 mm is. Changes the predicted bands and no correction.",
            least=0,
        ),
    ] = None
    between_cuts: BetweenCuts = NONE

    def knot_every_for(self, feature: str) -> int | None:
        """Returns the r of a feature, None where leave-one-out chooses."""
        return self.knot_every_on.get(feature, self.knot_every)
