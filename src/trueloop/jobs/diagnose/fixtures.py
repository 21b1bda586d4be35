"""Repeats right after fixturing, from files and from a store."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.diagnosis.features.fixturing import fixturing
from trueloop.errors import Code, TrueloopError, in_file
from trueloop.formats.measurements.inspections_csv import read_repeats
from trueloop.jobs.diagnose.diagnosed import Asked, sources_of
from trueloop.jobs.diagnose.records import part_named
from trueloop.jobs.diagnose.seen_series import parts_of
from trueloop.jobs.diagnose.shaped import fixture_shape
from trueloop.loops.diagnosis.repeats import Repeats, repeats_of, require_stable
from trueloop.report.diagnosis.shapes import FixtureDiagnosisShape
from trueloop.storage.store import Store
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class Repeatability:
    """What one reading is expected to repeat to, and what it may vary by; None: as stated, and no limit."""

    standard_u_mm: float | None = None
    limit_mm: float | None = None


def fixture_of_file(path: Path, repeatability: Repeatability, accept: Collection[str] = ()) -> FixtureDiagnosisShape:
    """Repeats in a file. Raises DIA-FEW, and DIA-UNSTABLE unless it is accepted or only shown."""
    read, u_mm = read_repeats(path, repeatability.standard_u_mm)
    with in_file(path):
        found = [Repeats(name, mm, u_mm, fixturing(mm, u_mm, repeatability.limit_mm)) for name, mm in read.items()]
    return shown(path.stem, found, accept)


def fixture_of_part(store: Store, serial: str, asked: Asked, repeatability: Repeatability) -> FixtureDiagnosisShape:
    """Repeats of a part's own points and readings. Raises DIA-NONE and DIA-FEW."""
    shares = part_named(store, serial, asked.part_type).shares
    of_shares = [sources_of(store, asked, one.part_type.name) for one in shares]
    repeats = [
        one
        for sources in of_shares
        for each in parts_of(sources, (serial,))[0]
        for points in each.points(sources.places).values()
        for one in repeats_of(points, repeatability.standard_u_mm, repeatability.limit_mm)
    ]
    if not repeats:
        raise TrueloopError(
            Code.DIA_FEW,
            f"no point of part {serial!r} was read 5 times: its fixturing cannot be judged",
            hint="touch one point repeatedly right after fixturing, and keep the readings",
            values={"count": 0, "needed": 5},
        )
    return shown(serial, repeats, asked.accept)


def shown(name: str, repeats: Sequence[Repeats], accept: Collection[str]) -> FixtureDiagnosisShape:
    """Shows the fixturings of a machine, the unstable ones as findings, which are refused elsewhere."""
    findings = require_stable([("", one) for one in repeats], (*accept, Code.DIA_UNSTABLE))
    return fixture_shape(name, repeats, findings)


def limits_of(u_um: float | None, limit_um: float | None) -> Repeatability:
    """Returns limits in mm from micrometres."""
    return Repeatability(*(None if one is None else one / UM_PER_MM for one in (u_um, limit_um)))
