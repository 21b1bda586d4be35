"""A matched pass on its profile's side: a bore taken for an outside turns the sign of every error."""

from dataclasses import dataclass
from typing import Final

from trueloop.errors import Code, Place
from trueloop.nc.match.contour_match import ContourMatch

FACES_X: Final = 0.5
"""Share of the normal along x from which on a surface is one of an outside or of a bore, and no face."""


@dataclass(frozen=True)
class SidesOfCuts:
    """Indices of cuts whose rapid moves show on which side the tool is; of others they do not.

    `boring`: cuts retract towards the axis, and rapid moves run nearer to it. `turning`: the other way in both.
    """

    boring: frozenset[int] = frozenset()
    turning: frozenset[int] = frozenset()


def require_side(match: ContourMatch, shown: SidesOfCuts) -> None:
    """Raises NC-BORE where rapid moves show a feature's pass on the other side than the profile has it.

    Under G41 and G42 the sides are compared by the code itself (`match_contour`).
    """
    for feature in match.features:
        n_x = float(feature.feature.outward_normal(feature.feature.length_mm / 2)[0])
        other = shown.boring if n_x > FACES_X else shown.turning if n_x < -FACES_X else frozenset()
        for matched in feature.moves:
            move = matched.move
            if not move.on_contour and move.index in other:
                here, there = ("an outside", "bores") if n_x > 0 else ("a bore", "turns an outside")
                raise Code.NC_BORE.refusal(
                    f"line {move.line} cuts {feature.feature.name!r}, {here} of the profile, and its rapid moves show "
                    f"that it {there}",
                    hint="state `part.side`, and order the features of a bore from the free end to the chuck end",
                    place=Place(line=move.line),
                )
