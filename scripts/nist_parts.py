"""The fourteen parts of [6811] Tables 2–11: their profiles, programs, gauging points and touches.

Each family is built from its example job (`examples/facetst`, `modbas2`, `piecs11`), which is the largest part measured
in metal. A smaller part is the same drawing with a smaller size; its gauging points are rebuilt from "equally spaced
on each feature" [6811 §5.3]; its errors are those of the tables in `examples/nist/`.

Margins. MODBAS2: those of the coordinates printed in [6517] Table 1, all of them round numbers of inches from the
drawing's corners. PIECS11 and FACETST, of which no coordinates are printed: 0.1 in from either end of what the nose
reaches of a feature, as on the domes; one point lies in the middle. That is an assumption.

[6517] NISTIR 6517, A Spline Algorithm for Modeling Cutting Errors on Turning Centers, 2000.
[6811] NISTIR 6811, Process-Intermittent Error Compensation, 2002.
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.domain.inspection import Touch
from trueloop.formats.jobs.job import Job, read_turned_job
from trueloop.formats.jobs.profile_of_job import profile_of_table
from trueloop.geometry.feature import Arc, Feature, Line, Point
from trueloop.geometry.offset import contour_from_centre_path, nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.probing.probe_plan import GaugingPoints, Spacing, equally_spaced
from trueloop.units import MM_PER_INCH, UM_PER_MM

EXAMPLES: Final = Path(__file__).parents[1] / "examples"
ERRORS_CSV: Final = EXAMPLES / "nist" / "nistir-6811-errors.csv"
TABLE1_CSV: Final = EXAMPLES / "nist" / "nistir-6517-table1.csv"
NOSE_RADIUS_IN: Final = 0.03125
ALLOWANCE_IN: Final = 0.01
SIZE_STEP_IN: Final = 0.04
"""By how much the diameter shrinks from one part of a family to the next [6811 A.2–A.4]."""


@dataclass(frozen=True)
class Family:
    """One part design: its tables of combined errors, its largest part, and where it is touched."""

    name: str
    semifinish_table: str
    finish_table: str
    largest_number: int
    largest_in: float
    spacings: Mapping[str, Spacing]
    margins_from_reach: bool = True

    @property
    def folder(self) -> Path:
        """The example of the family."""
        return EXAMPLES / self.name.lower()


@dataclass(frozen=True)
class NistPart:
    """One part: size in inches (the diameter that names it), profile in mm, touches after either cut."""

    family: Family
    number: str
    semifinish_inspection: str
    finish_inspection: str
    size_in: float
    profile: Profile
    semifinish: tuple[Touch, ...]
    finish: tuple[Touch, ...]


def _inches(count: int, start_in: float, end_in: float) -> Spacing:
    return Spacing(count, start_in * MM_PER_INCH, end_in * MM_PER_INCH)


FAMILIES: Final = (
    Family(
        "FACETST",
        "4",
        "7",
        14,
        5.62,
        {"large-cylinder": Spacing(4), "step-face": Spacing(4), "small-cylinder": Spacing(4), "end-face": Spacing(3)},
    ),
    Family(
        "MODBAS2",
        "8",
        "9",
        25,
        3.52,
        {
            "cone": _inches(5, 0.3, 0.45),
            "main-cylinder": _inches(5, 0.3, 0.1),
            "main-face": Spacing(1, at_mm=0.05 * MM_PER_INCH),
            "small-cylinder": Spacing(1, at_mm=0.25 * MM_PER_INCH),
            "dome": _inches(20, 0.1, 0.1),
        },
        margins_from_reach=False,
    ),
    Family(
        "PIECS11",
        "10",
        "11",
        35,
        5.30,
        {"flange-face": Spacing(1), "collar": Spacing(1), "cone": Spacing(4), "knob": Spacing(20)},
    ),
)


def parts() -> Iterator[NistPart]:
    """All parts, family by family in the tables' order of columns."""
    errors = _errors()
    for family in FAMILIES:
        before, after = (_inspections(errors, table) for table in (family.semifinish_table, family.finish_table))
        for (number, semifinish), (_, finish) in zip(before, after, strict=True):
            size_in = family.largest_in - SIZE_STEP_IN * (int(number[:2]) - family.largest_number)
            profile = profile_of(family, size_in)
            points = gauging_points(family, profile)
            yield NistPart(
                family,
                number,
                semifinish,
                finish,
                size_in,
                profile,
                _touches(profile, points, errors[family.semifinish_table, number, semifinish]),
                _touches(profile, points, errors[family.finish_table, number, finish]),
            )


def profile_of(family: Family, size_in: float) -> Profile:
    """The nominal profile of a part of this size, in mm.

    FACETST moves towards the axis; MODBAS2 also by as much away from the chuck, only the top of its dome stays
    [6811 A.3.4]. PIECS11 is its largest part less an even skin, with the origin on the top of the new knob.
    """
    largest = profile_of_table(example_job(family).part)
    smaller_mm = (family.largest_in - size_in) / 2 * MM_PER_INCH
    if family.name == "PIECS11":
        skinned = contour_from_centre_path(largest.features, smaller_mm)
        return checked_profile([_moved(feature, 0.0, smaller_mm) for feature in skinned])
    along_mm = smaller_mm if family.name == "MODBAS2" else 0.0
    return checked_profile([_moved(feature, -smaller_mm, along_mm) for feature in largest.features])


def example_job(family: Family) -> Job:
    """The job of the family's largest part."""
    return read_turned_job(family.folder / "job.toml")


