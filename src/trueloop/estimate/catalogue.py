"""The terms of a turned part's error, with the priors of their sizes.

A term of the error, and the catalogue of all terms with the priors of their sizes.

Columns of a place: `tool`, `edge` (one mounting of it), `setting` (of the tool: a mounting or touch-off), `part_type`,
`part`, `group` (labels; a group of features that meet tangentially), `age` (of the edge, in parts: the clock of wear),
`order` (of the part, in parts), `contact_angle_rad` (of the outward normal from +z to +x), `radius_mm` (from the axis
of the spindle), `z_mm` (from the middle of the part), `share` (along the group, 0 to 1), `finish` (1 of the finish cut,
0 of the cut before), `taken_off_mm` (what a correction was commanded to take off; 0 where an error is asked for that
nothing had been taken off from).

A group of features is displaced by (dX, dZ), of which an error is the part along the normal. Two places of it covary by
k(share, share') n·n': a shoulder that is set off along z does not bend the seat that it runs into. The finish cut alone
has a level of each group, along all normals: its displacement is that of the whole cut.

The two cuts of one part share nose, setting, clamping, form; what the finish cut does otherwise is terms of its own, so
that inspections of finished parts teach it. Medians are from turning in general (`source`). With the tables of NISTIR
6811 in sight were chosen: short waves as terms of their own (`short`, `short_part`, `finish_short`), that one feature
may be off by much (`TAIL`), that a cut differs near the axis (`axis`), and the size of `group`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.estimate.places import Places

Sizes: TypeAlias = Mapping[str, float]
"""Hyperparameters by name: standard deviations in mm (of a taper in mm per mm), lengths in rad or as shares."""

PART: Final = "part"
"""The label that a term of one part alone has in its scope."""


@dataclass(frozen=True)
class Prior:
    """A log-normal prior of a size: its median, the standard deviation of its logarithm, and where both come from."""

    median: float
    log_sd: float
    source: str


@dataclass(frozen=True)
class Term:
    """Basis functions of the place times coefficients.

    `scope`: the columns of a place whose values say whose coefficients these are; () for one set of all. `basis` maps
    n places to (n, m); `spread` maps sizes to the standard deviations (m,) of the coefficients before anything was
    measured, which may be zero. `step`: standard deviations of the random walk by one unit of the column `clock`; None:
    the coefficients are constant. `tail`: coefficients of each scope have Student's distribution with so many degrees
    of freedom, one scale for all of a scope, so that one feature of one part may be far off; None: normal ones.
    """

    name: str
    scope: tuple[str, ...]
    basis: Callable[[Places], Array]
    spread: Callable[[Sizes], Array]
    step: Callable[[Sizes], Array] | None = None
    clock: str = "order"
    tail: float | None = None

    @property
    def of_part(self) -> bool:
        """Returns whether its coefficients are of one part alone."""
        return PART in self.scope


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Terms, the repeatability variance of a cut at places (n,), and the priors of all sizes that both use.

    `gross`: the share of touches that are gross errors, by standard deviations `gross_factor` times as large.
    """

    terms: tuple[Term, ...]
    repeatability_mm2: Callable[[Places, Sizes], Array]
    priors: Mapping[str, Prior]
    gross: float = 0.01
    gross_factor: float = 15.0

    @property
    def medians(self) -> dict[str, float]:
        """Returns the priors' medians: the sizes before any part was measured."""
        return {name: prior.median for name, prior in self.priors.items()}

    def sizes(self, logarithms: Array) -> dict[str, float]:
        """Sizes from their logarithms, in the order of `priors`."""
        return dict(zip(self.priors, np.exp(logarithms).tolist(), strict=True))

    def logarithms(self, sizes: Sizes) -> Array:
        """Returns the logarithms of sizes, the reverse of `sizes`, (k,)."""
        return np.log([sizes[name] for name in self.priors])


MARGIN: Final = 2.5
"""By so many lengths the interval is wider at either end: the basis is zero at its own ends."""

FINENESS: Final = 4.0 / math.pi
"""Waves per length of the interval: the covariance is right within a percent."""


