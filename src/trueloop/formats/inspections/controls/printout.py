"""Print-outs of Renishaw's Inspection Plus macros, and the results files that carry such lines and points.

    COMPONENT NO 1                    FEATURE NO 2
    SIZE D25.0000   ACTUAL 25.0132  TOL 0.0500  DEV 0.0132
              +++++OUT OF TOL+++++ ERROR  0.0032

SIZE is a diameter where D stands before its nominal value, else a width; POSN is a coordinate; ANG an angle in degrees;
TOL is relative to the nominal value, TOL TP the diameter of a position's zone. The component number counts parts at the
control: it is not a serial number. G800 is a nominal point with its normal and limits, G801 the ball's centre where it
was touched, with the ball's radius. Read in public sources that write such files; nothing here is from memory but that
TOL TP is a diameter.
"""

import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Literal

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Vector
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.controls.meaning import MM_PER, Meaning, inspection_of, meaning_of, unit_of
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.checks import filled_in, half_digits, stated_deviations
from trueloop.formats.inspections.shared.text import beginning, number_in, read_decoded

N: Final = r"([-+]?\s*(?:\d+\.?\d*|\.\d+)|NaN)"
HEADING: Final = re.compile(r"\s*COMPONENT\s+NO\.?\s*(\d+)\s+FEATURE\s+NO\.?\s*(\d+)\s*", re.IGNORECASE)
ROW: Final = re.compile(
    rf"\s*(SIZE|POSN|ANG)\s+([A-Z]?)\s*{N}\s+ACTUAL\s+{N}(?:\s+TOL\s+(TP\s+)?{N})?\s+DEV\s+{N}\s*", re.IGNORECASE
)
OUT: Final = re.compile(r"\s*\+{2,}\s*(?:ANG\s+)?OUT OF (?:TOL|POS)\s*\+{2,}.*", re.IGNORECASE)
POINT: Final = re.compile(r"\s*G(800|801)\s+N\s*(\d+)\s+(.*?)\s*", re.IGNORECASE)
WORD: Final = re.compile(rf"([A-Z])\s*{N}", re.IGNORECASE)
PASSED: Final = re.compile(
    r"\s*(?:%|-+|START|END|(?:RESULTSFILE|DOCUMENTID|MODELVERSION|TIMESTAMP|TOOLPATHID|TOOLPATH|CYCLEDEPTH|G330|G331)\b"
    r".*)?\s*",
    re.IGNORECASE,
)
AXES: Final[dict[str, Literal["x", "y", "z"]]] = {"X": "x", "Y": "y", "Z": "z"}


@dataclass
class _Component:
    """The values of one part, while its lines are read."""

    number: str
    readings: list[Reading] = field(default_factory=list)
    points: list[CmmPoint] = field(default_factory=list)
    balls_mm: set[float] = field(default_factory=set)


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether a line is a heading, a row or a point of such a print-out."""
    lines = beginning(head).splitlines()
    return any(HEADING.fullmatch(line) or ROW.fullmatch(line) or POINT.fullmatch(line) for line in lines)


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads one inspection for each component number. Raises MSR-UNIT, MSR-VALUE for a point without its other half."""
    text, encoding = read_decoded(path)
    meaning = meaning_of(stated)
    unit = unit_of(stated, meaning, path)
    reader = _Reader(path, MM_PER[unit])
    for number, line in enumerate(text.splitlines(), 1):
        reader.line(line, number)
    reader.require_no_half()
    parts = tuple(
        _inspection(path, meaning, component)
        for component in reader.components
        if component.readings or component.points
    )
    reader.remarks += [*stated_deviations(reader.stated), *filled_in(parts)]
    if len(parts) > 1:
        reader.remarks.append(Remark(f"{len(parts)} component numbers: each is taken for a part of its own"))
    return MeasuredFile(path, FORMAT.name, encoding, unit, parts, remarks=tuple(reader.remarks))


FORMAT: Final = Format("print-out of Renishaw macros", recognises, read)


