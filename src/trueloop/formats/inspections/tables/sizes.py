"""The values of a table as arrays in mm and degrees: actual, nominal and limits, whatever signs and units it has."""

from collections.abc import Mapping, Sequence
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
from trueloop.formats.inspections.tables.headings import LENGTHS, Role, names_in, plain, unit_named
from trueloop.formats.inspections.tables.long import (
    Long,
    Numbers,
    factor_of,
    no_unit,
    numbers_of,
    tolerances_of,
    unit_of_cells,
)
from trueloop.formats.inspections.tables.mapping import HINT, map_command
from trueloop.formats.inspections.tables.mapping import Mapping as TableMapping

GOOD: Final = frozenset(
    names_in("ok, pass, passed, io, i o, in, intol, in tol, gut, good, yes, ja, true, accept, accepted, 1")
)
BAD: Final = frozenset(
    names_in(
        "nok, nio, n i o, fail, failed, out, outol, not ok, n ok, out of tol, schlecht, bad, no, nein, false, ng, 0"
    )
)
SLACK: Final = 1e-9
_Column: TypeAlias = Role | Literal["below", "above"]
"""`below` and `above` are the tolerances of a column that holds both."""
SYMBOLS: Final = {"R": Quantity.RADIUS, **dict.fromkeys("Øø⌀∅n", Quantity.DIAMETER)}


@dataclass(frozen=True)
class Sizes:
    """The numbers of a table's values, (n,) each, nan where not stated: mm, of angles degrees; limits are absolute.

    `rounding` is by how much a stated deviation may differ from actual − nominal because all three were rounded.
    """

    quantities: Sequence[Quantity]
    actual: Array
    nominal: Array
    lower_limit: Array
    upper_limit: Array
    deviation: Array
    rounding: float
    good: Array
    conventions: tuple[Deviation | None, LowerTolerance | None]
    unit: Unit | None
    remarks: tuple[Remark, ...] = ()


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
    numbers, base = _in_mm(long, columns, quantities, row_units, unit)
    nothing = np.full(len(long), np.nan)
    actual, nominal, stated = (numbers.get(role, nothing) for role in (Role.ACTUAL, Role.NOMINAL, Role.DEVIATION))
    rounding = _rounding(long, base)
    sign = mapping.deviation or deviation_sign(actual, nominal, stated, rounding)
    deviation = -stated if sign == "nominal - actual" else stated
    needed = ~np.isnan(stated) & (np.isnan(actual) != np.isnan(nominal))
    if np.any(needed) and sign is None:
        raise _unknown(
            long, Role.DEVIATION, int(np.argmax(needed)), 'deviation = "actual - nominal" or "nominal - actual"'
        )
    actual = np.where(np.isnan(actual), nominal + deviation, actual)
    nominal = np.where(np.isnan(nominal), actual - deviation, nominal)
    good = _good(long)
    limits = _limits(long, mapping, numbers, zone, actual, nominal, good)
    said = [Remark(f"{unknown} values are of a quantity that is not known: they are read as other")] if unknown else []
    if unread:
        text, line = long.texts[Role.TOLERANCE][unread[0]], long.lines[unread[0]]
        said.append(Remark(f"{len(unread)} tolerances are not read: {text!r} is neither ±T nor +T/-T", line))
    sizes = Sizes(
        quantities, actual, nominal, limits.lower, limits.upper, stated, rounding, good, (sign, limits.sign), base
    )
    return replace(sizes, remarks=(*said, *limits.remarks))


