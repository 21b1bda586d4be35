"""The values of a table as arrays in mm and degrees: actual, nominal and limits, whatever signs and units it has."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.domain.characteristic import Quantity
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Remark, Unit
from trueloop.formats.inspections.shared.quantities import (
    FONT,
    Deviation,
    LowerTolerance,
    counted_from_nominal,
    deviation_sign,
    is_font,
    limits_refusal,
    lower_tolerance_sign,
    quantity_in,
    quantity_of,
)
from trueloop.formats.inspections.tables.headings import ANGLE_DEG, BAD, GOOD, LENGTHS, Role, plain, unit_named
from trueloop.formats.inspections.tables.long import Long, Numbers, factors_of, numbers_of, tolerances_of
from trueloop.formats.inspections.tables.mapping import HINT, map_command
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping
from trueloop.units import MM_PER_INCH

SLACK: Final = 1e-9
SIGNS: Final = 'lower_tolerance = "with its sign" or "without its sign"'
COARSEST_MM: Final = ((6, 30, 120, 400, 1000, 2000), np.array((0.5, 1.0, 1.5, 2.5, 4.0, 6.0, 8.0)))
"""Nominal sizes up to which the general tolerances of class v hold, and these, ± [ISO 2768-1]."""
FAR: Final = 2.0
"""A tolerance beyond so many times that is likely in another unit."""
FINEST_MM: Final = 0.1
"""A tolerance below it is not in micrometers."""
LITTLE: Final = 0.1
"""A part uses a larger share of its tolerance in the end, if the unit is right."""
MICROMETERS: Final = 3
"""Decimals of millimeters that a size to the micrometer has."""
DECIMALS: Final = re.compile(r"[.,](\d+)")
_Column: TypeAlias = Role | Literal["below", "above"]
"""`below` and `above` are the tolerances of a column that holds both."""
SYMBOLS: Final = {"R": Quantity.RADIUS, **dict.fromkeys("Øø⌀∅n", Quantity.DIAMETER)}


@dataclass(frozen=True)
class Sizes:
    """The numbers of a table's values, (n,) each, nan where not stated: mm, of angles degrees; limits are absolute.

    `from_deviation`, (n,), are those whose nominal value is that of a stated deviation, with its sign by the first of
    `conventions`. `rounding`, (n,), is by how much a stated deviation may differ from actual − nominal because all
    three were rounded.
    `refusal` is of tolerances that are likely in another unit: a mapping that states it can be proposed nevertheless.
    """

    quantities: Sequence[Quantity]
    actual: Array
    nominal: Array
    lower_limit: Array
    upper_limit: Array
    deviation: Array
    from_deviation: Flags
    rounding: Array
    good: Array
    conventions: tuple[Deviation | None, LowerTolerance | None]
    unit: Unit | None
    remarks: tuple[Remark, ...] = ()
    refusal: TrueloopError | None = None


def sizes_of(long: Long, mapping: TableMapping, unit: Unit | None) -> Sizes:
    """Returns the sizes. Raises MSR-UNIT, MSR-NUMBER, MSR-EXCHANGED, and MSR-MEANING where signs cannot be known."""
    read = {role: numbers_of(texts, long.where(role)) for role, texts in long.texts.items() if role in LENGTHS}
    row_units = [unit_named(text) for text in long.texts.get(Role.UNIT, ())]
    quantities, unknown = quantities_of(long, read, row_units)
    zone = np.array([quantity.is_zone for quantity in quantities], dtype=bool)
    below, above, unread = tolerances_of(long.texts.get(Role.TOLERANCE, ()), zone)
    columns: dict[_Column, Numbers] = dict(read.items())
    if Role.TOLERANCE in long.texts:
        columns |= {"below": below, "above": above}
    angle = np.array([quantity is Quantity.ANGLE for quantity in quantities], dtype=bool)
    factors = {column: factors_of(long, _role(column), each, unit, angle) for column, each in columns.items()}
    numbers = {column: each.values * factors[column] for column, each in columns.items()}
    base = unit or _unit_of(factors, angle)
    nothing = np.full(len(long), np.nan)
    actual, nominal, stated = (numbers.get(role, nothing) for role in (Role.ACTUAL, Role.NOMINAL, Role.DEVIATION))
    rounding = _rounding(long, factors)
    sign = mapping.deviation or deviation_sign(actual, nominal, stated, rounding)
    deviation = -stated if sign == "nominal - actual" else stated
    needed = ~np.isnan(stated) & (np.isnan(actual) != np.isnan(nominal))
    if np.any(needed) and sign is None:
        raise _unknown(
            long, Role.DEVIATION, int(np.argmax(needed)), 'deviation = "actual - nominal" or "nominal - actual"'
        )
    from_deviation = needed & np.isnan(nominal)
    actual = np.where(np.isnan(actual), nominal + deviation, actual)
    nominal = np.where(np.isnan(nominal), actual - deviation, nominal)
    good = _good(long)
    limits = _limits(long, mapping, numbers, zone, actual, nominal, good)
    far = [*_far(long, quantities, columns, numbers, nominal), *_whole(long, columns, numbers, actual, nominal, angle)]
    refusal = next((one for one in far if isinstance(one, TrueloopError)), None)
    said = [Remark(f"{unknown} values are of a quantity that is not known: they are read as other")] if unknown else []
    if unread:
        text, line = long.texts[Role.TOLERANCE][unread[0]], long.lines[unread[0]]
        said.append(Remark(f"{len(unread)} tolerances are not read: {text!r} is neither ±T nor +T/-T", line))
    sizes = Sizes(
        quantities=quantities,
        actual=actual,
        nominal=nominal,
        lower_limit=limits.lower,
        upper_limit=limits.upper,
        deviation=stated,
        from_deviation=from_deviation,
        rounding=rounding,
        good=good,
        conventions=(sign, limits.sign),
        unit=base,
    )
    return replace(
        sizes, refusal=refusal, remarks=(*said, *limits.remarks, *(one for one in far if isinstance(one, Remark)))
    )


def _far(
    long: Long,
    quantities: Sequence[Quantity],
    columns: Mapping[_Column, Numbers],
    numbers: Mapping[_Column, Array],
    nominal: Array,
) -> Iterator[Remark | TrueloopError]:
    """Yields tolerances so far from the nominal value that they are likely in another unit: as the error MSR-UNIT where
    they are of a length and neither cell nor column states their unit.
    """
    zone, known = (
        np.array([quantity in kinds for quantity in quantities], dtype=bool)
        for kinds in ((Quantity.FORM, Quantity.RUNOUT), set(Quantity) - {Quantity.OTHER, Quantity.ANGLE})
    )
    angle = np.array([quantity is Quantity.ANGLE for quantity in quantities], dtype=bool)
    bounds, coarsest = COARSEST_MM
    reach = FAR * coarsest[np.searchsorted(bounds, np.nan_to_num(np.where(zone, 0.0, np.abs(nominal))))]
    for column in (Role.UPPER_TOLERANCE, Role.LOWER_TOLERANCE, "above", "below"):
        if column not in numbers:
            continue
        role = _role(column)
        far = ~angle & (np.abs(numbers[column]) > reach)
        bare = far & known & ~np.isin(np.arange(len(long)), list(columns[column].units)) & (role not in long.units)
        if np.any(far):
            row = int(np.argmax(bare if np.any(bare) else far))
            size = "" if np.isnan(nominal[row]) else f" at a size of {nominal[row]:.6g} mm"
            text = f"{role.replace('_', ' ')} {numbers[column][row]:.6g} mm{size}"
            if np.any(bare):
                fine = np.any((numbers[column] != 0) & (np.abs(numbers[column]) < FINEST_MM))
                either = '"mm"; of a cell of its own unit in that cell' if fine else '"µm" or "mm"'
                yield Code.MSR_UNIT.refusal(
                    f"{text}: it is likely in another unit",
                    hint="state the units of tolerances in their headings (`[µm]` or `[mm]`), or in the mapping that "
                    f"`{map_command(long.grid.path)}` writes: [units] {role} = {either}",
                    place=long.place(role, row),
                    values={"file": long.grid.path.name},
                )
            else:
                yield Remark(f"{np.sum(far)} tolerances are implausibly large: {text}", long.lines[row])


def _whole(
    long: Long,
    columns: Mapping[_Column, Numbers],
    numbers: Mapping[_Column, Array],
    actual: Array,
    nominal: Array,
    angle: Flags,
) -> Iterator[TrueloopError]:
    """Yields MSR-UNIT for tolerances that may be micrometers: whole numbers all of them, without a unit, of which
    sizes to the micrometer use less than a share `LITTLE`.
    """
    digits = [DECIMALS.search(text) for text in long.texts.get(Role.ACTUAL, ())]
    if max((len(found[1]) for found in digits if found), default=0) < MICROMETERS:
        return
    off = np.abs(np.where(np.isnan(nominal), actual, actual - nominal))
    sizes: list[Array] = []
    keys: dict[Role, None] = {}
    for column in (Role.UPPER_TOLERANCE, Role.LOWER_TOLERANCE, "above", "below"):
        if column in numbers and (role := _role(column)) not in long.units:
            bare = ~angle & ~np.isin(np.arange(len(long)), list(columns[column].units)) & (numbers[column] != 0)
            if any(DECIMALS.search(long.texts[role][row]) for row in np.flatnonzero(bare).tolist()):
                return
            sizes.append(np.where(bare, np.abs(numbers[column]), np.nan))
            keys[role] = None
    least = np.fmin.reduce(sizes) if sizes else np.full(len(long), np.nan)
    rows = np.flatnonzero(~np.isnan(least) & ~np.isnan(off))
    if len(rows) and np.all(least[rows] >= 1.0) and np.all(off[rows] <= LITTLE * least[rows]):
        row, role = int(rows[0]), next(iter(keys))
        units = " and ".join(f'{key} = "µm"' for key in keys)
        yield Code.MSR_UNIT.refusal(
            f"tolerance {least[row]:.6g} mm at a deviation of {off[row]:.6g} mm: it may be {least[row]:.6g} µm, all "
            f"tolerances of {len(rows)} values are whole numbers without a unit",
            hint="state the units of tolerances in their headings (`[µm]` or `[mm]`), or in the mapping that "
            f'`{map_command(long.grid.path)}` writes: [units] {units}, or "mm"',
            place=long.place(role, row),
            values={"file": long.grid.path.name},
        )


def quantities_of(long: Long, read: Mapping[Role, Numbers], row_units: Sequence[str]) -> tuple[list[Quantity], int]:
    """Returns each value's quantity, by its own column, symbol, name, unit or heading; and the number of unknown
    ones.
    """
    count = len(long)
    stated = long.texts.get(Role.QUANTITY, [""] * count)
    font = is_font(frozenset(stated))
    names = zip(
        long.texts.get(Role.CHARACTERISTIC, [""] * count), long.texts.get(Role.FEATURE, [""] * count), strict=True
    )
    symbols = {row: SYMBOLS.get(mark) for role in read for row, mark in read[role].symbols.items()}
    in_rows = (enumerate(row_units), *(numbers.units.items() for numbers in read.values()))
    angles = {row for units in in_rows for row, name in units if name in ANGLE_DEG}
    known: dict[tuple[str, str, str], Quantity | None] = {}
    out, unknown = [], 0
    for row, (text, (name, feature)) in enumerate(zip(stated, names, strict=True)):
        key = text, name, feature
        if key not in known:
            said = FONT.get(text) if font and text else quantity_of(text) if text else None
            known[key] = said or quantity_in(name) or quantity_in(feature)
        found = known[key] or symbols.get(row)
        if row in angles:
            found = Quantity.ANGLE
        unknown += found is None and bool(text)
        out.append(found or (None if text else long.quantity) or Quantity.OTHER)
    return out, unknown


def _role(column: _Column) -> Role:
    return Role(column) if column in LENGTHS else Role.TOLERANCE


def _unit_of(factors: Mapping[_Column, Array], angle: Flags) -> Unit | None:
    """The unit of the first length among the actual values; None where all are angles."""
    columns = [factors[role] for role in (Role.X, Role.ACTUAL, Role.DEVIATION) if role in factors]
    known = [column[~angle & ~np.isnan(column)] for column in columns]
    first = next((lengths[0] for lengths in known if len(lengths)), None)
    return None if first is None else "inch" if first == MM_PER_INCH else "mm"


@dataclass(frozen=True)
class _Limits:
    lower: Array
    upper: Array
    sign: LowerTolerance | None
    remarks: tuple[Remark, ...]


def _limits(
    long: Long,
    mapping: TableMapping,
    numbers: Mapping[_Column, Array],
    zone: Flags,
    actual: Array,
    nominal: Array,
    good: Array,
) -> _Limits:
    """Absolute limits. A tolerance of form has no lower one; near 0, of an actual value inside, it is as stated."""
    nothing = np.full(len(long), np.nan)
    lower, upper = (numbers.get(role, nothing) for role in (Role.LOWER_LIMIT, Role.UPPER_LIMIT))
    from_nominal = nominal + lower, nominal + upper
    gained = _contradicted(actual, lower, upper, good) - _contradicted(actual, *from_nominal, good)
    near_zero = np.fmax(np.abs(lower), np.abs(upper)) < np.abs(nominal) / 2
    form = (np.abs(actual) < np.abs(actual - nominal)) & ~(lower < 0) & ~(actual < lower) & ~(actual > upper)
    sizes = np.where(form, np.nan, nominal)
    relative = gained >= 0 and counted_from_nominal(sizes, lower, upper, stated=False)
    relative |= gained > 0 and bool(np.all(near_zero | np.isnan(np.fmax(lower, upper))))
    if relative:
        lower, upper = from_nominal
    low, high = (numbers.get(role, nothing) for role in (Role.LOWER_TOLERANCE, Role.UPPER_TOLERANCE))
    remarks = [Remark("limits are near 0: they are counted from the nominal value")] if relative else []
    sign = mapping.lower_tolerance or lower_tolerance_sign(high, low, actual - nominal, good)
    if sign is None:
        row = int(np.argmax(~np.isnan(low) & (low != 0)))
        raise _unknown(long, Role.LOWER_TOLERANCE, row, SIGNS)
    if sign == "without its sign":
        low = -low
        remarks.append(
            Remark("lower tolerances are printed without their sign: they are taken below the nominal value")
        )
    if np.any(turned := (high > 0) & (np.abs(low - high) <= SLACK)):
        doubtful = (low > 0) & (low < high) & ~turned & (mapping.lower_tolerance is None)
        of_doubtful = (each[doubtful] for each in (high, low, actual - nominal, good))
        if np.any(doubtful) and lower_tolerance_sign(*of_doubtful) != "with its sign":
            raise _unknown(long, Role.LOWER_TOLERANCE, int(np.argmax(doubtful)), SIGNS)
        low = np.where(turned, -low, low)
        text = f"{np.sum(turned)} lower tolerances are not signed as the others: they are taken below the nominal value"
        remarks.append(Remark(text, long.lines[int(np.argmax(turned))]))
    base = np.where(zone & np.isnan(nominal), 0.0, nominal)  # a form or a runout counts from 0
    for below, above in ((low, high), (numbers.get("below", nothing), numbers.get("above", nothing))):
        upper = np.where(np.isnan(upper), base + above, upper)
        lower = np.where(np.isnan(lower), base + below, lower)
        lost = np.isnan(base) & ~np.isnan(actual) & ~np.isnan(np.fmax(below, above)) & np.isnan(np.fmax(lower, upper))
        if np.any(lost):
            text = f"{np.sum(lost)} tolerances are not applied: the nominal value that they count from is not stated"
            remarks.append(Remark(text, long.lines[int(np.argmax(lost))]))
    lower = np.where(zone & (lower == 0), np.nan, lower)
    _require_order(long, lower, upper)
    if np.any(narrow := upper - lower <= SLACK):
        row = int(np.argmax(narrow))
        remarks.append(Remark(f"{np.sum(narrow)} tolerance zones have no width: {upper[row]:.6g}", long.lines[row]))
    outside = (nominal < lower - SLACK) | (nominal > upper + SLACK)
    if np.any(outside):
        row = int(np.argmax(outside))
        zone_in_words = f"[{lower[row]:.6g}, {upper[row]:.6g}] of {nominal[row]:.6g}"
        text = f"{np.sum(outside)} tolerance zones exclude the nominal value: {zone_in_words}"
        remarks.append(Remark(text, long.lines[row]))
    return _Limits(lower, upper, sign if Role.LOWER_TOLERANCE in long.texts else None, tuple(remarks))


def _contradicted(actual: Array, lower: Array, upper: Array, good: Array) -> int:
    """Returns how many of the table's own verdicts limits contradict."""
    inside = ~(actual < lower - SLACK) & ~(actual > upper + SLACK)
    return int(np.count_nonzero(~np.isnan(good) & (inside != (good > 0))))


