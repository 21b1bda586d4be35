"""Inspections as a DMIS result file: nominal and actual features, tolerances and what was found of them.

Points, diameters, radii and coordinates are features of DMIS, lengths distances; every other characteristic is a
`USETOL` that names its quantity, for DMIS has no word that leaves open which form or angle is meant.

A DMIS inspection program of a turned part: points with their normals, and diameters of circles.

The part's frame has to be in force: z along the axis, away from the chuck, points turned from x to y. Between touches
the ball is led by GOTO; `SNSET/CLRSRF` is left out, because a retreat along one axis may lead through a collar. From
files and manuals seen: DMISMN, UNITS, MODE, SNSET, FEAT, TOL/DIAM, MEAS, PTMEAS, GOTO/CART, ENDMES, OUTPUT, TEXT/OPER,
ENDFIL. From memory of DMIS 5.2: DISPLY/STOR,DMIS and PRCOMP.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.errors import Code
from trueloop.formats.inspections.dmis.features import NOWHERE, Some
from trueloop.probing.cmm_plan import CmmApproach, CmmMove, way_back

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
    return statements_text([line for inspection in inspections for line in _run(inspection, file)] + ["ENDFIL"])


def _run(inspection: Inspection, file: str) -> Iterator[str]:
    if inspection.ball_radius_mm > 0.0 or inspection.touches:
        raise Code.MSR_FORMAT.refusal(
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
    yield f"OUTPUT/{','.join([*(f'F({feature})' for feature in features), f'T({name})'])}"
    yield f"T({name})=TOL/{what},{'NOMINL,' if distance else ''}{_fields([reading.nominal, *limits])}"
    yield f"OUTPUT/{','.join([*(f'FA({feature})' for feature in features), f'TA({name})'])}"
    yield f"TA({name})=TOL/{what},{_field(reading.actual)}{_verdict(reading)}"


def _is_plain(reading: Reading) -> bool:
    """Returns whether a distance cannot be mistaken for a deviation: it is nearer to its nominal than to 0."""
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


WIDTH: Final = 78
"""Characters of a line; the standard allows 80 of one, from memory."""


def statements_text(statements: Iterable[str]) -> str:
    """Statements as lines, long ones continued by `$` behind a comma."""
    return "\n".join(line for statement in statements for line in _lines(statement)) + "\n"


def comment(text: str) -> str:
    """Returns a comment line; what would continue it or end it is left out."""
    return "$$ " + " ".join(text.replace("$", " ").split())


def quoted(text: str) -> str:
    """Returns a text in quotes, on one line."""
    return "'" + " ".join(text.splitlines()).replace("'", "''") + "'"


def number(value: float, decimals: int = 4) -> str:
    """Returns a number with at most so many decimals, never `-0`."""
    text = f"{round(value, decimals) + 0.0:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def numbers(values: Iterable[float], decimals: int = 4) -> str:
    """Returns numbers joined by commas."""
    return ",".join(number(value, decimals) for value in values)


class Labels:
    """Labels for names: letters, digits, `_` and `-`, beginning with a letter, no two alike in capitals."""

    def __init__(self) -> None:
        self._taken: dict[str, int] = {}

    def new(self, name: str, prefix: str = "P") -> str:
        """Returns an unused label like the name."""
        label = re.sub(r"[^A-Za-z0-9_-]", "_", name) or prefix
        label = label if label[0].isalpha() else prefix + label
        count = self._taken[label.upper()] = self._taken.get(label.upper(), 0) + 1
        return label if count == 1 else self.new(f"{label}_{count}", prefix)


def _lines(statement: str) -> Iterable[str]:
    while len(statement) > WIDTH and not statement.startswith("$$"):
        cut = statement.rfind(",", 0, WIDTH - 1) + 1 or WIDTH - 1
        yield statement[:cut] + "$"
        statement = statement[cut:]
    yield statement


NORMAL_DECIMALS = 6


@dataclass(frozen=True)
class MeasuredCircle:
    """A diameter to be measured as a circle of touches at one z; limits are those of the characteristic."""

    characteristic: Characteristic
    z_mm: float
    moves: tuple[CmmMove, ...]


def dmis_program(
    name: str, points: Sequence[CmmMove], circles: Sequence[MeasuredCircle], approach: CmmApproach, source: str
) -> str:
    """Returns the program, in mm. Every point and circle is measured and output, with its tolerance if it has one."""
    labels, lines = Labels(), _heading(name, approach, source)
    for move in points:
        lines += _point_to_touch(labels.new(move.touch.name), move)
    for circle in circles:
        lines += _circle(labels.new(circle.characteristic.name, "D"), circle)
    moves = [*points, *(move for circle in circles for move in circle.moves)]
    return statements_text([*lines, *(_goto(position) for position in way_back(moves)), "ENDFIL"])


def _heading(name: str, approach: CmmApproach, source: str) -> list[str]:
    return [
        f"DMISMN/{quoted(name)},05.2",
        comment(f"inspection program made by trueloop from {source}"),
        comment("part coordinates: z along the axis away from the chuck, origin as on the drawing, y = 0 at 0 degrees"),
        comment(
            f"moves for a ball of {number(2 * approach.ball_radius_mm)} mm; {number(approach.clearance_mm)} mm stay "
            "free around the part; the stem is not looked at"
        ),
        "UNITS/MM,ANGDEC",
        "DISPLY/STOR,DMIS",
        "TEXT/OPER,'Align the part first: the moves are in its coordinates'",
        "PRCOMP/ON",
        f"SNSET/APPRCH,{number(approach.approach_mm)}",
        f"SNSET/RETRCT,{number(approach.approach_mm)}",
        "MODE/PROG,MAN",
    ]


def _point_to_touch(label: str, move: CmmMove) -> list[str]:
    place = f"{numbers(move.touch.nominal_mm)},{numbers(move.touch.outward_normal, NORMAL_DECIMALS)}"
    return [
        comment(f"{move.touch.name} on {move.touch.feature}"),
        f"F({label})=FEAT/POINT,CART,{place}",
        *map(_goto, move.way_mm),
        f"MEAS/POINT,F({label}),1",
        f"PTMEAS/CART,{place}",
        "ENDMES",
        f"OUTPUT/FA({label})",
    ]


def _circle(label: str, circle: MeasuredCircle) -> list[str]:
    asked = circle.characteristic
    nominal = asked.nominal
    limits = [number(one - nominal) for one in (asked.lower_limit, asked.upper_limit) if one is not None]
    stated = len(limits) == 2  # DMIS has no word for a limit on one side alone
    touches = [
        line
        for move in circle.moves
        for line in (
            *map(_goto, move.way_mm),
            f"PTMEAS/CART,{numbers(move.touch.nominal_mm)},{numbers(move.touch.outward_normal, NORMAL_DECIMALS)}",
        )
    ]
    return [
        comment(f"{asked.name}: {asked.quantity} of {asked.feature}"),
        f"F({label})=FEAT/CIRCLE,OUTER,CART,0,0,{number(circle.z_mm)},0,0,1,{number(nominal)}",
        *([f"T({label})=TOL/DIAM,{','.join(limits)}"] if stated else []),
        f"MEAS/CIRCLE,F({label}),{len(circle.moves)}",
        *touches,
        "ENDMES",
        f"OUTPUT/FA({label}),TA({label})" if stated else f"OUTPUT/FA({label})",
    ]


def _goto(position: Sequence[float]) -> str:
    return f"GOTO/CART,{numbers(position)}"
