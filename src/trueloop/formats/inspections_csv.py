"""Inspections of one finished part as CSV, a gauging point a row, all in part coordinates and mm.

    point, nominal_x_mm … nominal_z_mm, normal_x … normal_z, controller_x_mm …, cmm_x_mm …, comp_proc_um (optional)

Comment lines `# touch_u_um 0.5` and `# cmm_u_um 0.4` state standard uncertainties; 0 without.
"""

import csv
import io
from pathlib import Path

import numpy as np

from trueloop.diagnosis.components import Components, Inspections
from trueloop.errors import Code
from trueloop.formats.input_file import read_text
from trueloop.formats.measured_rows import HINT, Rows, column, number_in, optional, read_rows
from trueloop.geometry.feature import Array
from trueloop.machine.chain import Vector
from trueloop.machine.model import MachineModel, State
from trueloop.machine.term import Signals

COLUMNS = (
    *("comp_mtg_cutting", "comp_mtg_probing", "comp_mtg_applied", "comp_proc"),
    *("error_pp", "error_proc", "error_proc_resid", "error_mtg", "error_mtg_resid"),
    *("u_error_pp", "u_error_proc", "u_error_mtg"),
    *("detected_surface", "nominal_surface_mt", "uncompensated_nominal_surface_mt"),
    *("gt_compensated_surface", "uncompensated_surface", "uncompensated_error"),
)


def read_inspections(path: Path) -> tuple[tuple[str, ...], Inspections]:
    """Names of the points, and what was seen. Raises MCH-FILE and MCH-UNIT."""
    rows = read_rows(path)
    vectors = {kind: _vectors(rows, kind, "_mm", path) for kind in ("nominal", "controller", "cmm")}
    normal = _vectors(rows, "normal", "", path)
    comp = 1e-3 * optional(rows, "comp_proc_um", path, 0.0)
    u = [1e-3 * _stated(path, name) for name in ("touch_u_um", "cmm_u_um")]
    names = tuple(row.get("point", str(k + 1)) for k, (_, row) in enumerate(rows))
    seen = Inspections(vectors["nominal"], normal, vectors["controller"], vectors["cmm"], u[0], u[1], comp)
    return names, seen


def states_of(model: MachineModel, seen: Inspections, zero: Vector, tool: Vector, signals: Signals) -> State:
    """Axis positions that bring the tool point to each gauging point: part + zero − tool."""
    axes = seen.nominal_mm + np.array(zero) - np.array(tool)
    chain = model.machine.chain
    given = {name: axes[:, k] for k, name in enumerate("XYZ") if name in chain.order}
    return State(chain.positions(given), 0.0, signals, tool)


def components_csv(points: tuple[str, ...], parts: Components) -> str:
    """One row a point, µm along the outward normal."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["point", *(f"{name}_um" for name in COLUMNS)])
    columns = [1e3 * getattr(parts, name) for name in COLUMNS]
    for k, point in enumerate(points):
        writer.writerow([point, *(f"{column[k]:.3f}" for column in columns)])
    return out.getvalue()


def _vectors(rows: Rows, kind: str, unit: str, path: Path) -> Array:
    return np.stack([column(rows, f"{kind}_{c}{unit}", path) for c in "xyz"], axis=-1)


def _stated(path: Path, name: str) -> float:
    """What a comment line states under that name; 0 without one. Raises MCH-FILE with the line."""
    for number, line in enumerate(read_text(path, Code.MCH_FILE, hint=HINT).splitlines(), 1):
        words = line.lstrip("#").split()
        if line.startswith("#") and len(words) == 2 and words[0] == name:
            return number_in({name: words[1]}, name, number, path)
    return 0.0
