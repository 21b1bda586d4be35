"""The numbers at a milling machine's control, the errors that they leave, and the parts that were cut with them.

Parts that were not cut with the numbers that are stated as entered.

A part is expected from the parts before it, with their scatter, or with that of milling in general where it is more:
never with a scatter fitted to the part itself, which would take any slip for scatter of the machine. An entry, or a
slip of several, displaces the n readings that show it by d (n,). Of that the share m = dᵀy / dᵀd is seen, y being what
the part lies off, with the standard uncertainty u. A slip is m = 1, none m = 0: it lowers

    χ² = (m / u)²     to     ((m − 1) / u)²     by     (2m − 1) / u²

A slip is that of a person: a number, its last change or several at once were not entered, entered twice, or with the
other sign, or radii went into registers that hold diameters.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.estimate.history import after_parts
from trueloop.estimate.places import Observed, Places
from trueloop.estimate.sizes import fitted_sizes
from trueloop.estimate.state import State, Updated
from trueloop.milled.observed import (
    DIFFERENT_MM,
    ObservedSize,
    milled_catalogue,
    odd_features,
    shift_basis,
    turn_basis,
    wall_share,
    with_device_off,
)
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

Register: TypeAlias = Literal["radius", "length", "x", "y", "z", "turn"]

PLAINEST: Final[tuple[Register, ...]] = ("radius", "length", "x", "y", "z", "turn")


@dataclass(frozen=True, order=True)
class Entry:
    """A number at the control: which register, and of which tool (its number) or work offset."""

    register: Register
    of: str

    @property
    def words(self) -> str:
        """Returns words such as `tool 2, radius` or `G54, X`."""
        if self.register in ("radius", "length"):
            return f"tool {self.of}, {self.register}"
        return f"{self.of}, {'rotation about Z' if self.register == 'turn' else self.register.upper()}"

    def basis(self, places: Places) -> Array:
        """Returns the error that an entry of +1 (mm, or rad of a turn) leaves at places, (N,)."""
        if self.register in ("radius", "length"):
            mine = np.asarray(places.columns["tool"]) == self.of
            moved = wall_share(places) if self.register == "radius" else places.number("normal_z")
            effect = moved * places.number(f"{self.register}_at_control")
        else:
            mine = np.asarray(places.columns["work_offset"]) == self.of
            turn = self.register == "turn"
            effect = turn_basis(places)[:, 0] if turn else shift_basis(places)[:, "xyz".index(self.register)]
        return np.where(mine, effect, 0.0)


Entered: TypeAlias = Mapping[Entry, float]
"""Totals since the first measured part, mm or rad."""


@dataclass(frozen=True, eq=False)
class Part:
    """One measured part in the order of cutting: what was seen with which deviations, and the entries in force."""

    serial: str
    shown: tuple[ObservedSize, ...]
    observed: Observed
    in_force: Entered

    def as_first_set(self) -> Observed:
        """Returns the values without what the entries in force did to them."""
        effect = sum((value * entry.basis(self.observed.places) for entry, value in self.in_force.items()), np.zeros(1))
        known = self.observed.of(np.broadcast_to(effect, len(self.observed.places)))
        return replace(self.observed, value_mm=self.observed.value_mm - known)

    def with_device_off(self, off: Collection[str]) -> "Part":
        """Returns the part with readings of which some devices may be off."""
        return replace(self, observed=with_device_off(self.observed, off))

    def contradictory(self) -> tuple["Contradictory", ...]:
        """Returns the sizes and coordinates that were read several times with values further apart than surfaces and
        instrument explain: a diameter and a radius of one feature are one size, and so are diameters at two depths.
        """
        rows_of = dict[tuple[object, ...], list[int]]()
        length = np.array([float(np.linalg.norm(size.weights)) for size in self.shown])
        for k, size in enumerate(self.shown):
            alike = tuple(np.round(size.weights / length[k], 9).tolist())
            rows_of.setdefault((*(feature.name for feature in size.features), alike), []).append(k)
        again = [rows for rows in rows_of.values() if len(rows) > 1]
        if not again:
            return ()
        value = self.observed.value_mm / length
        state = State.before(milled_catalogue()).at(self.observed.places)
        follows = self.observed.of(state.design(self.observed.places)) / length[:, None]
        noise = state.noise_mm2(self.observed) / np.outer(length, length)
        found = list[Contradictory]()
        for rows in again:
            low, high = min(rows, key=value.__getitem__), max(rows, key=value.__getitem__)
            apart = follows[[high]] - follows[[low]]
            variance = state.covariance_of(apart)[0, 0] + noise[low, low] + noise[high, high] - 2.0 * noise[low, high]
            if (value[high] - value[low]) ** 2 > CONTRADICTED * variance:
                counted = max(rows, key=length.__getitem__)
                limits_mm = (float(value[low] * length[counted]), float(value[high] * length[counted]))
                names = dict.fromkeys(self.shown[k].name for k in (counted, *rows))
                found.append(Contradictory(tuple(names), self.serial, len(rows), limits_mm))
        return tuple(found)

    def exchanged(self) -> tuple["Exchanged", ...]:
        """Returns the sizes of a bore and a boss, or a slot and a rib, that fit the part far better with their readings
        exchanged: nominal values that are alike do not show that, and one tool errs on both with opposite signs.
        """
        pairs = [
            (k, j)
            for k, size in enumerate(self.shown)
            for j, other in enumerate(self.shown[:k])
            if size.width and other.width and size.features[0].inward != other.features[0].inward
            if abs(size.nominal_mm - other.nominal_mm) <= DIFFERENT_MM and len(size.weights) == len(other.weights)
        ]
        if not pairs:
            return ()
        innovation = State.before(milled_catalogue()).given(self.as_first_set(), robust=False).innovation
        precision, off, found = np.linalg.inv(innovation.covariance_mm2), innovation.mean_mm, list[Exchanged]()
        for k, j in pairs:
            change = np.zeros(len(off))
            change[k] = self.observed.value_mm[j] + self.shown[j].nominal_mm
            change[k] -= self.observed.value_mm[k] + self.shown[k].nominal_mm
            change[j] = -change[k]
            if -float(change @ precision @ (2.0 * off + change)) > SLIPPED:
                found.append(Exchanged((self.shown[j].name, self.shown[k].name), self.serial))
        return tuple(found)

    def without(self, sizes: Collection[str], features: Collection[str] = ()) -> "Part":
        """Returns the part without the readings of some sizes and coordinates, and of some features."""
        rows = [
            k
            for k, size in enumerate(self.shown)
            if size.name not in sizes and all(feature.name not in features for feature in size.features)
        ]
        own = self.observed
        observed = replace(
            own, value_mm=own.value_mm[rows], standard_u_mm=own.standard_u_mm[rows], functional=own.matrix[rows]
        )
        return replace(self, shown=tuple(self.shown[k] for k in rows), observed=observed)


@dataclass(frozen=True)
class Contradictory:
    """A size or coordinate that was read several times on a part: the lowest and the highest deviation, mm.

    `names` are those of its readings; deviations of the others are counted as those of the first.
    """

    names: tuple[str, ...]
    serial: str
    readings: int
    between_mm: tuple[float, float]


@dataclass(frozen=True)
class Exchanged:
    """Two sizes of a part whose readings fit each other's feature."""

    names: tuple[str, str]
    serial: str


