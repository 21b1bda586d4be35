"""One run of a DMIS file as readings and points, each deviation and verdict compared with what the file says."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Final, Literal

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import CmmPoint, Reading, Vector
from trueloop.formats.inspections.dmis.features import POINTS, Feature, Side
from trueloop.formats.inspections.dmis.runs import (
    AXES,
    BETWEEN,
    DISTANCES,
    PROFILES,
    QUANTITIES,
    STATED,
    ZONES,
    Actual,
    Notes,
    Result,
    Run,
    RunResult,
    Tolerance,
)
from trueloop.formats.inspections.dmis.words import key_of

Axis = Literal["", "x", "y", "z"]
LETTERS: Final[tuple[Axis, ...]] = ("x", "y", "z")
AXIS_WORDS: Final = ("XAXIS", "YAXIS", "ZAXIS")
SIZES: Final = ("DIAM", "RAD", "LENGTH", "WIDTH")
EXACT_MM: Final = 0.005
"""Numbers written in coarser steps than this are taken as exact: 30.0 of a drawing is not a rounded 30.04."""
LEAST_MM: Final = 1e-9


@dataclass
class Values:
    """The values of a run as they are made; `written` says how the labels of features are written."""

    run: Run
    notes: Notes
    written: Mapping[str, str]
    made: list[Reading | CmmPoint] = field(default_factory=list)
    repeats: Counter[tuple[str, str]] = field(default_factory=Counter)
    compared: Counter[tuple[str, str]] = field(default_factory=Counter)
    taken: dict[tuple[str, str], list[tuple[int, Actual]]] = field(default_factory=dict)


def values_of(run: Run, notes: Notes, written: Mapping[str, str]) -> tuple[Reading | CmmPoint, ...]:
    """Returns the values measured in a run, in its order; contradictions are remarked."""
    values = Values(run, notes, written)
    latest: dict[str, Actual] = {}
    for actual in run.actuals:
        latest[key_of(actual.feature.label)] = actual
        _measured(values, actual)
    for found in run.found:
        _found(values, found, latest)
    for name, place, normal in run.loose:
        values.made.append(CmmPoint(place, None, normal, _label(values, name)))
    return tuple(values.made)


def size_of(feature: Feature | None, what: str) -> float | None:
    """Returns a diameter, radius, width or coordinate of a feature by its tolerance's DMIS word; None: not stated."""
    if feature is None:
        return None
    if what in AXES:
        return feature.place_mm[AXES[what]]
    sizes = feature.sizes
    if what == "DIAM" and what not in sizes and "RAD" in sizes:
        return 2.0 * sizes["RAD"]
    if what == "RAD" and what not in sizes and "DIAM" in sizes:
        return sizes["DIAM"] / 2.0
    return sizes.get(what)


def _measured(values: Values, actual: Actual) -> None:
    """A point as a point, any other feature by its sizes and by its coordinates."""
    feature = actual.feature
    nominal = actual.nominal or values.run.nominals.get(key_of(feature.label))
    if nominal is None:
        values.notes.count("a measured feature has no nominal one", feature.line)
    elif nominal.kind != feature.kind:
        values.notes.say(
            f"FA({feature.label}) is a {feature.kind}, F({nominal.label}) of line {nominal.line} a {nominal.kind}",
            feature.line,
        )
        nominal = None
    actual = replace(actual, nominal=nominal)
    if feature.kind in POINTS and feature.point_mm is not None:
        values.made.append(_point(feature, nominal))
        return
    if feature.kind == "CONE":
        values.notes.count(
            "the angle of a CONE is not read: files do not say whether it is the included one", feature.line
        )
    stated = [what for what in SIZES if what in feature.sizes] + [AXIS_WORDS[axis] for axis in feature.known_axes]
    if not stated:
        values.notes.count(f"FA(…)=FEAT/{feature.kind} without a value", feature.line)
    for what in stated:
        _reading(values, actual, what)


def _point(feature: Feature, nominal: Feature | None) -> CmmPoint:
    place = feature.point_mm
    assert place is not None
    normal = feature.direction if nominal is None or nominal.direction is None else nominal.direction
    return CmmPoint(place, None if nominal is None else nominal.point_mm, normal, feature.label)


def _reading(values: Values, actual: Actual, what: str) -> None:
    feature = actual.feature
    key = key_of(feature.label)
    limits = actual.limits.get(what) or values.run.tolerances.get(key, {}).get(what)
    nominal = size_of(actual.nominal, what)
    value = size_of(feature, what)
    assert value is not None
    name = limits.label if limits is not None else f"{feature.label} {what}"
    values.taken.setdefault((key, what), []).append((len(values.made), actual))
    source = Source(feature.label, "", actual, actual.moment, feature.line)
    _add(values, source, what, name, value, nominal, limits)


