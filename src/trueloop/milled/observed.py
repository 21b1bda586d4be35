"""Readings of a milled part as linear functionals of the errors of its surfaces.

The terms of a milled part's error, with the priors of their sizes.

Columns of a place: `part_type`, `part`, `feature`, `tool`, `work_offset`, `side` (of the cut) and `device` (that
measured, empty: none) as labels; `order` (of the part), `depth_share` (of a wall, 0 at its top to 1 at the tip of the
tool), `device_u_mm` (by how much the device may read walls out of place all around), the place and the outward normal
in the part's frame. A coefficient is the error of a thing in its own sense; its basis is what that leaves on: a tool
that is larger by r than the control takes it for leaves −r on every wall, a longer one −l on faces that look up, and a
work offset displaced by d leaves d·n. A device that reads walls further out of the material by b, as by a ball that is
smaller than its calibrated value, shows +b on every wall: bores small and bosses large, as tools that are all smaller
by b leave them.

The medians are from milling in general, chosen before any measured part was looked at.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.errors import Code
from trueloop.estimate.catalogue import Catalogue, Prior, Sizes, Term
from trueloop.estimate.places import Observed, Places
from trueloop.estimate.sizes import FAR
from trueloop.estimate.state import Key
from trueloop.milled.feature import PAIRS, MilledFeature
from trueloop.wording import wording

Features: TypeAlias = Mapping[str, MilledFeature]

AXES: Final = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
COORDINATE: Final = 1e-6
"""Weights of a centre's coordinate add up to no more, those of a size to 1 or 2."""
SAME_DEPTH_MM: Final = 0.5
"""Depths of a wall that differ by less are one."""
EXACT_MM: Final = 3e-4
"""By what rounding to five decimals of an inch makes of a value."""
DIFFERENT_MM: Final = 0.05
"""A nominal value of the file further from the job's is one of another feature, or of another revision."""


@dataclass(frozen=True, eq=False)
class ObservedSize:
    """A size or coordinate of the part: how it follows the errors of `features` at their surfaces.

    `weights` (n,) are those of the points of the features one after the other; `below_top_mm` is the depth of each,
    None: half of its own. `name` identifies it over parts. Limits are absolute, mm; `nominal_mm` is the job's.
    """

    name: str
    features: tuple[MilledFeature, ...]
    below_top_mm: tuple[float | None, ...]
    weights: Array
    nominal_mm: float
    lower_mm: float | None = None
    upper_mm: float | None = None

    @property
    def width(self) -> bool:
        """Returns whether it is the diameter, radius or width of one feature, not a coordinate."""
        return len(self.features) == 1 and abs(float(np.sum(self.weights))) > COORDINATE

    @property
    def aim_mm(self) -> float:
        """Returns the deviation from the nominal that is aimed at: the middle of the limits where both are known."""
        if self.lower_mm is None or self.upper_mm is None:
            return 0.0
        return 0.5 * (self.lower_mm + self.upper_mm) - self.nominal_mm


@dataclass(frozen=True)
class Device:
    """A measuring device; `off_mm`: by how much it is known to read walls further out of the material."""

    name: str
    off_mm: float = 0.0


@dataclass(frozen=True)
class Frame:
    """The features that the frame of the measurement was set by, by name; empty: by something that these cuts do not
    move, as surfaces of an earlier set-up.

    `x`, `y`, `z`: the feature whose coordinate is zero, or nominal, by definition; `turn`: two features whose line has
    the direction that the drawing gives.
    """

    x: str = ""
    y: str = ""
    z: str = ""
    turn: tuple[str, str] | None = None


def seen(features: Features, frame: Frame, reading: Reading) -> ObservedSize | None:
    """Returns what a reading shows; None: no such size or coordinate. Raises MIL-NOMINAL: not the job's nominal."""
    feature, other = features.get(reading.feature), features.get(reading.other)
    if feature is None or (reading.other and other is None):
        return None
    found = _size(feature, reading) if other is None else None
    found = found or _coordinate(features, frame, (feature, other), reading)
    if found is None:
        return None
    if reading.nominal is not None and abs(reading.nominal - found.nominal_mm) > DIFFERENT_MM:
        raise Code.MIL_NOMINAL.refusal(
            wording(
                "{name}: the file's nominal value is {nominal:g} mm, the job's {nominal_mm:g} mm",
                name=found.name,
                nominal=reading.nominal,
                nominal_mm=found.nominal_mm,
            ),
            hint=f"correct the feature {feature.name!r} in the job, or the name that the file gives to it: "
            "the table [names]",
            values={"feature": feature.name, "nominal_mm": reading.nominal, "job_mm": found.nominal_mm},
        )
    return found