PARTS_FOR_SIZES: Final = 3
"""From so many parts on the sizes of the terms are fitted: before, one chip would make all features look uneven."""
CONTRADICTED: Final = 36.0
"""χ² of one degree of freedom, of any displacement as an entry makes it, above which a part was not cut as stated."""
SLIPPED: Final = 20.0
"""A slip that lowers χ² by more than this happened: of a part cut as stated by chance once in 250 000 times at most."""
SUSPECTED: Final = 6.0
"""A slip that lowers χ² by more than this is 20 times likelier than none: it is named, and nothing is refused."""
FITS: Final = 0.25
"""So much of a slip, beside three standard uncertainties, what is seen may differ from it."""
AS_WELL: Final = 9.0
"""A slip whose χ² is above the least by less than this explains a part as well."""
MOST_NAMED: Final = 3
LEAST_MM: Final = 1e-6
"""A displacement by less moves nothing."""
SHOWS: Final = 0.1
"""Readings that a displacement moves by less than this share of what it moves others by do not show it."""


@dataclass(frozen=True, eq=False)
class _Slip:
    """A mistake at the control: `moved` are the numbers that it changes, mm or rad, `words` describe it."""

    moved: Entered
    words: str


@dataclass(frozen=True, eq=False)
class _Seen:
    """The share of a displacement that a part shows, with its standard uncertainty and the features that show it.

    `displaced` (n,) is the displacement of all readings, `rows` (n,) are those that the share is of.
    """

    share: float
    u: float
    features: int
    displaced: Array
    rows: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class AgainstEarlier:
    """The comparison of parts with what those before each of them predict.

    `odd`: the features of each part that are off by themselves, as by a chip; the first part has none. `suspected`: the
    slips that would explain the last part, "as if …", too small to be certain; empty: none.
    """

    odd: tuple[Mapping[str, None], ...]
    suspected: str