def gauging_points(family: Family, profile: Profile) -> GaugingPoints:
    """Where [6811 §5] touched a part of this family."""
    path = nose_centre_path(profile, NOSE_RADIUS_IN * MM_PER_INCH)
    return equally_spaced(profile, family.spacings, path.reachable_mm if family.margins_from_reach else None)


def program(part: NistPart, cut: str) -> str:
    """The part's own "finish" or "semifinish" program: the family's, with the coordinates of a PIECS11 part put in."""
    text = (part.family.folder / f"{cut}.nc").read_text(encoding="utf-8")
    if part.family.name != "PIECS11":
        return text
    largest = profile_of(part.family, part.family.largest_in)
    for old, new in zip(_piecs11_words(largest, cut), _piecs11_words(part.profile, cut), strict=True):
        text = text.replace(old, new)
    return text.replace(f" {part.family.largest_in:.2f}", f" {part.size_in:.2f}")


def parameters(part: NistPart) -> dict[str, float]:
    """The values of the program's parameters for this part."""
    given = dict(example_job(part.family).own_programs.parameters)
    return {**given, "P46": part.size_in} if "P46" in given else given


def touches_csv(touches: Sequence[Touch], source: str) -> str:
    """A touches file: one row a touch, the nominal point in mm with x a radius, the part error in µm."""
    lines = [f"# {source}", "point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    for touch in touches:
        assert touch.error_mm is not None
        x, z = touch.nominal_mm
        lines.append(f"{touch.point},{touch.feature},{x:.6f},{z:.6f},{touch.error_mm * UM_PER_MM:g}")
    return "\n".join([*lines, ""])


def table1_touches(column: str = "semifinish_error_um") -> tuple[Touch, ...]:
    """The mean MODBAS2 part as printed in [6517] Table 1: coordinates and errors of the 3.52 in part."""
    family = next(family for family in FAMILIES if family.name == "MODBAS2")
    names = [name for name, spacing in family.spacings.items() for _ in range(spacing.count)]
    with TABLE1_CSV.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return tuple(
        Touch(
            row["point"],
            (float(row["nominal_x_mm"]), float(row["nominal_z_mm"])),
            name,
            error_mm=float(row[column]) / UM_PER_MM,
        )
        for row, name in zip(rows, names, strict=True)
    )


def example_touches() -> dict[Path, str]:
    """The touches files of the example jobs: the mean MODBAS2 part, and the first part of the other two families."""
    first = {part.family.name: part for part in reversed(list(parts()))}
    mean = "[6517] Table 1: mean of four parts after the semi-finish cut"
    written = {EXAMPLES / "modbas2" / "touches.csv": touches_csv(table1_touches(), mean)}
    for name in ("FACETST", "PIECS11"):
        part = first[name]
        source = f"[6811] Table {part.family.semifinish_table}, part {part.number}.{part.semifinish_inspection}"
        written[part.family.folder / "touches.csv"] = touches_csv(part.semifinish, source)
    return written


def _moved(feature: Feature, x_mm: float, z_mm: float) -> Feature:
    """The feature moved; what lies on the spindle axis stays on it, and the origin where it is."""
    start, end = _place(feature.start_mm, x_mm, z_mm), _place(feature.end_mm, x_mm, z_mm)
    if isinstance(feature, Arc):
        centre = (feature.centre_mm[0], feature.centre_mm[1] + z_mm)
        return replace(feature, start_mm=start, end_mm=end, centre_mm=centre)
    assert isinstance(feature, Line), "NIST's parts have lines and arcs"
    return replace(feature, start_mm=start, end_mm=end)


def _place(point: Point, x_mm: float, z_mm: float) -> Point:
    x, z = point
    return (0.0, 0.0) if abs(x) < 1e-6 else (x + x_mm, z + z_mm)


def _piecs11_words(profile: Profile, cut: str) -> list[str]:
    """The coordinates in a PIECS11 program: radii rounded to 1e-5 in, then doubled, as in [6811 A.4.2]."""
    nose_in = NOSE_RADIUS_IN + (ALLOWANCE_IN if cut == "semifinish" else 0.0)
    path = nose_centre_path(profile, nose_in * MM_PER_INCH).features
    ends = {f.name: (round(f.end_mm[0] / MM_PER_INCH, 5), round(f.end_mm[1] / MM_PER_INCH, 5)) for f in path}
    knob = profile.features[-1]
    assert isinstance(knob, Arc)
    x, z = ends["cone"]
    return [
        f"X{2 * ends['collar'][0]:.5f}",
        f"X{2 * ends['step-face'][0]:.5f}",
        f"X{2 * x:.5f} Z{z:.5f}",
        f"I{-x:.5f} K{knob.centre_mm[1] / MM_PER_INCH - z:.5f}",
    ]


Key = tuple[str, str, str]


def _errors() -> dict[Key, dict[str, float]]:
    """Errors in µm by table, part and inspection, then by point."""
    errors: dict[Key, dict[str, float]] = {}
    with ERRORS_CSV.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            key = row["table"], row["part"], row["inspection"]
            errors.setdefault(key, {})[row["point"]] = float(row["error_um"])
    return errors


def _inspections(errors: Mapping[Key, object], table: str) -> list[tuple[str, str]]:
    """Parts and their inspections in a table: a part cut twice was inspected in the order of its cuts."""
    return sorted((number, inspection) for of, number, inspection in errors if of == table)


def _touches(profile: Profile, points: GaugingPoints, errors_um: Mapping[str, float]) -> tuple[Touch, ...]:
    return tuple(
        Touch(point, (float(x), float(z)), profile.names[i], error_mm=error_um / UM_PER_MM)
        for (point, error_um), (x, z), i in zip(errors_um.items(), points.nominal_mm, points.feature_index, strict=True)
    )
