"""Every way in which the set-ups of a part are refused."""

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from tests.support.two_sides import FRAMES, PLACES, job, second
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.opened import Keeping, make_store
from trueloop.jobs.turned.compensate import compensate_and_keep, corrected_part
from trueloop.jobs.turned.job import read_job
from trueloop.jobs.turned.job_files import JobFiles

OVER = second("linuxcnc").replace("G01 X54.0000 Z-29.2000\n", "G01 X53.6000 Z-29.2000\nG01 X53.6000 Z-50.5\n")
"""The second side's program with the collar."""

ERRORS_UM = [5.0 if k % 2 else -5.0 for k in range(len(PLACES))]
"""Not all of one size: that would be taken for an allowance."""


def _corrected(frame: str = FRAMES["second"], more: str = "", program: str = "") -> object:
    frames: Mapping[str, str] = {**FRAMES, "second": frame}
    with tempfile.TemporaryDirectory() as folder:
        if program:
            (Path(folder) / "second.ngc").write_text(program)
        return corrected_part(JobFiles.of(job(Path(folder), ERRORS_UM, more, frames=frames)))


def _read_as_one() -> object:
    with tempfile.TemporaryDirectory() as folder:
        return read_job(job(Path(folder), [0.0] * len(PLACES)))


def _kept_by_number() -> object:
    """T1, whose insert alone is stated, cuts both sides."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "second.ngc").write_text(second("linuxcnc", tool=1))
        path = job(folder, ERRORS_UM)
        text = path.read_text().replace("number = 2\n", "number = 1\n")
        path.write_text(text.replace("number = 1\n", 'number = 1\ninsert = "CNMG"\n'))
        make_store(str(folder / "trueloop.db")).close()
        return compensate_and_keep(path, folder / "out", Keeping(serial="P1"))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.JOB_SETUPS: _read_as_one,
    Code.SET_DATUM: lambda: _corrected("flipped = true"),
    Code.SET_MIRROR: lambda: _corrected("zero_at_z_mm = -80.0"),
    Code.SET_CUTS: lambda: _corrected("zero_at_z_mm = 80.0\nflipped = true"),
    Code.SET_FEATURE: lambda: _corrected(program=OVER),
    Code.SET_EDGE: _kept_by_number,
    Code.SET_OFFSET: lambda: _corrected("zero_at_z_mm = -80.0\nmirrored_z = true", '[compensation]\nby = "offset"\n'),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PRODUCERS[code]()
    assert refusal.value.code is code
    assert refusal.value.hint
    assert set(refusal.value.values) == set(code.values)