def require_not_exchanged(used: Sequence[tuple[Reading, ObservedSize]]) -> None:
    """Raises MIL-NOMINAL where the file's nominal values are not the job's, and all its actual ones are."""
    stated = [(what, reading.nominal) for reading, what in used if reading.nominal is not None]
    other = [(what, nominal) for what, nominal in stated if abs(nominal - what.nominal_mm) > EXACT_MM]
    if len(other) > 1 and all(abs(reading.actual - what.nominal_mm) <= EXACT_MM for reading, what in used):
        what, nominal = other[0]
        raise Code.MIL_NOMINAL.refusal(
            wording(
                "{name}: the file's nominal value is {nominal:g} mm, the job's {nominal_mm:g} mm, as all {n} "
                "actual values are the job's nominal ones",
                name=what.name,
                nominal=nominal,
                nominal_mm=what.nominal_mm,
                n=len(used),
            ),
            hint="are nominal and actual values exchanged? Of a table name the columns: `trueloop measure map FILE "
            "--column nominal=HEADING --column actual=HEADING`",
            values={"feature": what.features[0].name, "nominal_mm": nominal, "job_mm": what.nominal_mm},
        )


def _size(feature: MilledFeature, reading: Reading) -> ObservedSize | None:
    weights = feature.size_weights(reading.quantity)
    another = feature.kind in PAIRS and abs((reading.nominal or feature.size_mm) - feature.size_mm) > DIFFERENT_MM
    if weights is None or another:  # the length of a slot is not its width
        return None
    nominal = feature.size_mm * (0.5 if reading.quantity is Quantity.RADIUS else 1.0)
    name = f"{feature.name}, {'width' if reading.quantity is Quantity.LENGTH else reading.quantity}"
    depth = (_below_top(feature, reading),)
    return ObservedSize(
        name, (feature,), depth, weights, nominal, lower_mm=reading.lower_limit, upper_mm=reading.upper_limit
    )


def _coordinate(
    features: Features, frame: Frame, pair: tuple[MilledFeature, MilledFeature | None], reading: Reading
) -> ObservedSize | None:
    """Returns a coordinate of a feature, or its distance from another one, positive along the way from that."""
    feature, other = pair
    if reading.quantity not in (Quantity.POSITION, Quantity.LENGTH):
        return None
    away = np.array(feature.place_mm) - (0.0 if other is None else np.array(other.place_mm))
    axis = _axis(feature, other, away, reading)
    if axis is None:
        return None
    distance = float(away @ axis)
    if reading.quantity is Quantity.LENGTH and distance < 0.0:
        axis, distance = -axis, -distance
    moved = [(feature, axis)] if other is None else [(feature, axis), (other, -axis)]
    if other is None:
        zeros = zip((frame.x, frame.y, frame.z), np.eye(3), axis, strict=True)
        moved += [(features[name], -share * unit) for name, unit, share in zeros if name and share != 0.0]
    if frame.turn is not None:
        # By how much the coordinate grows with a turn of the part about +z in its frame, mm per rad
        x, y = away[0], away[1]
        if (
            other is None
        ):  # along x a turn counts from the height of the feature that sets x, along y the other way round
            x -= features[frame.y].place_mm[0] if frame.y else 0.0
            y -= features[frame.x].place_mm[1] if frame.x else 0.0
        moved += _turned(features[frame.turn[0]], features[frame.turn[1]], float(axis[1] * x - axis[0] * y))
    weights = [one.coordinate_weights(vector) for one, vector in moved]
    if any(weight is None for weight in weights):
        return None
    letter = next((name for name, unit in AXES.items() if abs(np.dot(unit, axis)) == 1.0), "")
    name = f"{feature.name}, {letter}".rstrip(", ") if other is None else f"{feature.name} from {other.name}"
    if other is not None and reading.axis:
        name = f"{name}, {letter}"
    joined = np.concatenate([weight for weight in weights if weight is not None])
    depth = (_below_top(feature, reading) if other is None else None, *(None,) * (len(moved) - 1))
    of = tuple(one for one, _ in moved)
    return ObservedSize(name, of, depth, joined, distance, lower_mm=reading.lower_limit, upper_mm=reading.upper_limit)


def _turned(first: MilledFeature, second: MilledFeature, lever_mm: float) -> list[tuple[MilledFeature, Array]]:
    """Returns the vectors along which two features turn the frame that is set by them, and with it a coordinate."""
    along = (np.array(second.place_mm) - np.array(first.place_mm)) * [1.0, 1.0, 0.0]
    across = np.array([-along[1], along[0], 0.0]) / float(along @ along)
    return [] if lever_mm == 0.0 else [(second, -lever_mm * across), (first, lever_mm * across)]