@dataclass(frozen=True)
class Waves:
    """Sines over [low, high], fit for squared-exponential functions of lengths around `length`.

    Hilbert-space approximation of a Gaussian process (Solin and Särkkä, Statistics and Computing 30, 2020):
    eigenfunctions of the Laplacian on an interval wider than the one of interest; the spectral density at their
    frequencies is the variance of their coefficients. The basis does not depend on the length scale.
    """

    low: float
    high: float
    length: float

    @property
    def _half(self) -> float:
        return 0.5 * (self.high - self.low) + MARGIN * self.length

    @property
    def count(self) -> int:
        """Returns the number m of functions."""
        return math.ceil(FINENESS * 2.0 * self._half / (0.7 * self.length))

    @cached_property
    def frequency(self) -> Array:
        """Returns the angular frequencies, (m,)."""
        return np.asarray(np.arange(1, self.count + 1) * (math.pi / (2.0 * self._half)), dtype=np.float64)

    def at(self, x: Array) -> Array:
        """Values of the functions, (n, m)."""
        away = np.asarray(x)[:, None] - 0.5 * (self.low + self.high) + self._half
        return np.asarray(np.sin(self.frequency * away) / math.sqrt(self._half))

    def spread(self, sd: float, length: float) -> Array:
        """Returns the standard deviations of the coefficients of a function of that deviation and length, (m,)."""
        density = math.sqrt(math.sqrt(2.0 * math.pi) * length)
        return np.asarray(sd * density * np.exp(-0.25 * (length * self.frequency) ** 2))


_SETTING: Final = "a touch-off or a presetter places an edge within some hundredths of a millimetre"
_CLAMPING: Final = "a part clamped again, a turret indexed, minutes of heat: ISO 230-2 and 13041-8, 2 µm in all"
_NOSE: Final = "a worn nose departs from its circle by some micrometres to tens of them"
_STRAIGHT: Final = "deflection and tailstock: some micrometres over 100 mm; from part to part a third"
_AXIS: Final = "at the axis the cutting speed is zero: within some millimetres material is pressed away, not cut"
_GROUP: Final = (
    "speed, chip thickness and stiffness differ from feature to feature: by some micrometres, seldom by tens"
)
_CUTS: Final = "cuts of different depth differ by some micrometres, from part to part by less"
_GAIN: Final = "a control makes what a program says; a diameter entered as a radius makes twice that"
_SCATTER: Final = "surface and ball of some tenths of a micrometre to some micrometres in place"

PRIORS: Final = {
    "setting": Prior(0.020, 0.7, _SETTING),
    "walk": Prior(0.0015, 0.7, _CLAMPING),
    "clamping": Prior(0.002, 0.7, _CLAMPING),
    "nose": Prior(0.008, 1.0, _NOSE),
    "nose_length": Prior(0.35, 0.5, _NOSE),
    "wear": Prior(0.0005, 1.0, _NOSE),
    "form": Prior(0.0015, 0.7, _NOSE),
    "form_length": Prior(0.44, 0.5, _NOSE),
    "short": Prior(0.0015, 0.7, _NOSE),
    "short_part": Prior(0.0015, 0.7, _NOSE),
    "short_length": Prior(0.1, 0.5, _NOSE),
    "taper": Prior(4.0e-5, 0.7, _STRAIGHT),
    "taper_part": Prior(1.5e-5, 0.7, _STRAIGHT),
    "axis": Prior(0.010, 1.0, _AXIS),
    "along": Prior(0.006, 1.0, _STRAIGHT),
    "along_length": Prior(0.35, 0.5, _STRAIGHT),
    "group": Prior(0.008, 0.7, _GROUP),
    "group_part": Prior(0.0015, 0.7, _GROUP),
    "tilt_part": Prior(0.002, 0.7, _GROUP),
    "finish_level": Prior(0.003, 0.7, _CUTS),
    "finish": Prior(0.003, 0.7, _CUTS),
    "finish_length": Prior(0.52, 0.5, _CUTS),
    "finish_short": Prior(0.0015, 0.7, _CUTS),
    "finish_clamping": Prior(0.0015, 0.7, _CLAMPING),
    "finish_form": Prior(0.001, 0.7, _CUTS),
    "finish_form_length": Prior(0.44, 0.5, _CUTS),
    "finish_group": Prior(0.0015, 0.7, _GROUP),
    "repeatability": Prior(0.001, 0.3, _SCATTER),
    "gain": Prior(0.01, 1.5, _GAIN),
    "finish_repeatability": Prior(0.001, 0.3, _SCATTER),
}
"""Standard deviations in mm, of a taper in mm per mm; lengths in rad, of `along_length` as a share of the group."""

