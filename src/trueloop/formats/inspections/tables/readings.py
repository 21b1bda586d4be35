"""The readings of a table: its values with their nominals, limits, places and times."""

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.measured_file import MeasuredFile, Remark, Unit
from trueloop.formats.inspections.shared.checks import (
    by_reading,
    devices_of,
    filled_in,
    listed,
    numbered,
    require_serials,
    stated_deviations,
    stated_verdicts,
)
from trueloop.formats.inspections.shared.quantities import axis_of, characteristics_of
from trueloop.formats.inspections.shared.text import moment, order_of
from trueloop.formats.inspections.tables.grid import Grid
from trueloop.formats.inspections.tables.header import Header, stated_above
from trueloop.formats.inspections.tables.headings import LENGTH_MM, POINT, TYPES, Role, unit_stated_in
from trueloop.formats.inspections.tables.long import Long, lengths_of, numbers_of
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.formats.inspections.tables.sizes import Sizes, sizes_of
from trueloop.units import MM_PER_INCH
from trueloop.wording import first_of

TITLES: Final = (Role.PART, Role.SERIAL, Role.DATE, Role.TIME, Role.OPERATOR, Role.DEVICE)
"""Roles that lines above the headings may state for the whole file."""
OF_VALUE: Final = (Role.CHARACTERISTIC, Role.FEATURE, Role.QUANTITY, Role.REPEAT, *POINT)
"""Roles that tell the values of one measurement apart."""


LISTED: Final = 20
"""Texts of rows that are left out, as many as a remark lists."""
SAME_POINT_MM: Final = 0.05
"""A point of the same name that follows at so small a distance is measured again, not the feature's next one."""


@dataclass(frozen=True)
class Common:
    """Data common to readings and points of a table: part, time, place, device."""

    long: Long
    title: Mapping[Role, str]
    mapping: TableMapping

    def texts(self, role: Role) -> Sequence[str]:
        """Returns a column's texts, or for all rows the title's."""
        if role in self.long.texts:
            return self.long.texts[role]
        return [self.title.get(role, "")] * len(self.long)

    def text(self, role: Role, row: int) -> str:
        """Returns the cell of a role in a row."""
        return self.long.texts[role][row] if role in self.long.texts else self.title.get(role, "")

    def groups(
        self, points: Sequence[CmmPoint | None] = ()
    ) -> Iterator[tuple[tuple[str, str], list[int], datetime | None]]:
        """Yields the rows of each measurement of each part, in the file's order, with its time. Raises MSR-TIME.

        A characteristic that comes again at another time is of a new measurement, and so is one by another device at
        another time. Of `points`, those without a name, and those of one name that follow each other at different
        places, as on a feature of that name, are one measurement, each at its time.
        """
        moments, names = self.moments(), self._names()
        devices = self.texts(Role.DEVICE)
        parts: defaultdict[tuple[str, str], list[int]] = defaultdict(list)
        for row, key in enumerate(zip(self.texts(Role.PART), self.texts(Role.SERIAL), strict=True)):
            parts[key].append(row)
        for key, rows in parts.items():
            if len({moments[row] for row in rows}) < 2:
                yield key, rows, moments[rows[0]]
                continue
            runs: list[_Run] = []
            for row in sorted(rows, key=lambda one: (moments[one] is not None, moments[one])):
                goes_on = partial(_goes_on, names, points, row)
                _run_of(runs, moments[row], devices[row], names[row], goes_on).rows.append(row)
            for run in runs:
                ordered = sorted(run.rows)
                yield key, ordered, run.at if len(runs) > 1 else moments[ordered[0]]

    def _names(self) -> Sequence[tuple[str, ...]]:
        """Returns the measured quantity and place of each row; empty for points without a name."""
        roles = [role for role in OF_VALUE if role in self.long.texts]
        if not self.mapping.columns.has_values:
            roles = [role for role in roles if role in (Role.CHARACTERISTIC, Role.FEATURE)]
        return list(zip(*(self.long.texts[role] for role in roles), strict=True)) or [()] * len(self.long)

    def moments(self) -> Sequence[datetime | None]:
        """Returns the time of measurement of each row. Raises MSR-TIME."""
        dates, times = self.texts(Role.DATE), self.texts(Role.TIME)
        if any(dates) and any(times) and not _has_date(times):
            texts = [f"{_day(date)} {time}" if date and time else date for date, time in zip(dates, times, strict=True)]
        else:
            texts = list(times if _has_date(times) else dates)
        role = Role.DATE if Role.DATE in self.long.texts else Role.TIME
        order = self.mapping.dates or order_of(texts, self.long.place(role, 0))
        first = {text: row for row, text in reversed(list(enumerate(texts)))}
        known = {text: moment(text, order, self.long.place(role, row)) for text, row in first.items()}
        return [known[text] for text in texts]

    def inspection(
        self,
        key: tuple[str, str],
        rows: Sequence[int],
        sha256: str,
        values: Sequence[Reading | CmmPoint],
        at: datetime | None,
    ) -> Inspection:
        """Returns the inspection of one part."""
        return Inspection(
            part=Part(PartType(key[0]), key[1]),
            measured="readings" if isinstance(values[0], Reading) else "CMM points",
            sha256=sha256,
            count=len(values),
            values=tuple(values),
            device=listed(self.text(Role.DEVICE, row) for row in rows),
            operator=listed(self.text(Role.OPERATOR, row) for row in rows),
            measured_at=at,
        )


