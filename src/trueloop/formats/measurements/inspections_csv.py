"""Inspections of one finished part as CSV, a gauging point a row, all in part coordinates and mm.

    point, nominal_x_mm … nominal_z_mm, normal_x … normal_z, controller_x_mm …, cmm_x_mm …, comp_proc_um (optional)
    tool_x_mm … tool_z_mm, probe_x_mm … probe_z_mm (optional: the cutting tool and the stylus of each point)

Comment lines `# touch_u_um 0.5` and `# cmm_u_um 0.4` state standard uncertainties; 0 without.
"""

import csv
import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.components import Components, Inspections
from trueloop.errors import Code, Place
from trueloop.formats.measurements.rows import CsvFile, Rows, read_measured, vectors
from trueloop.units import UM_PER_MM

READINGS: Final = {"reading_mm": 1.0, "reading_um": 1.0 / UM_PER_MM}
REPEATS_STATED: Final = re.compile(r"#\s*repeats_to_um\s+(\d{1,9}(?:\.\d*)?)\s*")


def read_repeats(path: Path, standard_u_mm: float | None = None) -> tuple[dict[str, Array], float]:
    """Readings in mm by what was fixed, in order, and what one repeats to. Raises MCH-FILE and MCH-UNIT."""
    file = read_measured(path)
    rows = file.rows(("what", *READINGS))
    values_mm = _readings(rows)
    names = np.array([name or "part" for name in rows.texts("what")])
    u_mm = _stated_mm(file) if standard_u_mm is None else standard_u_mm
    return {name: values_mm[names == name] for name in dict.fromkeys(names.tolist())}, u_mm


def repeats_to_csv(values_mm: Mapping[str, Array], repeats_to_mm: float) -> str:
    """Writes readings by what was read, in their order, as `read_repeats` reads them."""
    text = io.StringIO()
    text.write(f"# repeats_to_um {repeats_to_mm * UM_PER_MM:.3f}\n")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["what", "reading_um"])
    rows.writerows([name, f"{value * UM_PER_MM:.3f}"] for name, mm in values_mm.items() for value in mm.tolist())
    return text.getvalue()


def _readings(rows: Rows) -> Array:
    column = next((name for name in READINGS if name in rows.header), "reading_mm")
    values: Array = rows.numbers(column) * READINGS[column]
    return values


def _stated_mm(file: CsvFile) -> float:
    found = [match[1] for _, text in file.comments if (match := REPEATS_STATED.fullmatch(text))]
    if len(found) != 1 or float(found[0]) <= 0.0:
        raise Code.MCH_FILE.refusal(
            f"{len(found)} lines state what a reading repeats to",
            hint="write `# repeats_to_um 0.5` above the header, or give --repeats-to-um",
            place=Place(str(file.path), 1),
        )
    return float(found[0]) / UM_PER_MM


KINDS: Final = {"nominal": "_mm", "normal": "", "controller": "_mm", "cmm": "_mm"}
VECTORS: Final = {kind: [f"{kind}_{c}{unit}" for c in "xyz"] for kind, unit in KINDS.items()}
TOOLS: Final = {kind: [f"{kind}_{c}_mm" for c in "xyz"] for kind in ("tool", "probe")}
COMP_PROC: Final = "comp_proc_um"
STATED: Final = ("touch_u_um", "cmm_u_um")
STATEMENT: Final = re.compile(r"\w+\s+\d{1,9}(\.\d*)?")
COLUMNS: Final = (
    *("comp_mtg_cutting", "comp_mtg_probing", "comp_mtg_applied", "comp_proc"),
    *("error_pp", "error_proc", "error_proc_resid", "error_mtg", "error_mtg_resid"),
    *("u_error_pp", "u_error_proc", "u_error_mtg"),
    *("detected_surface", "nominal_surface_mt", "uncompensated_nominal_surface_mt"),
    *("gt_compensated_surface", "uncompensated_surface", "uncompensated_error"),
)


def read_inspections(path: Path) -> tuple[tuple[str, ...], Inspections]:
    """Names of the points, and what was seen. Raises MCH-FILE and MCH-UNIT."""
    file = read_measured(path)
    rows = file.rows(("point", COMP_PROC, *(name for names in (*VECTORS.values(), *TOOLS.values()) for name in names)))
    seen = {kind: vectors(rows, names) for kind, names in VECTORS.items()}
    touch_u_mm, cmm_u_mm = (_stated(file, name) / UM_PER_MM for name in STATED)
    comp_mm = rows.numbers(COMP_PROC, 0.0) / UM_PER_MM
    names = tuple(name or str(k) for k, name in enumerate(rows.texts("point"), 1))
    tools = [vectors(rows, of) if set(of) & set(file.header) else None for of in TOOLS.values()]
    places = (seen["nominal"], seen["normal"], seen["controller"], seen["cmm"])
    return names, Inspections(*places, touch_u_mm, cmm_u_mm, comp_mm, *tools)


def components_csv(points: tuple[str, ...], parts: Components) -> str:
    """Returns one row a point, µm along the outward normal."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["point", *(f"{name}_um" for name in COLUMNS)])
    columns = [UM_PER_MM * getattr(parts, name) for name in COLUMNS]
    for k, point in enumerate(points):
        writer.writerow([point, *(f"{column[k]:.3f}" for column in columns)])
    return out.getvalue()


def _stated(file: CsvFile, name: str) -> float:
    """Returns the value of the comment line with that name; 0 without one.

    Raises MCH-FILE with the line for a comment that begins as if it stated it and does not: it would be ignored.
    """
    quantity = name.removesuffix("_um")
    lines = [(line, text.lstrip("# \t")) for line, text in file.comments]
    stated = [(line, text) for line, text in lines if text.lower().startswith(quantity)]
    for k, (line, text) in enumerate(stated):
        if k or not STATEMENT.fullmatch(text) or not text.startswith(name):
            hint = f"write `# {name} 0.5`, once"
            raise Code.MCH_FILE.refusal(f"{text!r} states no {name}", hint=hint, place=Place(str(file.path), line))
    return float(stated[0][1].split()[1]) if stated else 0.0