WEAR_RATE: Final = Prior(PRIORS["wear"].median, PRIORS["wear"].log_sd, _NOSE)
"""The prior of the wear that goes on in one direction, mm a part: as large as that of the wear that does not."""

NEAR_AXIS_MM: Final = (2.0, 4.0)
"""Standard deviations of the bells over which what differs at the axis fades away."""

TAIL: Final = 3.0
"""Degrees of freedom of what one feature of one part is off by: a chip or a burr under a face, a feature recut; and of
what one finish cut is displaced by: a chip under the tool, an offset entered that nobody stated.
"""


SHARED: Final = ("nose", "setting", "finish level", "finish form")
"""Terms of an edge that other edges of its tool have a share in. Short waves of the nose are notches of one edge."""


@lru_cache(maxsize=32)
def turned_catalogue(
    lowest_rad: float = 0.0, highest_rad: float = np.pi, drifting: bool = False, several_edges: bool = False
) -> Catalogue:
    """Returns the terms for parts whose contact angles lie within [lowest, highest]; one catalogue for all that ask.

    `drifting`: with wear that goes on at a constant rate along all normals, of which parts measured before their
    finish cut need no knowledge: their own touches show it. `several_edges`: half of the variance of the terms in
    `SHARED` is common to all edges of a tool, whose holder, geometry and grade of insert stay; the other half, and all
    wear, begins anew with each edge. Of one edge alone the two halves do what the whole does.
    """
    angles = Waves(lowest_rad, highest_rad, 0.35)
    short = Waves(lowest_rad, highest_rad, 0.1)
    along = Waves(0.0, 1.0, 0.35)

    def of_angle(places: Places) -> Array:
        return angles.at(places.number("contact_angle_rad"))

    def of_angle_short(places: Places) -> Array:
        return short.at(places.number("contact_angle_rad"))

    def of_share(places: Places) -> Array:
        return along.at(places.number("share"))

    def waves(of: Waves, size: str, length: str) -> Callable[[Sizes], Array]:
        return lambda sizes: of.spread(sizes[size], sizes[length])

    terms: tuple[Term, ...] = (
        Term(
            name="nose",
            scope=("edge",),
            basis=of_angle,
            spread=waves(angles, "nose", "nose_length"),
            step=waves(angles, "wear", "nose_length"),
            clock="age",
        ),
        Term("short nose", ("edge",), of_angle_short, waves(short, "short", "short_length")),
        Term(
            name="setting",
            scope=("setting",),
            basis=_normal,
            spread=_half_of("setting", 2),
            step=_flat("walk", 2),
            clock="order",
        ),
        Term("part zero", ("part_type",), _normal, _half_of("setting", 2)),
        Term("clamping", ("part",), _normal, _flat("clamping", 2)),
        Term("form of the part", ("part",), of_angle, waves(angles, "form", "form_length")),
        Term("short form of the part", ("part",), of_angle_short, waves(short, "short_part", "short_length")),
        Term("taper", ("part_type",), _taper, _flat("taper")),
        Term("taper of the part", ("part",), _taper, _flat("taper_part")),
        Term("near the axis", ("part_type",), _near_axis, _flat("axis", len(NEAR_AXIS_MM))),
        Term("form along", ("part_type", "group"), _displaced(of_share), _twice(waves(along, "along", "along_length"))),
        Term("group", ("part_type", "group"), _normal, _flat("group", 2), tail=TAIL),
        Term("group of the part", ("part", "group"), _normal, _flat("group_part", 2), tail=TAIL),
        Term("tilt of the part", ("part", "group"), _displaced(_tilt), _flat("tilt_part", 2), tail=TAIL),
        Term("gain", ("tool",), _taken_off, _flat("gain")),
        Term("finish level", ("edge",), _finish(_constant), _flat("finish_level")),
        Term("finish form", ("edge",), _finish(of_angle), waves(angles, "finish", "finish_length")),
        Term(
            "finish form of the type",
            ("part_type",),
            _finish(of_angle_short),
            waves(short, "finish_short", "short_length"),
        ),
        Term("finish clamping", ("part",), _finish(_normal), _flat("finish_clamping", 2), tail=TAIL),
        Term(
            "finish form of the part", ("part",), _finish(of_angle), waves(angles, "finish_form", "finish_form_length")
        ),
        Term("finish group of the part", ("part", "group"), _finish(_constant), _flat("finish_group")),
    )
    if several_edges:
        terms = tuple(share for term in terms for share in (_halves(term) if term.name in SHARED else (term,)))
    if not drifting:
        return Catalogue(terms, _repeatability_mm2, PRIORS)
    rate = Term("wear rate", ("edge",), _aged, _flat("wear_rate"))
    return Catalogue((*terms, rate), _repeatability_mm2, {**PRIORS, "wear_rate": WEAR_RATE})