def against_earlier(parts: Sequence[Part], possible: Sequence[Entry]) -> AgainstEarlier:
    """Compares parts with those before them.

    Raises MIL-CONTRADICTED for the first part that lies off what the parts before it and its stated entries predict, as
    an entry would move it: what was in force was something else.
    """
    values, odd, suspected = [part.as_first_set() for part in parts], [dict[str, None]()], ""
    for k in range(1, len(parts)):
        before = after_parts(milled_catalogue(), _sizes_before(parts[:k]), [[observed] for observed in values[:k]])
        part, updated = parts[k], before.state.given(values[k])
        fitting = [
            (slip, seen)
            for slip in _slips(part.in_force, parts[k - 1].in_force)
            if (seen := _seen(part, updated, slip.moved)) is not None
            and (2.0 * seen.share - 1.0) > SUSPECTED * seen.u**2
            and abs(seen.share - 1.0) < FITS + 3.0 * seen.u
            and not _of_one_feature(part, updated, seen, 1.0)
        ]
        found = [(slip, seen) for slip, seen in fitting if (2.0 * seen.share - 1.0) > SLIPPED * seen.u**2]
        if found:
            raise _contradicted(part, _likeliest(found, updated))
        suspected = _as_if(_likeliest(fitting, updated)) if fitting else ""
        for entry in possible:
            own = _seen(part, updated, {entry: 1.0})
            far = own is not None and own.features > 1 and own.share**2 > CONTRADICTED * own.u**2
            if own is not None and far and not _of_one_feature(part, updated, own, own.share):
                raise _contradicted(part, [(_Slip({entry: 1.0}, ""), own)])
        odd.append(odd_features(updated.scales))
    return AgainstEarlier(tuple(odd), suspected)


def _likeliest(found: Sequence[tuple[_Slip, _Seen]], updated: Updated) -> list[tuple[_Slip, _Seen]]:
    """Returns the slips that explain a part about equally well, the likeliest first, by all readings that show any."""
    rows = np.any([seen.rows for _, seen in found], axis=0)
    chi2 = [_chi2(updated, rows, seen.displaced) for _, seen in found]
    order = sorted(range(len(found)), key=chi2.__getitem__)
    return [found[k] for k in order if chi2[k] < chi2[order[0]] + AS_WELL][:MOST_NAMED]


def _of_one_feature(part: Part, updated: Updated, seen: _Seen, share: float) -> bool:
    """Returns whether one feature off by itself explains readings better than a displacement of several."""
    if seen.features == 1:
        return False
    of = [{feature.name for feature in size.features} for size in part.shown]
    names = set().union(*(own for own, shown in zip(of, seen.rows, strict=True) if shown))
    without = [seen.rows & np.array([name not in own for own in of]) for name in names]
    nothing = np.zeros(len(of))
    return min(_chi2(updated, rows, nothing) for rows in without) < _chi2(updated, seen.rows, share * seen.displaced)


def _chi2(updated: Updated, rows: NDArray[np.bool_], displaced: Array) -> float:
    """Returns χ² of what a displacement leaves of the chosen readings."""
    left = updated.innovation.mean_mm[rows] - displaced[rows]
    return float(left @ np.linalg.solve(updated.innovation.covariance_mm2[np.ix_(rows, rows)], left))


def _sizes_before(parts: Sequence[Part]) -> Mapping[str, float]:
    """Returns sizes of the terms by parts cut, the first 3, 6, 12 …, no less than milling's: few scatter by chance."""
    general = milled_catalogue().medians
    if len(parts) < PARTS_FOR_SIZES:
        return general
    count = PARTS_FOR_SIZES * 2 ** int(math.log2(len(parts) / PARTS_FOR_SIZES))
    fitted = fitted_sizes(milled_catalogue(), [part.as_first_set() for part in parts[:count]])
    return {name: max(fitted[name], size) for name, size in general.items()}


