"""General tolerances of a drawing: ISO 2768-1:1989, classes f, m, c, v.

They are of sizes without a tolerance of their own. The first part, for linear and angular sizes, is in force; the
second (general geometrical tolerances H, K, L) was withdrawn in 2021 for ISO 22081, which has no classes: there, the
drawing states general tolerances as numbers. The second letter of "ISO 2768-mK" is read and judges no size.
"""

import re
from bisect import bisect_left
from dataclasses import dataclass
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code
from trueloop.wording import wording

NAME: Final = re.compile(r"(?:DIN\s*)?(?:EN\s*)?(?:ISO\s*)?2768\s*(?:-\s*1)?\s*[-\s:]?\s*([fmcv])([HKL]?)")
LEAST_MM: Final = 0.5
"""Below, a drawing has to state the tolerance at the size."""
LINEAR_MM: Final = (3, 6, 30, 120, 400, 1000, 2000, 4000)
"""Upper bounds of the ranges of Table 1."""
LINEAR: Final = {
    "f": (0.05, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, None),
    "m": (0.1, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0),
    "c": (0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.0),
    "v": (None, 0.5, 1.0, 1.5, 2.5, 4.0, 6.0, 8.0),
}
EDGES_MM: Final = (3, 6, 4000)
EDGES: Final = {"f": (0.2, 0.5, 1.0), "m": (0.2, 0.5, 1.0), "c": (0.4, 1.0, 2.0), "v": (0.4, 1.0, 2.0)}
"""Table 2: external radii and chamfers that break an edge."""
SIDES_MM: Final = (10, 50, 120, 400, 1e6)
ANGLES_MINUTES: Final = {
    "f": (60, 30, 20, 10, 5),
    "m": (60, 30, 20, 10, 5),
    "c": (90, 60, 30, 15, 10),
    "v": (180, 120, 60, 30, 20),
}
"""Table 3, by the shorter side of the angle."""


@dataclass(frozen=True)
class Edge:
    """Classes that depend on more than the size: the shorter side of an angle, and whether a radius breaks an edge."""

    side_mm: float
    broken: bool = False


def deviation(name: str, quantity: Quantity, nominal: float, edge: Edge) -> float | None:
    """The ± of a size, mm or degrees; None: `name` is no general tolerance. Raises TOL-SIZE beyond the tables."""
    found = NAME.fullmatch(name.strip())
    if found is None:
        return None
    if quantity is Quantity.ANGLE:
        minutes = ANGLES_MINUTES[found[1]]
        return minutes[bisect_left(SIDES_MM, edge.side_mm)] / 60.0
    bounds, row = (EDGES_MM, EDGES[found[1]]) if edge.broken else (LINEAR_MM, LINEAR[found[1]])
    inside = LEAST_MM <= nominal <= bounds[-1]
    of_size = row[bisect_left(bounds, nominal)] if inside else None
    if of_size is None or quantity not in (Quantity.DIAMETER, Quantity.LENGTH, Quantity.RADIUS):
        raise Code.TOL_SIZE.refusal(
            wording(
                "{name} has no tolerance for a {quantity} of {nominal:.4f} mm",
                name=name,
                quantity=quantity,
                nominal=nominal,
            ),
            hint=wording("state the tolerance of this size by itself: ISO 2768-1 begins at 0.5 mm and ends at 4000 mm"),
            values={"tolerance": name, "nominal_mm": nominal},
        )
    return of_size