def _require_order(long: Long, lower: Array, upper: Array) -> None:
    wrong = lower > upper + SLACK
    if np.any(wrong):
        row = int(np.argmax(wrong))
        raise limits_refusal(float(lower[row]), float(upper[row]), Place(str(long.grid.path), long.lines[row]))


def _good(long: Long) -> Array:
    """Verdicts as the table states them, (n,): 1 good, 0 bad, nan not stated; also by how much a value is outside."""
    if Role.VERDICT not in long.texts and Role.OUTSIDE in long.texts:
        outside = numbers_of(long.texts[Role.OUTSIDE], long.where(Role.OUTSIDE)).values
        return np.where(np.isnan(outside), np.nan, outside == 0)
    return np.array([_verdict(text) for text in long.texts.get(Role.VERDICT, ())] or [np.nan] * len(long))


def _rounding(long: Long, factors: Mapping[_Column, Array]) -> Array:
    """By how much deviation and actual − nominal may differ, (n,); a nominal value of few digits is not rounded."""
    actual, nominal, deviation = (
        _half_digits(long, role, factors) for role in (Role.ACTUAL, Role.NOMINAL, Role.DEVIATION)
    )
    return deviation + actual + np.fmin(actual, nominal)


def _half_digits(long: Long, role: Role, factors: Mapping[_Column, Array]) -> Array:
    """Half the last digit of a column's numbers, (n,), in mm; of a workbook, whose numbers are not rounded, what a
    float loses. The number of digits is the greatest among the first of each unit.
    """
    each = factors.get(role, np.ones(len(long)))
    places: dict[float, int] = {}
    for text, factor in zip(long.texts.get(role, ())[:1000], each.tolist(), strict=False):
        if text:
            digits = DECIMALS.search(text)
            places[factor] = max(places.get(factor, 0), len(digits[1]) if digits else 0)
    out = np.full(len(long), 1e-9)
    for factor in np.unique(each[~np.isnan(each)]).tolist():
        out[each == factor] = max(0.5 * 10.0 ** -min(places.get(factor, 9), 9), 1e-9) * factor
    return out


def _verdict(text: str) -> float:
    name = plain(text)
    return 1.0 if name in GOOD else 0.0 if name in BAD else np.nan


def _unknown(long: Long, role: Role, row: int, key: str) -> TrueloopError:
    name = long.grid.path.name
    return Code.MSR_MEANING.refusal(
        f"{name!r} does not say how its {role.replace('_', ' ')} is signed, and its values do not tell",
        hint=f"say it in its mapping ({map_command(long.grid.path)}): {key}. {HINT}",
        place=long.place(role, row),
        values={"file": name},
    )
