"""The readings of a table: its values with their nominals, limits, places and times."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import Reading
from trueloop.formats.inspections.measured_file import MeasuredFile, Remark, Unit
from trueloop.formats.inspections.shared.checks import filled_in, numbered, stated_deviations, stated_verdicts
from trueloop.formats.inspections.shared.quantities import AXES, characteristics_of
from trueloop.formats.inspections.tables.common import Common
from trueloop.formats.inspections.tables.long import Long
from trueloop.formats.inspections.tables.roles import POINT, Role
from trueloop.formats.inspections.tables.sizes import Sizes, sizes_of
from trueloop.formats.inspections.tables.values import lengths_of, numbers_of


def with_readings(common: Common, unit: Unit | None, sha256: str, said: Sequence[Remark]) -> MeasuredFile:
    """Returns a table's inspections of readings. Raises MSR-UNIT, MSR-NUMBER, MSR-EXCHANGED, MSR-TIME, MSR-MEANING."""
    long, mapping = common.long, common.mapping
    sizes = sizes_of(long, mapping, unit)
    readings = list(_readings(common, sizes))
    stands = ~np.isnan(sizes.actual)
    remarks = [*said, *sizes.remarks, *_left_out(long, stands)]
    remarks += _compared(sizes, readings, stands)
    inspections = []
    for key, rows in common.groups().items():
        values = [readings[row] for row in rows if stands[row]]
        if values:
            values = values if Role.REPEAT in long.texts else list(numbered(values))
            inspections.append(common.inspection(key, rows, sha256, values, values[0].measured_at))
    return MeasuredFile(
        path=long.grid.path,
        format="table",
        encoding=long.grid.encoding,
        unit=sizes.unit,
        inspections=tuple(inspections),
        characteristics=characteristics_of(readings),
        remarks=(*remarks, *filled_in(inspections)),
    )


def _readings(common: Common, sizes: Sizes) -> Iterator[Reading]:
    long = common.long
    count = len(long)
    stated = long.texts.get(Role.QUANTITY, [""] * count)
    features = long.texts.get(Role.FEATURE) or long.texts.get(Role.CHARACTERISTIC) or [""] * count
    named = long.texts.get(Role.CHARACTERISTIC, [""] * count)
    columns = zip(
        [name or f"{feature} {what}".strip() for name, feature, what in zip(named, features, stated, strict=True)],
        sizes.quantities,
        sizes.actual.tolist(),
        *(_or_none(values) for values in (sizes.nominal, sizes.lower_limit, sizes.upper_limit)),
        features,
        [AXES.get(text.lower(), "") for text in stated],
        _places(long, sizes.unit),
        _repeats(long),
        common.moments(),
        _temperatures(long),
        long.lines,
        strict=True,
    )
    for name, quantity, actual, nominal, lower, upper, feature, axis, place, repeat, at, temperature, line in columns:
        yield Reading(
            name, quantity, actual, nominal, lower, upper, feature=feature, axis=axis, place_mm=place, repeat=repeat,
            measured_at=at, temperature_c=temperature, line=line,
        )  # fmt: skip


def _or_none(values: Array) -> list[float | None]:
    return [None if math.isnan(value) else value for value in values.tolist()]


def _places(long: Long, unit: Unit | None) -> Sequence[tuple[float, ...]]:
    """Where each was measured: x, y and z, or z alone; x without y may be a radius or a diameter and is left out."""
    roles = POINT if all(role in long.texts for role in POINT) else POINT[2:]
    if not all(role in long.texts for role in roles):
        return [()] * len(long)
    columns = [lengths_of(long, role, unit).tolist() for role in roles]
    return [() if any(map(math.isnan, place)) else place for place in zip(*columns, strict=True)]


def _repeats(long: Long) -> Sequence[int]:
    if Role.REPEAT not in long.texts:
        return [1] * len(long)
    values = numbers_of(long.texts[Role.REPEAT], long.where(Role.REPEAT)).values
    return [1 if math.isnan(value) else max(1, round(value)) for value in values.tolist()]


def _temperatures(long: Long) -> Sequence[float | None]:
    if Role.TEMPERATURE not in long.texts:
        return [None] * len(long)
    return _or_none(numbers_of(long.texts[Role.TEMPERATURE], long.where(Role.TEMPERATURE)).values)


def _left_out(long: Long, stands: Flags) -> Iterator[Remark]:
    if not np.all(stands):
        row = int(np.argmin(stands))
        yield Remark(
            f"{np.sum(~stands)} of {len(stands)} values are not measured: their cells are empty", long.lines[row]
        )
    if long.left_out:
        yield Remark(f"{len(long.left_out)} rows of statistics are left out", long.left_out[0])


def _compared(sizes: Sizes, readings: Sequence[Reading], stands: Flags) -> Iterator[Remark]:
    """Deviations and verdicts as the file states them, with those of its own values."""
    differ = np.abs(sizes.deviation - (sizes.actual - sizes.nominal)) > sizes.rounding + 1e-9
    if np.any(differ):
        stated = zip(readings, sizes.deviation.tolist(), strict=True)
        yield from stated_deviations((one, value, sizes.rounding) for one, value in stated if not math.isnan(value))
    if not np.all(np.isnan(sizes.good)):
        verdicts = zip(readings, sizes.good.tolist(), stands.tolist(), strict=True)
        yield from stated_verdicts((one, good > 0) for one, good, here in verdicts if here and not math.isnan(good))