@dataclass(frozen=True, slots=True)
class Source:
    """The source of a value: its features by their labels, and the actual one where that is stated, its time and line.

    `other` is the feature from which a distance counts.
    """

    feature: str
    other: str
    actual: Actual | None
    moment: datetime | None
    line: int


def _add(
    values: Values, source: Source, what: str, name: str, value: float, nominal: float | None, limits: Tolerance | None
) -> None:
    lower, upper = (None, None) if limits is None else limits.limits(nominal)
    repeated = key_of(source.feature), name
    values.repeats[repeated] += 1
    values.made.append(
        Reading(
            characteristic=name,
            quantity=QUANTITIES.get(what) or STATED[what],
            actual=value,
            nominal=nominal,
            lower_limit=lower,
            upper_limit=upper,
            feature=source.feature,
            other=source.other,
            axis=LETTERS[AXES[what]] if what in AXES else "",
            place_mm=_place(source.actual),
            repeat=values.repeats[repeated],
            measured_at=source.moment if source.moment != values.run.heading.moment else None,
            line=source.line,
            side=_side(source.actual),
        )
    )


def _side(actual: Actual | None) -> Side:
    """Of a hole or a shaft; a result may leave out what the nominal feature states."""
    if actual is None:
        return ""
    return actual.feature.side or (actual.nominal.side if actual.nominal is not None else "")


def _place(actual: Actual | None) -> Vector | tuple[()]:
    """The nominal place where it is known: where a characteristic is meant to hold."""
    if actual is None:
        return ()
    nominal = None if actual.nominal is None else actual.nominal.point_mm
    return nominal or actual.feature.point_mm or ()


def _found(values: Values, run_result: RunResult, latest: dict[str, Actual]) -> None:
    """A result: of what the features state too it is compared, anything else becomes a reading."""
    result = run_result.result
    feature = run_result.features[0] if run_result.features else ""
    limits = run_result.labelled or values.run.by_label.get(key_of(result.label))
    if limits is None or limits.what != result.what:
        limits = values.run.tolerances.get(feature, {}).get(result.what)
    taken = values.taken.get((feature, result.what))
    if taken:
        index, actual = taken[min(len(taken) - 1, values.compared[feature, result.what])]  # the second to the second
        values.compared[feature, result.what] += 1
        reading = values.made[index]
        assert isinstance(reading, Reading)
        _compare(values, result, reading.actual, reading.nominal, limits, _step(actual))
        return
    _stated(values, run_result, latest.get(feature), limits)


def _stated(values: Values, run_result: RunResult, actual: Actual | None, limits: Tolerance | None) -> None:
    """A reading of what the result alone states, or of a point along its normal or an axis."""
    result = run_result.result
    feature, other = (*run_result.features[:2], "", "")[:2]
    source = Source(
        actual.feature.label if actual is not None else _label(values, feature),
        _label(values, other) if result.what in BETWEEN else "",
        actual,
        run_result.moment,
        result.line,
    )
    given = None if actual is None else _by_geometry(actual, result.what)
    for which, stated in zip(_which(result), result.values, strict=False):
        nominal = _nominal(values, run_result, limits) if given is None else given[1]
        value = _as_value(values, result, stated, nominal)
        if given is not None and actual is not None:
            _compare(values, result, given[0], given[1], limits, _step(actual))
            close = abs((given[0] - (given[1] or 0.0)) - stated) <= _step(actual) + result.decimals_mm
            value = value if close else given[0]
        if given is None:
            _judge(values, result, value, nominal, limits)
        name = (result.label if limits is None else limits.label) + which
        _add(values, source, result.what, name, value, nominal, limits)


def _label(values: Values, key: str) -> str:
    """A feature's label as the file writes it where it has one."""
    feature = values.run.nominals.get(key)
    return values.written.get(key, key) if feature is None else feature.label


def _which(result: Result) -> tuple[str, ...]:
    """Returns the suffix of a characteristic's name: a profile may be stated by its least and its greatest
    deviation.
    """
    if result.what in PROFILES and len(result.values) > 1:
        return " least", " greatest"
    return ("",)


def _nominal(values: Values, result: RunResult, limits: Tolerance | None) -> float | None:
    if result.result.what in ZONES or result.result.what in PROFILES:
        return 0.0
    if limits is not None and limits.nominal is not None:
        return limits.nominal
    return size_of(values.run.nominals.get(result.features[0] if result.features else ""), result.result.what)


