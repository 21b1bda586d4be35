"""Every way in which readings of gauges are refused."""

import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.support.gauged import EXAMPLES, shaft_with
from trueloop.errors import Code
from trueloop.geometry.feature import Line
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.job import read_job, read_part

HEADER = "feature,z_mm,diameter_mm\n"
SIX = (EXAMPLES / "shaft" / "readings.csv").read_text(encoding="utf-8")
TWO_PARTS = "serial,feature,z_mm,diameter_mm\nA1,seat-44,-85,44.027\nA2,seat-44,-85,44.031\n"


def _read(readings: str, more: str = "", table: str = "gauging") -> object:
    with tempfile.TemporaryDirectory() as folder:
        return read_job(shaft_with(Path(folder), readings, more, table))


def _before_the_record() -> object:
    with tempfile.TemporaryDirectory() as folder:
        job = shaft_with(Path(folder), SIX, 'after_record = "record.json"\n')
        (Path(folder) / "record.json").write_text(
            '{"id": "0", "product": "turned", "inputs_sha256": {}, "made_at": "2026-11-21T08:00:00+01:00", '
            '"made_by": "", "options": {}, '
            '"trueloop_version": "1", "model": {"curves": []}, "decision": [], "changes": [], "components": []}'
        )
        return read_job(job)


def _allowance_still_on() -> object:
    """About +30 µm along each normal, on cylinders and faces alike."""
    profile = _profile()
    touches = "point,feature,nominal_x_mm,nominal_z_mm,error_um\n"
    for k, feature in enumerate(one for one in profile.features if isinstance(one, Line)):
        x, z = feature.point_mm(feature.length_mm / 2)
        touches += f"{k},{feature.name},{x:.6f},{z:.6f},{30 + k % 3}\n"
    with tempfile.TemporaryDirectory() as folder:
        job = shaft_with(Path(folder), SIX)
        (Path(folder) / "t.csv").write_text(touches)
        text = job.read_text(encoding="utf-8").replace('readings = "readings.csv"', 'touches = "t.csv"')
        job.write_text(text, encoding="utf-8")
        return read_job(job)


def _profile() -> Profile:
    with tempfile.TemporaryDirectory() as folder:
        return read_part(shaft_with(Path(folder), SIX)).profile


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MSR_COLUMN: lambda: _read("feature,z_mm,diameter_mm,instrumnt\nseat-44,-85,44.0,5\n"),
    Code.MSR_NONE: lambda: _read("feature,runout_um\nseat-44,4\n"),
    Code.MSR_FEATURE: lambda: _read(f"{HEADER}seat-4,-85,44.027\n"),
    Code.MSR_PLACE: lambda: _read(f"{HEADER}cone,,33.0\n"),
    Code.MSR_KIND: lambda: _read("feature,length_mm\nseat-44,32.01\n"),
    Code.MSR_NOMINAL: lambda: _read(f"{HEADER}seat-44,-85,47.1\n"),
    Code.MSR_UNCERTAINTY: lambda: _read("feature,diameter_mm,uncertainty_um\nseat-44,44.02,1e9\n"),
    Code.MSR_TWICE: lambda: _read(f"{HEADER}seat-44,-85,22.013\n"),
    Code.MSR_SCALE: lambda: _read(f"{HEADER}seat-44,-85,1.7334\nseat-36,-50,1.4182\n"),
    Code.MSR_SERIAL: lambda: _read(TWO_PARTS, 'serial = "A7"\n', "part"),
    Code.MSR_OLD: _before_the_record,
    Code.CMP_ALLOWANCE: _allowance_still_on,
}