def quantities_of(long: Long, read: Mapping[Role, Numbers], row_units: Sequence[str]) -> tuple[list[Quantity], int]:
    """Returns each value's quantity, by its own column, symbol, name or unit; and the number of unknown ones."""
    count = len(long)
    stated = long.texts.get(Role.QUANTITY, [""] * count)
    font = is_font(frozenset(stated))
    names = zip(
        long.texts.get(Role.CHARACTERISTIC, [""] * count), long.texts.get(Role.FEATURE, [""] * count), strict=True
    )
    symbols = {row: SYMBOLS.get(mark) for role in read for row, mark in read[role].symbols.items()}
    known: dict[tuple[str, str, str], Quantity | None] = {}
    out, unknown = [], 0
    for row, (text, (name, feature)) in enumerate(zip(stated, names, strict=True)):
        key = text, name, feature
        if key not in known:
            said = FONT.get(text) if font and text else quantity_of(text) if text else None
            known[key] = said or quantity_in(name) or quantity_in(feature)
        found = known[key] or symbols.get(row)
        if row_units and row_units[row] in ("°", "deg", "degree", "degrees", "grad", "rad"):
            found = Quantity.ANGLE
        unknown += found is None and bool(text)
        out.append(found or Quantity.OTHER)
    return out, unknown


def _in_mm(
    long: Long,
    read: Mapping[_Column, Numbers],
    quantities: Sequence[Quantity],
    row_units: Sequence[str],
    unit: Unit | None,
) -> tuple[dict[_Column, Array], Unit | None]:
    """Every column by its own unit, else by that of the row, else by that of all; and the unit of the actual values."""
    angle = np.array([quantity is Quantity.ANGLE for quantity in quantities], dtype=bool)
    out: dict[_Column, Array] = {}
    of_actual: Unit | None = unit
    for column, numbers in read.items():
        role = Role(column) if column in LENGTHS else Role.TOLERANCE
        own = long.units.get(role) or ("" if role is Role.TOLERANCE else unit_of_cells(long, role, numbers))
        factors = np.full(len(long), np.nan)
        for of_angles in (False, True):
            each = [own] if own else row_units or [unit or ""]
            table = {name: factor_of(name or unit or "", of_angles) for name in set(each)}
            if of_angles:
                table = {name: 1.0 if factor is None else factor for name, factor in table.items()}
            values = np.array([table[name] if table[name] is not None else np.nan for name in each], dtype=float)
            factors = np.where(angle == of_angles, values if len(values) > 1 else values[0], factors)
        for row, name in numbers.units.items() if role is Role.TOLERANCE else ():
            factors[row] = factor_of(name, bool(angle[row])) or np.nan  # ±0.02 mm and ±1° may be in one column
        missing = ~np.isnan(numbers.values) & np.isnan(factors)
        if np.any(missing):
            raise no_unit(long, role, int(np.argmax(missing)), own)
        out[column] = numbers.values * factors
        lengths = factors[~angle]
        if role in (Role.ACTUAL, Role.DEVIATION, Role.X) and len(lengths) and of_actual is None:
            of_actual = "inch" if lengths[0] == factor_of("inch", False) else "mm"
    return out, of_actual


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
        raise _unknown(long, Role.LOWER_TOLERANCE, row, 'lower_tolerance = "with its sign" or "without its sign"')
    if sign == "without its sign":
        low = -low
        remarks.append(
            Remark("lower tolerances are printed without their sign: they are taken below the nominal value")
        )
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


def _rounding(long: Long, unit: Unit | None) -> float:
    """By how much deviation and actual − nominal may differ; a nominal value of few digits is not rounded to them."""
    actual, nominal, deviation = (_half_digit(long, role, unit) for role in (Role.ACTUAL, Role.NOMINAL, Role.DEVIATION))
    return deviation + actual + min(actual, nominal)


def _half_digit(long: Long, role: Role, unit: Unit | None) -> float:
    """Half the last digit of a column, in mm; of a workbook, whose numbers are not rounded, what a float loses."""
    texts = [text for text in long.texts.get(role, ())[:1000] if text]
    places = max((len(text.replace(",", ".").partition(".")[2]) for text in texts), default=9)
    factor = factor_of(long.units.get(role) or unit or "mm", False) or 1.0
    return max(0.5 * 10.0 ** -min(places, 9), 1e-9) * factor


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