def _by_geometry(actual: Actual, what: str) -> tuple[float, float | None] | None:
    """Value and nominal from the features themselves: a point's deviation along its normal, or a coordinate.

    A profile's deviation is n · (actual − nominal), positive outside of the material.
    """
    feature, nominal = actual.feature, actual.nominal
    if what in PROFILES:
        point, aim = feature.point_mm, None if nominal is None else nominal.point_mm
        if feature.kind not in POINTS or nominal is None or nominal.direction is None or point is None or aim is None:
            return None
        return math.fsum(n * (p - q) for n, p, q in zip(nominal.direction, point, aim, strict=True)), 0.0
    value = size_of(feature, what)
    return None if value is None else (value, size_of(nominal, what))


def _step(actual: Actual) -> float:
    """By how much a deviation may differ because the numbers of the features are rounded."""
    nominal_mm = 0.0 if actual.nominal is None else actual.nominal.decimals_mm
    return actual.feature.decimals_mm + (nominal_mm if nominal_mm < EXACT_MM else 0.0)


def _as_value(values: Values, result: Result, stated: float, nominal: float | None) -> float:
    """A stated number as the value: files state the deviation, some the value itself: then it is nearer to nominal."""
    if result.what in STATED or result.what in ZONES or result.what in PROFILES or nominal is None:
        if nominal is None and result.what not in (*ZONES, *PROFILES, *STATED):
            values.notes.count(f"the nominal of TA(…)=TOL/{result.what} is not known: taken as it stands", result.line)
        return stated
    if abs(stated) <= abs(stated - nominal):
        return nominal + stated
    return stated


def _compare(
    values: Values, result: Result, value: float, nominal: float | None, limits: Tolerance | None, step_mm: float
) -> None:
    """Compares a result with its features: the deviation, or the value itself, and the verdict."""
    close = step_mm + result.decimals_mm + LEAST_MM
    deviation = None if nominal is None else value - nominal
    stated = result.values[0]
    accepted = [value] if deviation is None else [deviation, value]
    if result.what in PROFILES and len(result.values) > 1:
        accepted = [stated]  # a range: the deviation of a single point need be neither end
    if min(abs(stated - one) for one in accepted) > close:
        reverse = deviation is not None and abs(stated + deviation) <= close
        sign = ", with the opposite sign" if reverse else ""
        of = "the value" if deviation is None else "a deviation"
        values.notes.say(
            f"TA({result.label}) states {stated:.6g} mm{sign}; the features make {of} of "
            f"{accepted[0]:.6g} mm, which is taken",
            result.line,
        )
    _judge(values, result, value, nominal, limits, step_mm)


def _judge(
    values: Values, result: Result, value: float, nominal: float | None, limits: Tolerance | None, step_mm: float = 0.0
) -> None:
    lower, upper = (None, None) if limits is None else limits.limits(nominal)
    if not result.verdict or (lower is None and upper is None):
        return
    beyond = max(-math.inf if lower is None else lower - value, -math.inf if upper is None else value - upper)
    if (beyond > 0.0) != (result.verdict == "out") and abs(beyond) > step_mm + result.decimals_mm + LEAST_MM:
        side = "outside" if beyond > 0.0 else "inside"
        values.notes.say(
            f"TA({result.label}) says {'INTOL' if result.verdict == 'in' else 'OUTOL'}; {value:.6g} mm is "
            f"{abs(beyond):.6g} mm {side} the limits",
            result.line,
        )


def characteristics_of(run: Run) -> Iterator[Characteristic]:
    """Yields the characteristics of a run, measured or not, of the features whose nominal value it states."""
    each = [(feature, *pair) for feature, tolerances in run.tolerances.items() for pair in tolerances.items()]
    for feature, what, limits in each:
        nominal = limits.nominal if limits.nominal is not None else size_of(run.nominals.get(feature), what)
        if nominal is None or what in DISTANCES:
            continue
        label = run.nominals[feature].label if feature in run.nominals else feature
        lower, upper = limits.limits(nominal)
        yield Characteristic(
            name=limits.label,
            quantity=QUANTITIES.get(what) or STATED[what],
            feature=label,
            nominal=nominal,
            lower_limit=lower,
            upper_limit=upper,
        )


def quantity_is_size(quantity: Quantity) -> bool:
    """Returns whether a value of exactly the nominal size is noteworthy."""
    return quantity in (Quantity.DIAMETER, Quantity.RADIUS)
