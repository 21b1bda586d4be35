"""The correction table as CSV, for a control that corrects in real time."""

from trueloop.turned.compensation.table import CorrectionTable
from trueloop.units import UM_PER_MM

HEADER = "feature,commanded_x_radius_mm,commanded_z_mm,correction_x_radius_um,correction_z_um"


def table_to_csv(table: CorrectionTable) -> bytes:
    """Rows in cutting order. Positions to a nanometre, corrections to a picometre: below what a control resolves.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> table = trueloop.table_to_csv(trueloop.compensate(job.inputs).table)
    >>> for row in table.decode().splitlines()[:2]:
    ...     print(row)
    feature,commanded_x_radius_mm,commanded_z_mm,correction_x_radius_um,correction_z_um
    collar,73.437750,-162.655250,-15.828191,+0.000000
    """
    rows = zip(table.feature, table.commanded_mm.tolist(), (table.correction_mm * UM_PER_MM).tolist(), strict=True)
    lines = [f"{_cell(name)},{x:.6f},{z:.6f},{dx:+.6f},{dz:+.6f}" for name, (x, z), (dx, dz) in rows]
    return "\n".join([HEADER, *lines, ""]).encode()


def _cell(text: str) -> str:
    """A name as RFC 4180 wants it: quoted when it holds a comma, a quote or a line end."""
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\r\n') else text