def _slips(in_force: Entered, before: Entered) -> Iterator[_Slip]:
    """Yields the slips of single numbers, of all of one kind, and of all numbers."""
    entries = tuple(dict.fromkeys((*in_force, *before)))
    kinds = (("radius",), ("length",), ("x", "y"), ("x", "y", "z"), PLAINEST)
    groups = [(entry,) for entry in entries] + [
        tuple(entry for entry in entries if entry.register in kind) for kind in kinds
    ]
    for group in dict.fromkeys(groups):
        stated = {entry: in_force.get(entry, 0.0) for entry in group}
        change = {entry: value - before.get(entry, 0.0) for entry, value in stated.items()}
        slips = [(-1.0, "had not been entered"), (1.0, "was entered twice"), (-2.0, "had the other sign")]
        if all(entry.register == "radius" for entry in group):
            slips.append((-0.5, "had half of its effect, as in a register that holds diameters"))
        for factor, how in slips:
            yield _Slip({entry: factor * value for entry, value in stated.items()}, how)
            if change != stated:
                last = "was still in force" if factor == -1.0 and not any(stated.values()) else f"{how} the last time"
                yield _Slip({entry: factor * value for entry, value in change.items()}, last)


def _seen(part: Part, updated: Updated, moved: Entered) -> _Seen | None:
    """Returns the share of a displacement that a part shows; None where nothing of the part shows it.

    Features that are far off by themselves have no part in it, unless they are most of those that show it.
    """
    places = part.observed.places
    effect = sum((value * entry.basis(places) for entry, value in moved.items()), np.zeros(len(places)))
    displaced = np.asarray(part.observed.of(effect))
    largest = float(np.max(np.abs(displaced), initial=0.0))
    if largest < LEAST_MM:
        return None
    shows = np.abs(displaced) > SHOWS * largest
    odd = odd_features(updated.scales)
    alike = np.array([all(feature.name not in odd for feature in one.features) for one in part.shown])
    rows = shows & alike if 2 * np.count_nonzero(shows & alike) > np.count_nonzero(shows) else shows
    d = displaced[rows]
    size = float(d @ d)
    u = math.sqrt(float(d @ updated.innovation.covariance_mm2[np.ix_(rows, rows)] @ d)) / size
    features = {feature.name for one, shown in zip(part.shown, rows, strict=True) if shown for feature in one.features}
    return _Seen(float(d @ updated.innovation.mean_mm[rows]) / size, u, len(features), displaced, rows)


def _as_if(slips: Sequence[tuple[_Slip, _Seen]]) -> str:
    """Returns slips in words, as alternatives."""
    named = [" and ".join(entry.words for entry, value in each.moved.items() if value != 0.0) for each, _ in slips]
    return ", or ".join(f"as if {who} {each.words}" for who, (each, _) in zip(named, slips, strict=True))


def _contradicted(part: Part, slips: Sequence[tuple[_Slip, _Seen]]) -> Exception:
    slip, seen = slips[0]
    entries = [one for one, value in slip.moved.items() if value != 0.0]
    entry = max(
        entries,
        key=lambda one: float(np.max(np.abs(part.observed.of(slip.moved[one] * one.basis(part.observed.places))))),
    )
    scale, unit = (1e6, "µrad") if entry.register == "turn" else (UM_PER_MM, "µm")
    off, u = seen.share * slip.moved[entry] * scale, seen.u * abs(slip.moved[entry]) * scale
    how = f", {_as_if(slips)}" if slip.words else ""
    return Code.MIL_CONTRADICTED.refusal(
        wording(
            "part {serial!r} is off by {off:+.0f} {unit} in {entry} from what earlier parts and the numbers stated "
            "as entered predict, with a standard uncertainty of {u:.1f} {unit}{how}",
            serial=part.serial,
            off=off,
            unit=unit,
            entry=entry.words,
            u=u,
            how=how,
        ),
        hint="correct `measured.entered` of that part; where a tool or a work offset was set anew in between, leave "
        "out the parts measured before",
        values={"part": part.serial, "entry": entry.words, "off": off, "u": u},
    )