def _axis(feature: MilledFeature, other: MilledFeature | None, away: Array, reading: Reading) -> Array | None:
    """Returns the direction of a coordinate: the stated axis, a face's normal, or the line between two centres."""
    if reading.axis:
        return np.array(AXES[reading.axis])
    face = next((one for one in (feature, other) if one is not None and one.kind == "face"), None)
    if face is not None:
        return np.array(face.direction)
    level = away * [1.0, 1.0, 0.0]
    length = float(np.linalg.norm(level))
    return level / length if other is not None and length > 0.0 else None


def _below_top(feature: MilledFeature, reading: Reading) -> float | None:
    """Returns the depth at which a wall was read, where the file states a place within it, or its z alone."""
    if feature.kind == "face" or len(reading.place_mm) not in (1, 3):
        return None
    below = feature.place_mm[2] - reading.place_mm[-1]
    return below if 0.0 < below <= feature.depth_mm else None


def by_depth(shown: Sequence[ObservedSize]) -> tuple[ObservedSize, ...]:
    """Returns sizes and coordinates with their depth in the name where they were read at several of a feature."""
    depths = dict[str, list[float]]()
    for size in shown:
        if size.below_top_mm[0] is not None:
            depths.setdefault(size.name, []).append(size.below_top_mm[0])
    several = {name for name, own in depths.items() if max(own) - min(own) > SAME_DEPTH_MM}
    return tuple(
        replace(size, name=f"{size.name} at {size.below_top_mm[0]:.1f} mm")
        if size.name in several and size.below_top_mm[0] is not None
        else size
        for size in shown
    )


def places_of(
    shown: Sequence[ObservedSize], part_type: str, part: int, devices: Sequence[tuple[str, float]] = ()
) -> tuple[Places, Array]:
    """Returns the places of the surfaces that sizes and coordinates follow, N of them, on the part of that number in
    the order of cutting, and the matrix by which they follow their errors, (n, N).

    `devices`: the device of each, and by how much it may read walls out of place, mm; without, they are true ones.
    """
    rows, columns = list[Array](), list[dict[str, Array]]()
    count = sum(len(size.weights) for size in shown)
    at = 0
    for size, (device, off_mm) in zip(shown, devices or [("", 0.0)] * len(shown), strict=True):
        row = np.zeros(count)
        row[at : at + len(size.weights)] = size.weights
        at += len(size.weights)
        rows.append(row)
        for feature, below in zip(size.features, size.below_top_mm, strict=True):
            own = _columns(feature, below, part_type, part)
            own["device"] = np.full(len(own["part"]), device, dtype=object)
            columns.append({**own, "device_u_mm": np.full(len(own["part"]), off_mm)})
    names = columns[0]
    return Places({name: np.concatenate([column[name] for column in columns]) for name in names}), np.array(rows)


def _columns(feature: MilledFeature, below_top_mm: float | None, part_type: str, part: int) -> dict[str, Array]:
    points, normals = feature.surface(below_top_mm)
    n = len(points)
    share = np.zeros(n) if feature.depth_mm == 0.0 else (feature.place_mm[2] - points[:, 2]) / feature.depth_mm
    labels = {
        "part_type": part_type,
        "feature": feature.name,
        "tool": str(feature.tool),
        "work_offset": feature.work_offset,
        "side": feature.side,
    }
    numbers = {"part": np.full(n, float(part)), "order": np.full(n, float(part)), "depth_share": share}
    for register in ("radius_at_control", "length_at_control"):
        numbers[register] = np.full(n, float(getattr(feature, register)))
    spatial = {name: points[:, k] for k, name in enumerate(("x_mm", "y_mm", "z_mm"))}
    facing = {name: normals[:, k] for k, name in enumerate(("normal_x", "normal_y", "normal_z"))}
    return {**{name: np.full(n, value, dtype=object) for name, value in labels.items()}, **numbers, **spatial, **facing}


def observed_of(
    shown: Sequence[ObservedSize],
    readings: Sequence[Reading],
    of: tuple[str, int],
    u_mm: float,
    devices: Sequence[Device] = (),
) -> Observed:
    """Returns readings as observations of the part `of` (type, number): deviations from the job's nominal values, each
    with the standard uncertainty that the file states, else `u_mm`, less what its device is known to add.
    """
    u = np.array([u_mm if reading.standard_u is None else reading.standard_u for reading in readings])
    devices = devices or [Device("")] * len(readings)
    common = [(device.name, IN_COMMON * own) for device, own in zip(devices, u.tolist(), strict=True)]
    places, functional = places_of(shown, *of, common)
    value = np.array([reading.actual - what.nominal_mm for reading, what in zip(readings, shown, strict=True)])
    value -= np.array([device.off_mm for device in devices]) * (functional @ wall_share(places))
    return Observed(places, value, u, functional)