@dataclass
class _Run:
    """One measurement of a part: its rows, the devices that it is by, and the time at which each value was taken."""

    at: datetime | None
    rows: list[int]
    devices: set[str]
    times: dict[tuple[str, ...], datetime | None]


def _goes_on(names: Sequence[tuple[str, ...]], points: Sequence[CmmPoint | None], row: int, before: int) -> bool:
    """Returns whether a row is a further point of the measurement of the row `before`, by name and place."""
    if not points or not any(names[row]):
        return bool(points)
    one, other = points[before], points[row]
    here = one is not None and other is not None and math.dist(one.measured_mm, other.measured_mm) <= SAME_POINT_MM
    return names[row] == names[before] and not here


def _run_of(
    runs: list[_Run], at: datetime | None, device: str, name: tuple[str, ...], goes_on: Callable[[int], bool]
) -> _Run:
    """Returns the measurement of a row: the device's last one, unless the value was measured in it at another time."""
    last = next((run for run in reversed(runs) if device in run.devices), None)
    if last is not None and (goes_on(last.rows[-1]) or last.times.get(name, at) == at):
        last.times[name] = at
        return last
    at_this_time = next((run for run in runs if run.at == at), None)  # its identity is its time
    run = at_this_time or _Run(at, [], set(), {})
    if at_this_time is None:
        runs.append(run)
    run.devices.add(device)
    run.times.setdefault(name, at)
    return run


def _has_date(texts: Sequence[str]) -> bool:
    return any(
        (len(text) >= 6 and sum(map(text.count, "./-")) >= 2) or (len(text) >= 8 and text.isdigit())
        for text in texts
        if text
    )


def _day(date: str) -> str:
    """A date of a workbook has a time of 0 h beside it."""
    return date.removesuffix(" 00:00:00")


def title_of(grid: Grid, header: Header, mapping: TableMapping) -> dict[Role, str]:
    """Reads `Operator: Meier` above the headings, in one cell or in two.

    `Part`, a serial number alone, is the part's type beside another statement or a column of the serial number.
    """
    found: dict[Role, str] = {}
    kinds: list[str] = []
    for role, name, text in stated_above(grid.rows[: header.title]):
        if role is Role.SERIAL and name in TYPES:
            kinds.append(text)
        elif role in TITLES:
            found.setdefault(role, text)
    if kinds:
        beside = Role.SERIAL in found or mapping.columns.serial or mapping.columns.parts
        found.setdefault(Role.PART if beside else Role.SERIAL, kinds[0])
    return found


def unit_of_headings(long: Long) -> Unit | None:
    """Returns millimetre or inch where headings name one of them, for the columns whose headings name none."""
    named = {factor for unit in long.units.values() if (factor := LENGTH_MM.get(unit)) in (1.0, MM_PER_INCH)}
    return None if len(named) != 1 else "mm" if named == {1.0} else "inch"


