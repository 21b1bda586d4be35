"""A simulated series as diagnoses take it: feature errors of each part by who saw them, points, machine residuals."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

import numpy as np

from studies.diagnosed.axis_errors import CHUCK_MM
from studies.diagnosed.plain_errors import plain_errors
from studies.diagnosed.shop import Made, Series, tool_of_points_mm
from trueloop.arrays import Array, Integers, by_content
from trueloop.diagnosis.causes.cause import SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError, SeenPoints

BEGIN: Final = datetime(2026, 3, 2, 6, 0)
ErrorsOf = Callable[[Series, Array, float], tuple[FeatureError, ...]]


@by_content
@dataclass(frozen=True)
class MachineSeen:
    """What the machine's model left at n points: CMM less machine along the outward normals.

    `part` (n,) numbers parts, `normal` (n, 3), `positions` (n, 2) of cross slide and carriage, `tool_mm` (n, 3) from
    the turret to the tool point, `signals` by name (n,), all X Y Z in work coordinates, whose origin is where the
    spindle tilts.
    """

    part: Integers
    normal: Array
    positions: Array
    tool_mm: Array
    signals: Mapping[str, Array]
    residual_mm: Array


def plain(series: Series, error_mm: Array, standard_u_mm: float) -> tuple[FeatureError, ...]:
    """Feature errors as plain means and differences."""
    return plain_errors(series.places, series.points, error_mm, standard_u_mm)


def seen_series(series: Series, errors_of: ErrorsOf = plain) -> SeenSeries:
    """What diagnoses get: nothing of the truth."""
    return SeenSeries(series.places, tuple(_part(series, one, k, errors_of) for k, one in enumerate(series.made)))


def points_of(series: Series, error_mm: Array, standard_u_mm: float) -> SeenPoints:
    """Errors at the gauging points of a series with names, normals and angles."""
    points, count = series.points, series.points.count
    u, once = np.full(count, standard_u_mm), np.ones(count, dtype=np.int64)
    return SeenPoints(points.feature, points.at_mm, points.normal, error_mm, u, points.angle_rad, once)


def seen_points(series: Series, made: Made, by: SeenBy) -> SeenPoints:
    """The points of one part as a device read them."""
    return points_of(series, made.read_mm[by], _standard_u_mm(series, by))


def machine_seen(series: Series) -> MachineSeen:
    """Points on the side where the tool cuts, of all parts that both devices saw."""
    rows = series.points.angle_rad == 0.0
    at, normal = series.points.at_mm[rows], series.points.normal[rows]
    tool = tool_of_points_mm(series.places, series.points)[rows]
    made = [one for one in series.made if not one.standard]
    work = at + np.array([0.0, CHUCK_MM])
    return MachineSeen(
        np.repeat(np.arange(len(made)), len(at)),
        np.tile(_in_space(normal), (len(made), 1)),
        np.tile(work - tool, (len(made), 1)),
        np.tile(_in_space(tool), (len(made), 1)),
        {
            name: np.repeat([one.moment.read_c[name] for one in made], len(at))
            for name in (made[0].moment.read_c if made else ())
        },
        np.concatenate([(one.read_mm[SeenBy.CMM] - one.read_mm[SeenBy.MACHINE])[rows] for one in made]),
    )


def together(seen: list[MachineSeen]) -> MachineSeen:
    """Several series as one, the parts numbered on."""
    first = np.cumsum([0, *[int(one.part.max()) + 1 for one in seen]])
    return MachineSeen(
        np.concatenate([one.part + begin for one, begin in zip(seen, first[:-1], strict=True)]),
        np.concatenate([one.normal for one in seen]),
        np.concatenate([one.positions for one in seen]),
        np.concatenate([one.tool_mm for one in seen]),
        {name: np.concatenate([one.signals[name] for one in seen]) for name in seen[0].signals},
        np.concatenate([one.residual_mm for one in seen]),
    )


def _in_space(flat: Array) -> Array:
    return np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]])


def _standard_u_mm(series: Series, by: SeenBy) -> float:
    return series.shop.probe_mm if by is SeenBy.MACHINE else series.shop.cmm_mm


def _part(series: Series, made: Made, order: int, errors_of: ErrorsOf) -> SeenPart:
    errors = {by: errors_of(series, read, _standard_u_mm(series, by)) for by, read in made.read_mm.items()}
    seen = {by: seen_points(series, made, by) for by in made.read_mm}
    cut, at = made.cut, BEGIN + timedelta(minutes=made.moment.minutes)
    return SeenPart(
        f"S{order + 1:03d}", order, errors, seen, at, dict(cut.setting), dict(cut.minutes), dict(cut.depth_mm),
        dict(made.moment.read_c), _recorded(made, errors), made.standard,
    )  # fmt: skip


def _recorded(made: Made, errors: Mapping[SeenBy, tuple[FeatureError, ...]]) -> dict[tuple[str, str], float]:
    """A correction that shifts a feature changes its radius, and lengths to it and from it."""
    found, taken = {}, made.corrected_mm
    for one in [error for seen in errors.values() for error in seen] if taken else []:
        if one.kind is ErrorKind.RADIUS:
            found[(one.feature, str(one.kind))] = taken[one.feature]
        elif one.kind is ErrorKind.LENGTH:
            found[(one.feature, str(one.kind))] = taken[one.feature] - taken[one.other]
    return found
