"""Inspections as a DMIS result file: nominal and actual features, tolerances and what was found of them.

Points, diameters, radii and coordinates are features of DMIS, lengths distances; every other characteristic is a
`USETOL` that names its quantity, for DMIS has no word that leaves open which form or angle is meant.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.errors import Code, TrueloopError
from trueloop.formats.inspections.dmis.features import NOWHERE, Some
from trueloop.formats.inspections.dmis.writing import comment, number, numbers, quoted, statements_text

DECIMALS: Final = 7
"""Decimals of lengths in mm, enough that inches come back to their last decimal."""
AXES: Final = ("x", "y", "z")
SIDES: Final = {"": "", "inner": "INNER,", "outer": "OUTER,"}
NOT_IN_LABELS: Final = str.maketrans("()=,'$/\r\n\t", "__________")


def dmis_results(inspections: Sequence[Inspection], file: str) -> str:
    """Returns the file's text, in mm; a run for each inspection, read back unchanged, except what DMIS cannot state.

    These are standard uncertainty, temperature and the time of a single reading. Raises MSR-FORMAT for centres of a
    ball and for touches: DMIS has points of the surface.
    """
    return statements_text([line for one in inspections for line in _run(one, file)] + ["ENDFIL"])


def _run(inspection: Inspection, file: str) -> Iterator[str]:
    if inspection.ball_radius_mm > 0.0 or inspection.touches:
        raise TrueloopError(
            Code.MSR_FORMAT,
            f"{len(inspection.values)} values are centres of a ball or touches: DMIS has points of the surface alone",
            hint="write them as QIF: name the output .qif",
            values={"file": file},
        )
    part = inspection.part
    yield f"FILNAM/{quoted(file)},05.2"
    yield "UNITS/MM,ANGDEC"
    if inspection.frame != "part":
        yield comment(f"counted from the zero of the {inspection.frame}")
    for statement, text in (
        ("PN(PART)=PARTID", part.part_type.name),
        ("PR(PART)=PARTRV", part.part_type.revision),
        ("PS(PART)=PARTSN", part.serial),
        ("DI(DEVICE)=DMEID", inspection.device),
        ("OP(OPERATOR)=OPERID", inspection.operator),
    ):
        if text:
            yield f"{statement}/{quoted(text)}"
    if inspection.measured_at is not None:
        yield f"DATE={inspection.measured_at:%Y/%m/%d}"
        yield f"TIME={inspection.measured_at:%H:%M:%S}"
    for value in inspection.values:
        yield from _point(value) if isinstance(value, CmmPoint) else _reading(value)  # type: ignore[arg-type]


def _point(point: CmmPoint) -> Iterator[str]:
    label = point.name.translate(NOT_IN_LABELS)
    normal = "" if point.outward_normal is None else "," + numbers(point.outward_normal, DECIMALS)
    if point.nominal_mm is not None:
        yield f"OUTPUT/F({label})"
        yield f"F({label})=FEAT/POINT,CART,{numbers(point.nominal_mm, DECIMALS)}{normal}"
    yield f"OUTPUT/FA({label})"
    yield f"FA({label})=FEAT/POINT,CART,{numbers(point.measured_mm, DECIMALS)}{normal}"


def _reading(reading: Reading) -> Iterator[str]:
    limited = reading.lower_limit is not None or reading.upper_limit is not None
    if reading.nominal is None and limited:  # a feature's limits are counted from its nominal
        yield from _other(reading)
    elif reading.quantity in (Quantity.DIAMETER, Quantity.RADIUS):
        yield from _size(reading)
    elif reading.quantity is Quantity.POSITION and reading.axis:
        yield from _coordinate(reading)
    else:
        yield from _other(reading)


def _size(reading: Reading) -> Iterator[str]:
    """A circle or an arc that states nothing else."""
    kind, what = ("CIRCLE", "DIAM") if reading.quantity is Quantity.DIAMETER else ("ARC", "RAD")
    feature = f"FEAT/{kind},{SIDES[reading.side]}CART"
    nominal = f"{feature},{_fields(_place(reading))},,,,{_field(reading.nominal)}"
    yield from _block(reading, nominal, f"{feature},,,,,,,{_field(reading.actual)}", what)


def _coordinate(reading: Reading) -> Iterator[str]:
    """One coordinate of a circle that states nothing else."""
    axis = AXES.index(reading.axis)
    actual, nominal = list(NOWHERE), list(_place(reading))
    actual[axis], nominal[axis] = reading.actual, reading.nominal
    feature = f"FEAT/CIRCLE,{SIDES[reading.side]}CART"
    ending = ",,,,"
    yield from _block(
        reading,
        f"{feature},{_fields(nominal)}{ending}",
        f"{feature},{_fields(actual)}{ending}",
        f"CORTOL,{reading.axis.upper()}AXIS",
    )


def _block(reading: Reading, nominal: str, actual: str, what: str) -> Iterator[str]:
    label, name = reading.feature.translate(NOT_IN_LABELS), reading.characteristic.translate(NOT_IN_LABELS)
    limits = _relative(reading)
    yield f"OUTPUT/F({label}),T({name})"
    yield f"F({label})={nominal}"
    yield f"T({name})=TOL/{what},{_fields(limits)}"
    yield f"OUTPUT/FA({label}),TA({name})"
    yield f"FA({label})={actual}"
    if reading.nominal is not None:
        yield f"TA({name})=TOL/{what},{_field(reading.actual - reading.nominal)}{_verdict(reading)}"


def _other(reading: Reading) -> Iterator[str]:
    """A distance, or what DMIS leaves to its user."""
    name = reading.characteristic.translate(NOT_IN_LABELS)
    features = [one.translate(NOT_IN_LABELS) for one in (reading.feature, reading.other) if one]
    distance = reading.quantity is Quantity.LENGTH and reading.nominal is not None and _is_plain(reading)
    what = "DISTB" if distance else f"USETOL,{quoted(reading.quantity.name)}"
    limits = _relative(reading) if distance else (reading.lower_limit, reading.upper_limit)
    yield f"OUTPUT/{','.join([*(f'F({one})' for one in features), f'T({name})'])}"
    yield f"T({name})=TOL/{what},{'NOMINL,' if distance else ''}{_fields([reading.nominal, *limits])}"
    yield f"OUTPUT/{','.join([*(f'FA({one})' for one in features), f'TA({name})'])}"
    yield f"TA({name})=TOL/{what},{_field(reading.actual)}{_verdict(reading)}"


def _is_plain(reading: Reading) -> bool:
    """Whether a distance cannot be mistaken for a deviation: it is nearer to its nominal than to 0."""
    return reading.nominal is not None and abs(reading.actual) > abs(reading.actual - reading.nominal)


def _place(reading: Reading) -> Some:
    """Where it was read: x, y, z; of a turned part z alone, or x and z."""
    place = reading.place_mm
    if len(place) == 3:
        return place[0], place[1], place[2]
    if len(place) == 2:
        return place[0], 0.0, place[1]
    return (0.0, 0.0, place[0]) if place else NOWHERE


def _relative(reading: Reading) -> tuple[float | None, float | None]:
    """The limits as DMIS has them: counted from the nominal value, which has to be known."""
    nominal = reading.nominal
    if nominal is None:
        return None, None
    lower, upper = reading.lower_limit, reading.upper_limit
    return None if lower is None else lower - nominal, None if upper is None else upper - nominal


def _verdict(reading: Reading) -> str:
    lower, upper = reading.lower_limit, reading.upper_limit
    if lower is None and upper is None:
        return ""
    inside = (lower is None or reading.actual >= lower) and (upper is None or reading.actual <= upper)
    return ",INTOL" if inside else ",OUTOL"


def _field(value: float | None) -> str:
    return "" if value is None else number(value, DECIMALS)


def _fields(values: Iterable[float | None]) -> str:
    return ",".join(_field(value) for value in values)
