"""Causes as data: how one shows on features, to whom, and from part to part; its remedy [4773 §4.2, Fig. 11].

Errors at all points of a series, as places of the estimate: what hypotheses of causes have to explain.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array, Integers, by_content
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, FeaturePlace, SeenPoints
from trueloop.errors import Finding
from trueloop.estimate.places import Places, joined


class SeenBy(StrEnum):
    """The device of an error: the machine's probe sees the process alone, a measuring machine all of it."""

    MACHINE = "machine"
    CMM = "CMM"


@dataclass(frozen=True)
class SeenPart:
    """One part, `order` among the parts as they were cut.

    `points` and the `errors` of features from them, by who saw them. `setting` counts settings of each tool by its
    name: it rises where the tool was set anew. `minutes_in_cut` of each tool's edge, `depth_of_cut_mm` on the radius by
    feature; what is not known is missing. `temperatures` are those while it was cut. `correction_mm` is what
    corrections of sizes took off a feature's error, by (feature, kind), as recorded; `taken_off_mm` what the program
    that ran took off at the points of each device, (n,), `carried_mm` the error of the machine that its model tells of
    the cut, which the surface carries there. `standard`: a calibrated part, on which nothing was cut; its errors are
    actual less calibrated.
    """

    serial: str
    order: int
    errors: Mapping[SeenBy, tuple[FeatureError, ...]]
    points: Mapping[SeenBy, SeenPoints] = field(default_factory=dict)
    at: datetime | None = None
    setting: Mapping[str, int] = field(default_factory=dict)
    minutes_in_cut: Mapping[str, float] = field(default_factory=dict)
    depth_of_cut_mm: Mapping[str, float] = field(default_factory=dict)
    temperatures: Mapping[str, float] = field(default_factory=dict)
    correction_mm: Mapping[tuple[str, str], float] = field(default_factory=dict)
    standard: bool = False
    taken_off_mm: Mapping[SeenBy, Array] = field(default_factory=dict)
    carried_mm: Mapping[SeenBy, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class SeenSeries:
    """Parts of one type in cutting order, and where their features are."""

    features: Mapping[str, FeaturePlace]
    parts: tuple[SeenPart, ...]


class Over(StrEnum):
    """How a cause goes over the parts of a series."""

    CONSTANT = "constant"  # the same on all parts
    SETTING = "setting"  # the same until the tool is set anew
    WEAR = "wear"  # grows with the minutes that the edge has cut
    TEMPERATURE = "temperature"  # follows a temperature
    DEPTH = "depth"  # in proportion to the depth of cut
    SCATTER = "scatter"  # another value on every part
    STEP = "step"  # another value from some part on, though nothing was set


@dataclass(frozen=True)
class Sign:
    """How a cause shows: on one kind of error, to whom, over the parts.

    `alike`: all features of a tool have one size, else each its own. `needed`: the cause always shows so, else it may.
    """

    kind: ErrorKind
    seen_by: tuple[SeenBy, ...]
    over: tuple[Over, ...]
    alike: bool = False
    needed: bool = True


@dataclass(frozen=True)
class Cause:
    """One cause. `key` is a name without spaces, `name` that for people; `prior` its share beforehand.

    `remedy` says what to do, `section` where the source says it, `decided_by` which measurement would tell it from
    others. `on_standard_part`: a calibrated part shows it too, on which nothing was cut. `of_tool`: it is one tool's,
    so that each tool is asked for.
    """

    key: str
    name: str
    signs: tuple[Sign, ...]
    prior: float
    remedy: str
    section: str
    decided_by: str
    on_standard_part: bool = False
    of_tool: bool = False


@dataclass(frozen=True)
class Candidate:
    """One cause on some features: `probability` that it acts, `size_mm` ± `standard_u_mm` if it does.

    `supports` and `contradicts` are evidence in words. `tool` is the one that it concerns, where it is one tool's. The
    size is what it leaves on the feature and the part that show it most, as an error there.
    """

    cause: Cause
    features: tuple[str, ...]
    probability: float
    size_mm: float
    standard_u_mm: float
    supports: tuple[str, ...] = ()
    contradicts: tuple[str, ...] = ()
    tool: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """The causes of a series: candidates, likeliest first; `sound` is the probability that nothing acts.

    `hypotheses` are sets of causes by their keys with probabilities; () is none. `decide` says in words which
    measurement would tell apart what is left.
    """

    candidates: tuple[Candidate, ...]
    hypotheses: tuple[tuple[tuple[str, ...], float], ...]
    sound: float
    decide: tuple[str, ...] = ()
    gain: float = 1.0
    findings: tuple[Finding, ...] = ()


FLOOR_MM: Final = 0.0003
"""By what devices differ beyond their stated uncertainties: frames, dirt."""
REFERENCE_C: Final = 20.0
"""Standard conditions [ISO 1]: there the machine's model is what it was identified at."""
DECIMALS: Final = 4
"""Nominal places (mm) and angles (rad) that agree so far are one place of the part."""


@by_content
@dataclass(frozen=True)
class SurfaceErrors:
    """n errors along the outward normal, positive where material was left on: of the process and of what a model of the
    machine does not tell.

    `places` has the columns part (number in the series), device, feature, tool, setting (labels), at (number of the
    place on the part, the same for both devices), x_mm, z_mm (from the middle of the part), normal_x, normal_z, share
    (along the feature, −1 to 1), reach (0 at the chuck to 1 at the free end), spindle_rad (NaN: not known), minutes (in
    cut), depth_mm (1 where not recorded), face and cut (0 or 1; a standard part was not cut), and a column for each
    temperature, in K above 20 °C. `corrected_mm` (n,) is what recorded corrections took off, `carried_mm` (n,)
    what the model tells of the machine in the cut: measured was `value_mm` + `carried_mm`.
    """

    places: Places
    value_mm: Array
    standard_u_mm: Array
    corrected_mm: Array
    carried_mm: Array
    signals: tuple[str, ...]
    depths_known: bool

    def __len__(self) -> int:
        return len(self.value_mm)

    def parts(self) -> list[Integers]:
        """Rows of each part."""
        of = self.places.number("part")
        return [np.flatnonzero(of == part) for part in np.unique(of)]


def surface_errors(series: SeenSeries) -> SurfaceErrors | None:
    """All points of the series; None where it has none."""
    signals = tuple(sorted({name for part in series.parts for name in part.temperatures}))
    known = any(part.depth_of_cut_mm for part in series.parts)
    at: dict[tuple[object, ...], int] = {}
    found = []
    for number, part in enumerate(series.parts):
        for seen_by, points in part.points.items():
            if len(points.feature):
                found.append(_of_points(series, number, seen_by, points, signals, at))
    if not found:
        return None
    places, values, u, corrected, carried = zip(*found, strict=True)
    return SurfaceErrors(
        places=joined(places),
        value_mm=np.concatenate(values),
        standard_u_mm=np.concatenate(u),
        corrected_mm=np.concatenate(corrected),
        carried_mm=np.concatenate(carried),
        signals=signals,
        depths_known=known,
    )


def tool_of(feature: str, part: SeenPart, places: Mapping[str, FeaturePlace]) -> str:
    """The tool that finished a feature: as its place has it, else the one tool that the part's cut names, else ""."""
    place = places.get(feature)
    if place is not None and place.tool:
        return place.tool
    named = {*part.setting, *part.minutes_in_cut}
    return next(iter(named)) if len(named) == 1 else ""


def minutes_in_cut(number: int, tool: str, series: SeenSeries) -> float:
    """Age of the tool's edge when the part was cut; where it is not known, the number of parts since the tool was set,
    counted from their middle.
    """
    part = series.parts[number]
    if tool in part.minutes_in_cut:
        return part.minutes_in_cut[tool]
    same = [
        seen_part
        for seen_part in series.parts[: number + 1]
        if not seen_part.standard and seen_part.setting.get(tool) == part.setting.get(tool)
    ]
    return max(len(same) - 0.5, 0.0)


def _of_points(
    series: SeenSeries,
    number: int,
    seen_by: SeenBy,
    points: SeenPoints,
    signals: tuple[str, ...],
    at: dict[tuple[object, ...], int],
) -> tuple[Places, Array, Array, Array, Array]:
    part, n = series.parts[number], len(points.feature)
    low, high = _ends(series.features)
    x, z = points.nominal_mm.T
    where = [series.features.get(name) for name in points.feature]
    tools = {name: tool_of(name, part, series.features) for name in set(points.feature)}
    minutes = {tool: minutes_in_cut(number, tool, series) for tool in set(tools.values())}
    angle = np.where(np.isnan(points.spindle_rad), -1.0, np.mod(points.spindle_rad, 2.0 * np.pi))
    keys = zip(points.feature, *(np.round(one, DECIMALS).tolist() for one in (x, z, angle)), strict=True)
    columns: dict[str, Any] = {
        "part": np.full(n, number),
        "device": np.full(n, seen_by.value, dtype=object),
        "feature": np.array(points.feature, dtype=object),
        "tool": np.array([tools[name] for name in points.feature], dtype=object),
        "setting": np.array([part.setting.get(tools[name], 0) for name in points.feature]),
        "at": np.array([at.setdefault(key, len(at)) for key in keys]),
        "x_mm": x,
        "z_mm": z - 0.5 * (low + high),
        "normal_x": points.normal[:, 0],
        "normal_z": points.normal[:, 1],
        "share": np.array([_share(place, p, q) for place, p, q in zip(where, x, z, strict=True)]),
        "reach": (z - low) / (high - low) if high > low else np.zeros(n),
        "spindle_rad": points.spindle_rad,
        "minutes": np.array([minutes[tools[name]] for name in points.feature]),
        "depth_mm": np.array([part.depth_of_cut_mm.get(name, 1.0) for name in points.feature]),
        "face": np.array([float(place is not None and place.kind == "face") for place in where]),
        "cut": np.full(n, float(not part.standard)),
    }
    for name in signals:
        columns[name] = np.full(n, part.temperatures.get(name, REFERENCE_C) - REFERENCE_C)
    taken, carried = np.zeros(n), part.carried_mm.get(seen_by, np.zeros(n))
    if not part.standard:
        taken = _corrected(part, points, columns["share"], series.features) + part.taken_off_mm.get(seen_by, 0.0)
    return Places(columns), points.error_mm - carried, np.hypot(points.standard_u_mm, FLOOR_MM), taken, carried


def _ends(places: Mapping[str, FeaturePlace]) -> tuple[float, float]:
    z = [end for place in places.values() for end in place.z_mm]
    return (min(z), max(z)) if z else (0.0, 0.0)


def _share(place: FeaturePlace | None, x: float, z: float) -> float:
    """From −1 to 1: along z of a shaft, along the radius of a face."""
    if place is None:
        return 0.0
    (low, high), value = (place.radius_mm, x) if place.kind == "face" else (place.z_mm, z)
    return float(np.clip((2.0 * value - low - high) / (high - low), -1.0, 1.0)) if high > low else 0.0


def _corrected(part: SeenPart, points: SeenPoints, share: Array, places: Mapping[str, FeaturePlace]) -> Array:
    """Returns the amount that corrections took off at points, from that taken off radii, tapers and lengths."""
    taken, along_z = part.correction_mm, 0.0
    if not taken:
        return np.zeros(len(points.feature))
    radius, length = str(ErrorKind.RADIUS), str(ErrorKind.LENGTH)
    of_face: dict[str, float] = {}
    for name in sorted((n for n, place in places.items() if place.kind == "face"), key=lambda n: sum(places[n].z_mm)):
        along_z += taken.get((name, length), 0.0)
        of_face[name] = along_z
    found = np.zeros(len(points.feature))
    for k, name in enumerate(points.feature):
        if name in of_face and (name, radius) not in taken:
            found[k] = points.normal[k, 1] * of_face[name]
            continue
        taper = taken.get((name, str(ErrorKind.SHAFT_TAPER)), 0.0)
        found[k] = taken.get((name, radius), 0.0) + 0.5 * (share[k] + 1.0) * taper
    return found