def with_device_off(observed: Observed, off: Collection[str]) -> Observed:
    """Returns observations of which some devices, by name, may be off as one that was not calibrated."""
    places = observed.places
    mine = np.isin(places.columns["device"].astype(str), list(off))
    wide = np.where(mine, UNCALIBRATED_MM, places.number("device_u_mm"))
    return replace(observed, places=Places({**places.columns, "device_u_mm": wide}))


_PRESET: Final = "a presetter or a touch-off, with run-out: a hundredth of a millimetre in radius, more in length"
_ZERO: Final = "a work offset is probed or edged to one or two hundredths of a millimetre, 0.1 mm over 500 mm"
_PUSHED: Final = "an end mill bends by some micrometres at its tip, away from the wall or into it"
_MACHINE: Final = "positions and circles of a machining centre: some micrometres (ISO 230-4, ISO 10791-7)"
_AGAIN: Final = "a part clamped again, minutes of heat: some micrometres"
IN_COMMON: Final = 0.5
"""Walls read by a device are out of place alike by this share of a value's uncertainty: on a diameter by as much."""
UNCALIBRATED_MM: Final = 0.02
"""A stylus that was changed and not calibrated: hundredths of a millimetre of ball and of travel before it triggers."""
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
"""Degrees of freedom of what a person sets and of a feature's own error: a wrong value typed for a new tool, a chip in
a bore. Both have tails: of a large deviation the likelier one is the cause, and no part of it the other.
"""


@cache
def milled_catalogue() -> Catalogue:
    """Returns the terms; one catalogue for all parts."""
    terms = (
        Term("tool radius", ("tool",), _wall, _flat("radius"), step=_flat("wear"), tail=TAIL),
        Term("tool length", ("tool",), _up, _flat("length"), step=_flat("wear"), tail=TAIL),
        Term("work offset", ("work_offset",), shift_basis, _flat("zero", 3), tail=TAIL),
        Term("turn of the work offset", ("work_offset",), turn_basis, _flat("turned"), tail=TAIL),
        Term("tool pushed away", ("tool", "side"), _deep, _flat("pushed")),
        Term("size", ("part_type", "feature"), _constant, _flat("size"), tail=TAIL),
        Term("place", ("part_type", "feature"), shift_basis, _flat("place", 3), tail=TAIL),
        Term("clamping", ("part",), shift_basis, _flat("clamping", 3)),
        Term("turn of the clamping", ("part",), turn_basis, _flat("clamping_turn")),
        Term("size on the part", ("part", "feature"), _constant, _flat("size_part"), tail=TAIL),
        Term("place on the part", ("part", "feature"), shift_basis, _flat("place_part", 3), tail=TAIL),
        Term("device", ("device",), _read_off, lambda _: np.ones(1)),
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


def odd_features(scales: Mapping[Key, float]) -> dict[str, None]:
    """Returns the features that are far off by themselves, by the scales of their own terms' variances."""
    own = {term.name for term in milled_catalogue().terms if "feature" in term.scope}
    return dict.fromkeys(key[-1] for key, scale in scales.items() if key[0] in own and scale >= FAR)


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


def with_scales(sizes: Sizes) -> dict[str, float]:
    """Returns sizes with scales of Student's distribution, √((ν − 2)/ν) times the standard deviation, of what each
    feature of each part is off by: so the next part, which nothing has shown yet, scatters as those before it did.
    """
    scale = math.sqrt((TAIL - 2.0) / TAIL)
    return {**sizes, **{name: scale * sizes[name] for name in ("size_part", "place_part")}}


def _wall(places: Places) -> Array:
    return -wall_share(places)[:, None]


def _up(places: Places) -> Array:
    return -places.number("normal_z")[:, None]


def _deep(places: Places) -> Array:
    return np.asarray(wall_share(places) * places.number("depth_share"))[:, None]


def _constant(places: Places) -> Array:
    return np.ones((len(places), 1))


def _read_off(places: Places) -> Array:
    return np.asarray(wall_share(places) * places.number("device_u_mm"))[:, None]


def _repeatability_mm2(places: Places, sizes: Sizes) -> Array:
    return np.full(len(places), sizes["repeatability"] ** 2)