def _halves(term: Term) -> tuple[Term, Term]:
    """Returns the share of each edge and setting, and the share of their tool, which does not wear."""

    def half(sizes: Sizes) -> Array:
        return np.asarray(term.spread(sizes) / math.sqrt(2.0))

    of_tool = replace(term, name=f"{term.name} of the tool", scope=("tool",), spread=half, step=None)
    return replace(term, spread=half), of_tool


def _flat(size: str, count: int = 1) -> Callable[[Sizes], Array]:
    return lambda sizes: np.full(count, sizes[size])


def _half_of(size: str, count: int) -> Callable[[Sizes], Array]:
    """Half of the variance: tool and part zero are set alike well, and both displace a part."""
    return lambda sizes: np.full(count, sizes[size] / np.sqrt(2.0))


def _normal(places: Places) -> Array:
    """Returns a displacement (dX, dZ) along the outward normal (sin φ, cos φ), (n, 2)."""
    angle = places.number("contact_angle_rad")
    return np.column_stack([np.sin(angle), np.cos(angle)])


def _displaced(basis: Callable[[Places], Array]) -> Callable[[Places], Array]:
    """Returns the basis (n, 2m) of a displacement along the normal whose dX and dZ are each a sum of m functions."""

    def along_normal(places: Places) -> Array:
        along_x, along_z = _normal(places).T
        values = basis(places)
        return np.hstack([values * along_x[:, None], values * along_z[:, None]])

    return along_normal


def _twice(spread: Callable[[Sizes], Array]) -> Callable[[Sizes], Array]:
    return lambda sizes: np.tile(spread(sizes), 2)


def _taper(places: Places) -> Array:
    """Returns the effect of a radius that grows with z."""
    return np.asarray((places.number("z_mm") * np.sin(places.number("contact_angle_rad")))[:, None])


def _near_axis(places: Places) -> Array:
    """Returns bells about the axis, (n, 2): what is turned is level there."""
    return np.asarray(np.exp(-0.5 * (places.number("radius_mm")[:, None] / np.array(NEAR_AXIS_MM)) ** 2))


def _tilt(places: Places) -> Array:
    """Returns a tilt: from −1 at the start of a group to 1 at its end."""
    return np.asarray((2.0 * places.number("share") - 1.0)[:, None])


def _taken_off(places: Places) -> Array:
    """Error left on if the machine makes less of a correction than was commanded: (1 − gain) of it."""
    return np.asarray((places.number("taken_off_mm") * places.number("finish"))[:, None])


def _constant(places: Places) -> Array:
    return np.ones((len(places), 1))


def _aged(places: Places) -> Array:
    return places.number("age")[:, None]


def _finish(basis: Callable[[Places], Array]) -> Callable[[Places], Array]:
    return lambda places: np.asarray(basis(places) * places.number("finish")[:, None])


def _repeatability_mm2(places: Places, sizes: Sizes) -> Array:
    of_finish = places.number("finish") == 1.0
    return np.where(of_finish, sizes["finish_repeatability"], sizes["repeatability"]) ** 2
