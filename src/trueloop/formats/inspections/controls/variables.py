"""Dumps of a control's variables, Fanuc's `#500`, Siemens' `R1` and `_OVR[4]`, Heidenhain's `Q150`, Okuma's `VC1`.

What a variable holds is stated by a mapping: no dump says it. Read in a manual: which of `_OVR` holds what depends on
the cycle. From memory: the layout of the dumps, and the expressions that old Fanuc controls write for a value, such as
`[25283*65536+65536]/134217728` for 12.3457: numbers, + − * / and [ ], nothing else.
"""

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import CmmPoint, Reading
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.controls.meaning import (
    MM_PER,
    VariableTable,
    inspection_of,
    meaning_of,
    not_stated,
    reading_of,
    unit_of,
)
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.text import MOST, beginning, read_decoded
from trueloop.wording import first_of

NUMBER: Final = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
PLAIN: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)")
TWO_SIGNS: Final = re.compile(r"(?:^|[-+*/\[])\s*[-+]\s*[-+]")
OPERATIONS: Final[Mapping[type[ast.operator], Callable[[float, float], float]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
DEEPEST: Final = 20
"""No control writes brackets as deep."""


def value_of(text: str) -> float | None:
    """Returns the value of an expression; None for what is none, divides by zero, or is beyond `MOST`."""
    if PLAIN.fullmatch(text):
        return float(text) if abs(float(text)) <= MOST else None
    depths = accumulate((one == "[") - (one == "]") for one in text)
    if set(NUMBER.sub("", text)) - set("+-*/[] \t") or TWO_SIGNS.search(text) or max(depths, default=0) > DEEPEST:
        return None
    written = NUMBER.sub(lambda found: repr(float(found[0])), text).translate({ord("["): "(", ord("]"): ")"})
    try:
        value = _value(ast.parse(written.strip(), mode="eval").body)
    except (SyntaxError, ValueError, ZeroDivisionError, OverflowError, RecursionError, MemoryError):
        return None
    return value if abs(value) <= MOST else None


def _value(node: ast.expr) -> float:
    """The value of a sum or product of numbers. Raises ValueError for anything else."""
    match node:
        case ast.Constant(value=float(value)):
            return value
        case ast.UnaryOp(op=ast.UAdd() | ast.USub(), operand=operand):
            return -_value(operand) if isinstance(node.op, ast.USub) else _value(operand)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATIONS:
            return OPERATIONS[type(op)](_value(left), _value(right))
    raise ValueError(ast.dump(node))


START: Final = re.compile(r"((?:#|\b[RQ]|\bVC)\d+|\b_OV[RI]\[\d+\]|\bR\[\d+\])\s*=\s*", re.IGNORECASE)
NUMBERED: Final = re.compile(r"\s*/?(?:N\d+\s*)?", re.IGNORECASE)
COMMENT: Final = re.compile(r"\([^()]*\)|;.*")
EMPTY: Final = re.compile(r"#0|(?:DATA )?EMPTY|VACANT|NULL|\*+|", re.IGNORECASE)
SKIPPED: Final = re.compile(r"\s*(?:%.*|[O:]\d+|SETVN.*|M\d+|RET)?\s*", re.IGNORECASE)
"""Ends of a tape, the number of a program, names of variables, ends of a program."""


@dataclass(frozen=True)
class Variable:
    """A variable as it stands in a dump; None: it is empty, which is not 0."""

    name: str
    value: float | None
    line: int


def bare(line: str) -> str:
    """Returns a line with blanks for its comments."""
    return COMMENT.sub(lambda found: " " * len(found[0]), line) if "(" in line or ";" in line else line


def is_skipped(line: str) -> bool:
    """Returns whether a bare line has nothing to read."""
    return SKIPPED.fullmatch(line) is not None


def is_assignment(line: str) -> bool:
    """Returns whether a bare line begins with an assignment."""
    at = NUMBERED.match(line)
    return START.match(line, at.end() if at else 0) is not None


def variables_in(text: str, path: Path) -> tuple[list[Variable], list[Remark]]:
    """Returns all assignments in order, and other lines as remarks. Raises MSR-NUMBER for a value that is not a
    number.
    """
    found: list[Variable] = []
    remarks: list[Remark] = []
    for number, line in enumerate(text.splitlines(), 1):
        statement = bare(line)
        if is_assignment(statement):
            found += _assigned(statement, path, number)
        elif not is_skipped(statement):
            remarks.append(Remark(f"not understood: {line.strip()[:60]!r}", number))
    return found, remarks


def key_of(name: str) -> str:
    """Returns the key of a variable's name as a mapping may write it: `500` is `#500`, `R[1]` is `R1`."""
    plain = re.sub(r"\bR\[(\d+)\]", r"R\1", "".join(name.upper().split()))
    return f"#{plain}" if plain.isdigit() else plain


def _assigned(line: str, path: Path, number: int) -> Iterator[Variable]:
    starts = list(START.finditer(line))
    for start, following in zip(starts, [*(match.start() for match in starts[1:]), len(line)], strict=True):
        text = line[start.end() : following].strip()
        value = None if EMPTY.fullmatch(text) else value_of(text)
        if value is None and not EMPTY.fullmatch(text):
            raise Code.MSR_NUMBER.refusal(
                f"{start[1]} is {text!r}: no number, and no expression of numbers, + - * / and [ ]",
                hint="is the file whole? Take the line out, or send the variables again",
                place=Place(str(path), number, start.end() + 1),
                values={"text": text},
            )
        yield Variable(start[1], value, number)


EXAMPLE: Final = ('unit = "mm"', "[variables.500]", 'feature = "journal"', 'quantity = "diameter"', "z = -20.0")


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether all but a few of its first lines assign a value to a variable."""
    lines = [bare(line) for line in beginning(head).splitlines()[:200]]
    spoken = [line for line in lines if not is_skipped(line)]
    return bool(spoken) and sum(map(is_assignment, spoken)) > 0.8 * len(spoken)


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the variables that the mapping gives a meaning, as readings and points of one part.

    Raises MSR-MEANING without a mapping, MSR-VALUE for a variable that it names and the dump has not, or with two
    values, MSR-NUMBER for a value that is not a number, MSR-UNIT, MSR-MAPPING.
    """
    text, encoding = read_decoded(path)
    found, remarks = variables_in(text, path)
    meaning = meaning_of(stated)
    if not meaning.variables:
        names = first_of([variable.name for variable in found], 6)
        raise not_stated(path, f"what its {len(found)} variables hold is not stated: {names}", EXAMPLE, found[0].line)
    unit = unit_of(stated, meaning, path)
    dump = _Dump(path, found, meaning.variables, MM_PER[unit])
    ball_mm = (meaning.log.ball_radius if meaning.log else 0.0) * MM_PER[unit]
    inspection = inspection_of(path, meaning, dump.readings(), dump.points(), ball_radius_mm=ball_mm)
    return MeasuredFile(
        path, FORMAT.name, encoding, unit, (inspection,), remarks=(*remarks, *dump.empty(), *dump.others())
    )


FORMAT: Final = Format("variables of a control", recognises, read)


@dataclass(frozen=True)
class _Dump:
    """The variables of a dump, and what they hold; lengths are multiplied by `mm_per_unit`."""

    path: Path
    found: list[Variable]
    tables: Mapping[str, VariableTable]
    mm_per_unit: float

    def readings(self) -> list[Reading]:
        """Returns readings of all variables that are not a coordinate of a point and not empty."""
        sizes = [(name, table, self._variable(name)) for name, table in self.tables.items() if not table.point]
        return [
            self._reading(name, table, variable.value, variable.line)
            for name, table, variable in sizes
            if variable.value is not None
        ]

    def points(self) -> list[CmmPoint]:
        """Returns the points with no empty coordinate; without y they lie in the plane of a turned part's touches."""
        points = []
        for point in dict.fromkeys(table.point for table in self.tables.values() if table.point):
            at = self._coordinates(point)
            x, y, z = at["x"], at.get("y", 0.0), at["z"]
            if x is not None and y is not None and z is not None:
                points.append(CmmPoint((x, y, z), name=point))
        return points

    def empty(self) -> list[Remark]:
        """Returns remarks on the variables that are empty: not measured."""
        named = [(name, table, self._variable(name)) for name, table in self.tables.items()]
        return [
            Remark(f"{variable.name} is empty: {table.point or _called(name, table)!r} was not measured", variable.line)
            for name, table, variable in named
            if variable.value is None
        ]

    def others(self) -> list[Remark]:
        """Returns a remark on the variables that the mapping does not name."""
        named = {key_of(name) for name in self.tables} | {key_of(table.nominal_in) for table in self.tables.values()}
        others = [variable for variable in self.found if key_of(variable.name) not in named]
        said = f"{len(others)} of {len(self.found)} variables are not in the mapping"
        return [Remark(said, others[0].line)] if others else []

    def _reading(self, name: str, table: VariableTable, value: float, line: int) -> Reading:
        nominal = self._variable(table.nominal_in).value if table.nominal_in else table.nominal
        if table.holds == "deviation" and nominal is None:
            raise self._refusal(f"{name} is a deviation, and {table.nominal_in}, its nominal value, is empty", line)
        table = table.model_copy(update={"nominal": nominal})
        return reading_of(_called(name, table), table, value, line, mm_per_unit=self.mm_per_unit)

    def _coordinates(self, point: str) -> dict[str, float | None]:
        """A point's coordinates by axis; None where the variable is empty. Raises MSR-VALUE where x or z has none."""
        at: dict[str, float | None] = {}
        for name, table in self.tables.items():
            if table.point == point:
                one = self._variable(name)
                if table.axis in at:
                    raise self._refusal(f"two variables hold {table.axis} of the point {point!r}", one.line)
                at[table.axis] = None if one.value is None else one.value * self.mm_per_unit * _half(table)
        if missing := sorted({"x", "z"} - set(at)):
            raise self._refusal(f"no variable holds {' and '.join(missing)} of the point {point!r}")
        return at

    def _variable(self, name: str) -> Variable:
        """The variable of that name. Raises MSR-VALUE where the dump has none, or two that differ."""
        same = [variable for variable in self.found if key_of(variable.name) == key_of(name)]
        if not same:
            raise self._refusal(f"the mapping names {name!r}, which is not one of its {len(self.found)} variables")
        for variable in same[1:]:
            if variable.value != same[0].value:
                first = f"{same[0].value} in line {same[0].line}"
                raise self._refusal(
                    f"{variable.name} is {first} and {variable.value} in line {variable.line}", variable.line
                )
        return same[0]

    def _refusal(self, why: str, line: int | None = None) -> TrueloopError:
        return Code.MSR_VALUE.refusal(
            f"{self.path.name!r}: {why}",
            hint="correct the mapping, or send the variables again",
            place=Place(str(self.path), line),
        )


def _half(table: VariableTable) -> float:
    """An X that is a diameter is halved: positions inside are radii."""
    return 0.5 if table.x_is == "diameter" else 1.0


def _called(name: str, table: VariableTable) -> str:
    """Returns the name of a characteristic: by its feature, else by its variable."""
    return f"{table.feature} {table.quantity}" if table.feature else key_of(name)