def unit_of_title(grid: Grid, header: Header) -> Unit | None:
    """Returns the unit that the lines above the headings state for all lengths; None: none."""
    for row in grid.rows[: header.title]:
        if unit := unit_stated_in(" ".join(row)):
            return unit
    return None


def with_readings(common: Common, unit: Unit | None, sha256: str, notes: Sequence[Remark]) -> MeasuredFile:
    """Returns a table's inspections of readings. Raises MSR-UNIT, MSR-NUMBER, MSR-EXCHANGED, MSR-TIME, MSR-MEANING."""
    long, mapping = common.long, common.mapping
    sizes = sizes_of(long, mapping, unit)
    if sizes.refusal is not None:
        raise sizes.refusal
    readings = list(_readings(common, sizes))
    stands = ~np.isnan(sizes.actual)
    remarks = [*notes, *sizes.remarks, *_left_out(long, stands)]
    remarks += _compared(sizes, readings, stands)
    serials = common.texts(Role.SERIAL)
    measured = np.flatnonzero(stands).tolist()
    require_serials([serials[row] for row in measured], lambda k: long.place(Role.SERIAL, measured[k]))
    inspections = []
    for key, rows, at in common.groups():
        values = [readings[row] for row in rows if stands[row]]
        if values:
            devices = devices_of(
                (readings[row].characteristic, common.text(Role.DEVICE, row)) for row in rows if stands[row]
            )
            values = values if Role.REPEAT in long.texts else list(numbered(values))
            inspections.append(replace(common.inspection(key, rows, sha256, values, at), devices=devices))
    return MeasuredFile(
        path=long.grid.path,
        format="table",
        encoding=long.grid.encoding,
        unit=sizes.unit,
        inspections=tuple(inspections),
        characteristics=characteristics_of(readings),
        remarks=(*remarks, *filled_in(inspections)),
        deviations=by_reading(_without_nominal(sizes, readings)),
    )


def _without_nominal(sizes: Sizes, readings: Sequence[Reading]) -> Iterator[tuple[Reading, float, float]]:
    """Yields the readings whose nominal value is that of their deviation, which is to be compared with the part's."""
    sign = -1.0 if sizes.conventions[0] == "nominal - actual" else 1.0
    for row in np.flatnonzero(sizes.from_deviation).tolist():
        yield readings[row], sign * float(sizes.deviation[row]), float(sizes.rounding[row])


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
        list(map(axis_of, stated)),
        _places(long, sizes.unit),
        _repeats(long),
        common.moments(),
        _temperatures(long),
        long.lines,
        strict=True,
    )
    for name, quantity, actual, nominal, lower, upper, feature, axis, place, repeat, at, temperature, line in columns:
        yield Reading(
            characteristic=name,
            quantity=quantity,
            actual=actual,
            nominal=nominal,
            lower_limit=lower,
            upper_limit=upper,
            feature=feature,
            axis=axis,
            place_mm=place,
            repeat=repeat,
            measured_at=at,
            temperature_c=temperature,
            line=line,
        )


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
            f"{np.sum(~stands)} of {len(stands)} values are not measured: their cells hold no number", long.lines[row]
        )
    yield from statistics_left_out(long)


def statistics_left_out(long: Long) -> Iterator[Remark]:
    """Yields a remark with the texts by which rows were taken for statistics."""
    if long.left_out:
        texts = list(dict.fromkeys(long.left_out.values()))
        listed = first_of([*map(repr, texts)], LISTED)
        yield Remark(f"{len(long.left_out)} rows of statistics are left out: {listed}", min(long.left_out))


def _compared(sizes: Sizes, readings: Sequence[Reading], stands: Flags) -> Iterator[Remark]:
    """Deviations and verdicts as the file states them, with those of its own values."""
    differ = np.abs(sizes.deviation - (sizes.actual - sizes.nominal)) > sizes.rounding + 1e-9
    if np.any(differ):
        stated = zip(readings, sizes.deviation.tolist(), sizes.rounding.tolist(), strict=True)
        yield from stated_deviations(each for each in stated if not math.isnan(each[1]))
    if not np.all(np.isnan(sizes.good)):
        verdicts = zip(readings, sizes.good.tolist(), stands.tolist(), strict=True)
        yield from stated_verdicts(
            (reading, good > 0) for reading, good, here in verdicts if here and not math.isnan(good)
        )