class _Reader:
    """Reads line by line: what feature a row is of stands in a heading above it."""

    def __init__(self, path: Path, mm_per_unit: float) -> None:
        self.path, self.mm = path, mm_per_unit
        self.components: list[_Component] = [_Component("")]
        self.remarks: list[Remark] = []
        self.feature = ""
        self.stated: list[tuple[Reading, float, float]] = []
        self.nominal: tuple[str, dict[str, float], int] | None = None

    def line(self, line: str, number: int) -> None:
        """Parses one line of the printout."""
        if point := POINT.fullmatch(line):
            self._point(point, number)
        elif heading := HEADING.fullmatch(line):
            if self.components[-1].number != heading[1]:
                self.components.append(_Component(heading[1]))
            self.feature = heading[2]
        elif row := ROW.fullmatch(line):
            self._row(row, number)
        elif OUT.fullmatch(line) is None and PASSED.fullmatch(line) is None:
            self.remarks.append(Remark(f"not understood: {line.strip()[:60]!r}", number))

    def require_no_half(self) -> None:
        """Raises MSR-VALUE for a nominal point that was not measured at the file's end."""
        if self.nominal is not None:
            raise self._refusal(f"G800 N{self.nominal[0]} has no G801", self.nominal[2])

    def _row(self, row: re.Match[str], number: int) -> None:
        kind, letter, tp = row[1].upper(), row[2].upper(), row[5]
        nominal, actual, tolerance, deviation = (self._number(row[k], number) for k in (3, 4, 6, 7))
        if not math.isfinite(actual) or not math.isfinite(nominal):
            self.remarks.append(Remark(f"feature {self.feature}: {kind} {letter} was not measured", number))
            return
        quantity, scale = self._quantity(kind, letter)
        # The zone of a position is a circle: no limits of one coordinate.
        limit = None if tp or not math.isfinite(tolerance) else abs(tolerance) * scale
        reading = Reading(
            characteristic=f"{self.feature} {kind} {letter}".strip(),
            quantity=quantity,
            actual=actual * scale,
            nominal=nominal * scale,
            lower_limit=None if limit is None else nominal * scale - limit,
            upper_limit=None if limit is None else nominal * scale + limit,
            feature=self.feature,
            axis=AXES.get(letter, "") if quantity is Quantity.POSITION else "",
            line=number,
        )
        self.components[-1].readings.append(reading)
        self.stated.append((reading, deviation * scale, half_digits(row[3], row[4], row[7]) * scale))

    def _quantity(self, kind: str, letter: str) -> tuple[Quantity, float]:
        if kind == "ANG":
            return Quantity.ANGLE, 1.0
        if kind == "POSN":
            return Quantity.POSITION, self.mm
        return {"D": Quantity.DIAMETER, "R": Quantity.RADIUS}.get(letter, Quantity.LENGTH), self.mm

    def _point(self, point: re.Match[str], number: int) -> None:
        words = {match[1].upper(): self._number(match[2], number) for match in WORD.finditer(point[3])}
        if missing := sorted(set("XYZIJK" if point[1] == "800" else "XYZR") - set(words)):
            raise self._refusal(f"G{point[1]} N{point[2]} has no {' and no '.join(missing)}", number)
        if not all(map(math.isfinite, words.values())):
            raise self._refusal(f"G{point[1]} N{point[2]} has a value that is no number", number)
        if point[1] == "800":
            self.require_no_half()
            self.nominal = point[2], words, number
            return
        if self.nominal is None or self.nominal[0] != point[2]:
            raise self._refusal(f"G801 N{point[2]} has no G800 before it", number)
        at, self.nominal = self.nominal[1], None
        normal = (at["I"], at["J"], at["K"])
        size = math.hypot(*normal)
        if size == 0.0:
            raise self._refusal(f"G800 N{point[2]} has a normal without length", number)
        outward: Vector = (normal[0] / size, normal[1] / size, normal[2] / size)
        part = self.components[-1]
        part.balls_mm.add(words["R"] * self.mm)
        part.points.append(CmmPoint(self._at(words), self._at(at), outward, point[2]))

    def _number(self, text: str | None, line: int) -> float:
        """A number, blanks behind its sign; nan for one that is not there. Raises MSR-NUMBER."""
        return math.nan if text is None or text.lower() == "nan" else number_in("".join(text.split()), self.path, line)

    def _at(self, words: dict[str, float]) -> Vector:
        return words["X"] * self.mm, words["Y"] * self.mm, words["Z"] * self.mm

    def _refusal(self, why: str, line: int) -> TrueloopError:
        return Code.MSR_VALUE.refusal(
            f"{self.path.name!r}: {why}",
            hint="send the results again; each point is a G800 line and a G801 line of one number",
            place=Place(str(self.path), line),
        )


def _inspection(path: Path, meaning: Meaning, component: _Component) -> Inspection:
    """Raises MSR-VALUE for points touched with balls of several sizes: an inspection has one."""
    if len(component.balls_mm) > 1:
        raise Code.MSR_VALUE.refusal(
            f"{path.name!r}: its points were touched with balls of {len(component.balls_mm)} radii, "
            f"{min(component.balls_mm):.4f} mm to {max(component.balls_mm):.4f} mm",
            hint="split the file by the probe that was used",
            place=Place(str(path)),
        )
    ball_mm = next(iter(component.balls_mm), 0.0)
    return inspection_of(path, meaning, component.readings, component.points, ball_radius_mm=ball_mm)
