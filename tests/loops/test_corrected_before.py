"""A program that was corrected is refused before anything else is looked at."""

import shutil
from pathlib import Path

import pytest

from tests.support.cli import run
from tests.support.correction import EXAMPLES, example_correction


@pytest.fixture
def job(tmp_path: Path) -> Path:
    """A job whose finish program is corrected already, and whose profile is taken from that."""
    for file in (EXAMPLES / "facetst").iterdir():
        shutil.copy(file, tmp_path)
    (tmp_path / "finish.nc").write_bytes(example_correction("facetst").corrected_program)
    text = (tmp_path / "job.toml").read_text()
    before, _, rest = text.partition("[part]")
    _, _, after = rest.partition("[tool]")
    (tmp_path / "job.toml").write_text(f'{before}[part]\nname = "again"\nfrom_program = true\n\n[tool]{after}')
    return tmp_path / "job.toml"


def refused(job: Path) -> str:
    return run("compensate", job, "-o", job.parent / "out", status=3)


def test_with_a_profile_from_the_program(job: Path) -> None:
    """Taken from a corrected program, the profile would have the correction in it."""
    assert "finish.nc:" in refused(job) and "CMP-TWICE" in refused(job)


@pytest.mark.parametrize("fault", ["no touches", "touches that cannot be read", "no semi-finish program", "a dialect"])
def test_before_any_other_fault(job: Path, fault: str) -> None:
    if fault == "no touches":
        (job.parent / "touches.csv").unlink()
    elif fault == "touches that cannot be read":
        (job.parent / "touches.csv").write_bytes(b"PK\x03\x04")
    elif fault == "no semi-finish program":
        (job.parent / "semifinish.nc").unlink()
    else:
        job.write_text(job.read_text().replace('"ge2000t"', '"fanuc-lathe"'))
    assert "CMP-TWICE" in refused(job)


def test_a_field_over_it_before_its_dialect_is_asked_for(job: Path) -> None:
    """Nothing in it says whose it is, and it need not."""
    program = job.parent / "plain.nc"
    program.write_text("(trueloop corrected 0123 by a field)\nM30\n")
    assert "CMP-TWICE" in run("nc", "map", program, "--shift", "0,0,0.01", "-o", job.parent / "out.nc", status=3)
