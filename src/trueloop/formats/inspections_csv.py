"""Inspections of one finished part as CSV, a gauging point a row, all in part coordinates and mm.

    point, nominal_x_mm … nominal_z_mm, normal_x … normal_z, controller_x_mm …, cmm_x_mm …, comp_proc_um (optional)

Comment lines `# touch_u_um 0.5` and `# cmm_u_um 0.4` state standard uncertainties; 0 without.
"""

import csv
import io
from pathlib import Path

import numpy as np

from trueloop.diagnosis.components import Components, Inspections
from trueloop.errors import Code, Place, TrueloopError
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
    """Names of the points, and what was seen. Raises MCH-FILE."""
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
        table = list(csv.DictReader(line for line in lines if line.strip() and not line.startswith("#")))
        vectors = {kind: _vectors(table, kind, "_mm") for kind in ("nominal", "controller", "cmm")}
        normal = _vectors(table, "normal", "")
        comp = np.array([float(row.get("comp_proc_um") or 0.0) * 1e-3 for row in table])
        stated = dict(line[1:].split() for line in lines if line.startswith("#") and len(line[1:].split()) == 2)
        u = [float(stated.get(name, 0.0)) * 1e-3 for name in ("touch_u_um", "cmm_u_um")]
        names = tuple(row["point"] for row in table)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise TrueloopError(
            Code.MCH_FILE,
            f"{path.name!r} cannot be read as inspections of {0} points or more: {type(error).__name__}: {error}",
            hint="columns point, nominal_x_mm …, normal_x …, controller_x_mm …, cmm_x_mm …",
            place=Place(str(path)),
        ) from error
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


def _vectors(table: list[dict[str, str]], kind: str, unit: str) -> Array:
    found = np.array([[float(row[f"{kind}_{c}{unit}"]) for c in "xyz"] for row in table])
    if not np.all(np.isfinite(found)) or found.shape != (len(table), 3):
        raise ValueError(f"{kind} of {len(table)} points is not all finite numbers")
    return found
