"""A STEP file whose faces carry dimensions and tolerances, written record by record as ISO 10303-47 has them."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.support.solids import written


@dataclass(frozen=True)
class Asked:
    """One dimension or tolerance as a CAD system states it.

    `kind`: "diameter", "linear distance", "angle", "CYLINDRICITY"…; `faces`: numbers of faces, from 0 in the file's
    order; deviations in the file's unit, or a fit such as ("h", "6"), or limits.
    """

    kind: str
    faces: Sequence[int]
    nominal: float = 0.0
    deviations: tuple[float, float] | None = None
    fit: tuple[str, str] | None = None
    limits: tuple[float, float] | None = None


def toleranced(solid: Any, asked: Sequence[Asked], path: Path, unit: str = "MM") -> Path:
    """The solid's file with what is asked put in by the text."""
    text = written(solid, path, unit).read_text()
    lines = _Lines(text)
    for one in asked:
        lines.add(one)
    path.write_text(text.replace("ENDSEC;\nEND-ISO", "\n".join([*lines.new, "ENDSEC;\nEND-ISO"])))
    return path


class _Lines:
    def __init__(self, text: str) -> None:
        self.new: list[str] = []
        self.next = 1 + max(int(n) for n in re.findall(r"^#(\d+) =", text, re.M))
        self.faces = [int(n) for n in re.findall(r"^#(\d+) = ADVANCED_FACE", text, re.M)]
        self.shape = int(re.findall(r"^#(\d+) = PRODUCT_DEFINITION_SHAPE", text, re.M)[0])
        self.brep = int(re.findall(r"^#(\d+) = ADVANCED_BREP_SHAPE_REPRESENTATION", text, re.M)[0])
        units = [at.start() for at in re.finditer(r"LENGTH_UNIT\(\)", text)]
        before = {at: re.findall(r"#(\d+) = \(\s*(CONVERSION_BASED_UNIT|LENGTH_UNIT)", text[: at + 20]) for at in units}
        inch = [found[-1][0] for found in before.values() if found[-1][1] == "CONVERSION_BASED_UNIT"]
        self.unit = int(inch[0] if inch else before[units[0]][-1][0])

    def record(self, text: str) -> int:
        self.new.append(f"#{self.next} = {text};")
        self.next += 1
        return self.next - 1

    def aspect(self, face: int) -> int:
        aspect = self.record(f"SHAPE_ASPECT('','',#{self.shape},.T.)")
        self.record(f"GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#{aspect},#{self.brep},#{self.faces[face]})")
        return aspect

    def measure(self, value: float, name: str, unit: int) -> int:
        measure = f"MEASURE_WITH_UNIT(LENGTH_MEASURE({value!r}),#{unit})"
        return self.record(
            f"( LENGTH_MEASURE_WITH_UNIT() MEASURE_REPRESENTATION_ITEM() {measure} REPRESENTATION_ITEM('{name}') )"
        )

    def degrees(self) -> int:
        radian = self.record("( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) )")
        one = self.record(f"PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.0174532925199433),#{radian})")
        return self.record(f"( CONVERSION_BASED_UNIT('DEGREE',#{one}) NAMED_UNIT(*) PLANE_ANGLE_UNIT() )")

    def add(self, asked: Asked) -> None:
        aspects = [self.aspect(face) for face in asked.faces]
        if asked.kind.isupper():
            width = self.record(f"LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE({asked.nominal!r}),#{self.unit})")
            self.record(f"{asked.kind}_TOLERANCE('','',#{width},#{aspects[0]})")
            return
        unit = self.degrees() if asked.kind == "angle" else self.unit
        if len(aspects) == 2:
            dimension = self.record(f"DIMENSIONAL_LOCATION('{asked.kind}',$,#{aspects[0]},#{aspects[1]})")
        elif asked.kind == "angle":
            dimension = self.record(f"ANGULAR_SIZE(#{aspects[0]},'',.SMALL.)")
        else:
            dimension = self.record(f"DIMENSIONAL_SIZE(#{aspects[0]},'{asked.kind}')")
        items = [self.measure(asked.nominal, "nominal value", unit)]
        if asked.limits:
            named = zip(asked.limits, ("lower limit", "upper limit"), strict=True)
            items += [self.measure(value, name, unit) for value, name in named]
        shape = self.record(f"SHAPE_DIMENSION_REPRESENTATION('',({','.join(f'#{i}' for i in items)}),#{self.brep})")
        self.record(f"DIMENSIONAL_CHARACTERISTIC_REPRESENTATION(#{dimension},#{shape})")
        if asked.fit:
            fit, grade = asked.fit
            which = "shaft" if fit.islower() else "hole"
            zone = self.record(f"LIMITS_AND_FITS('{fit}','{which}','{grade}','')")
        elif asked.deviations:
            low, high = (self.record(f"MEASURE_WITH_UNIT(LENGTH_MEASURE({v!r}),#{unit})") for v in asked.deviations)
            zone = self.record(f"TOLERANCE_VALUE(#{low},#{high})")
        else:
            return
        self.record(f"PLUS_MINUS_TOLERANCE(#{zone},#{dimension})")
