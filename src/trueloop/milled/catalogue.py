"""The terms of a milled part's error, with the priors of their sizes.

Columns of a place: `part_type`, `part`, `feature`, `tool`, `work_offset`, `side` (of the cut) as labels; `order` (of
the part), `depth_share` (of a wall, 0 at its top to 1 at the tip of the tool), the place and the outward normal in the
part's frame. A coefficient is the error of a thing in its own sense; its basis is what that leaves on: a tool that is
larger by r than the control takes it for leaves −r on every wall, a longer one −l on faces that look up, and a work
offset displaced by d leaves d·n.

The medians are from milling in general, chosen before any measured part was looked at.
"""

from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.estimate.places import Places
from trueloop.estimate.term import Catalogue, Prior, Sizes, Term

_PRESET: Final = "a presetter or a touch-off, with run-out: a hundredth of a millimetre in radius, more in length"
_ZERO: Final = "a work offset is probed or edged to one or two hundredths of a millimetre, 0.1 mm over 500 mm"
_PUSHED: Final = "an end mill bends by some micrometres at its tip, away from the wall or into it"
_MACHINE: Final = "positions and circles of a machining centre: some micrometres (ISO 230-4, ISO 10791-7)"
_AGAIN: Final = "a part clamped again, minutes of heat: some micrometres"
_SCATTER: Final = "surface and ball of about a micrometre in place"

PRIORS: Final = {
    "radius": Prior(0.010, 0.7, _PRESET),
    "wear": Prior(0.0005, 1.0, _PRESET),
    "length": Prior(0.015, 0.7, _PRESET),
    "zero": Prior(0.020, 0.7, _ZERO),
    "turned": Prior(2e-4, 0.7, _ZERO),
    "pushed": Prior(0.006, 0.7, _PUSHED),
    "size": Prior(0.003, 0.7, _MACHINE),
    "place": Prior(0.003, 0.7, _MACHINE),
    "clamping": Prior(0.003, 0.7, _AGAIN),
    "clamping_turn": Prior(2e-5, 0.7, _AGAIN),
    "size_part": Prior(0.0015, 0.7, _AGAIN),
    "place_part": Prior(0.0015, 0.7, _AGAIN),
    "repeatability": Prior(0.001, 0.5, _SCATTER),
}
"""Standard deviations in mm, of turns in rad."""

TAIL: Final = 3.0
"""Degrees of freedom of a feature's own error: a chip in a bore, a wall recut."""


@cache
def milled_catalogue() -> Catalogue:
    """Returns the terms; one catalogue for all parts."""
    terms = (
        Term("tool radius", ("tool",), _wall, _flat("radius"), _flat("wear"), "order"),
        Term("tool length", ("tool",), _up, _flat("length"), _flat("wear"), "order"),
        Term("work offset", ("work_offset",), shift_basis, _flat("zero", 3)),
        Term("turn of the work offset", ("work_offset",), turn_basis, _flat("turned")),
        Term("tool pushed away", ("tool", "side"), _deep, _flat("pushed")),
        Term("size", ("part_type", "feature"), _constant, _flat("size"), tail=TAIL),
        Term("place", ("part_type", "feature"), shift_basis, _flat("place", 3), tail=TAIL),
        Term("clamping", ("part",), shift_basis, _flat("clamping", 3)),
        Term("turn of the clamping", ("part",), turn_basis, _flat("clamping_turn")),
        Term("size on the part", ("part", "feature"), _constant, _flat("size_part"), tail=TAIL),
        Term("place on the part", ("part", "feature"), shift_basis, _flat("place_part", 3), tail=TAIL),
    )
    return Catalogue(terms, _repeatability_mm2, PRIORS)


LASTING: Final = (
    "tool radius",
    "tool length",
    "work offset",
    "turn of the work offset",
    "tool pushed away",
    "size",
    "place",
)
"""Terms that the next part has in common with those before."""


def wall_share(places: Places) -> Array:
    """Returns the share of the outward normal that lies in the plane of the table, (n,): 1 on walls."""
    return np.hypot(places.number("normal_x"), places.number("normal_y"))


def shift_basis(places: Places) -> Array:
    """Returns the errors that unit displacements along x, y and z leave, (n, 3): the outward normal."""
    return np.column_stack([places.number(f"normal_{axis}") for axis in "xyz"])


def turn_basis(places: Places) -> Array:
    """Returns the errors that a unit turn about +z through the part's zero leaves, (n, 1): n·(ẑ × p), mm per rad."""
    x, y = places.number("x_mm"), places.number("y_mm")
    return np.asarray(places.number("normal_y") * x - places.number("normal_x") * y)[:, None]


def _flat(size: str, count: int = 1) -> Callable[[Sizes], Array]:
    return lambda sizes: np.full(count, sizes[size])


def _wall(places: Places) -> Array:
    return -wall_share(places)[:, None]


def _up(places: Places) -> Array:
    return -places.number("normal_z")[:, None]


def _deep(places: Places) -> Array:
    return np.asarray(wall_share(places) * places.number("depth_share"))[:, None]


def _constant(places: Places) -> Array:
    return np.ones((len(places), 1))


def _repeatability_mm2(places: Places, sizes: Sizes) -> Array:
    return np.full(len(places), sizes["repeatability"] ** 2)
