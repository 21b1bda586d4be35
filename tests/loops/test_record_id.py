"""The record's id stands for every file a job is read from: nothing that was read may change without it."""

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from trueloop.domain.record import record_id
from trueloop.jobs.turned.job import read_job, read_part

EXAMPLES = Path(__file__).parents[2] / "examples"
_opened: set[Path] = set()


def _note(event: str, arguments: tuple[object, ...]) -> None:
    if event == "open" and isinstance(arguments[0], str | Path):
        _opened.add(Path(arguments[0]))


sys.addaudithook(_note)


@pytest.fixture
def job(tmp_path: Path) -> Iterator[Path]:
    """A job whose nose comes from a part known by its drawing and from one known by its program."""
    for name in ("modbas2", "piecs11", "dxf"):
        shutil.copytree(EXAMPLES / name, tmp_path / name)
    other = tmp_path / "piecs11/job.toml"
    rest = other.read_text().split("[tool]")[1].replace('z_reference = "1"', "")
    other.write_text(f'[part]\nname = "PIECS11"\nfrom_program = true\n[tool]{rest}')
    touches = (tmp_path / "dxf/touches.csv").read_text().splitlines()
    kept = [line for line in touches if not line.startswith("1,")]  # before the program's contour begins
    (tmp_path / "piecs11/touches.csv").write_text("\n".join(kept))
    path = tmp_path / "modbas2/job.toml"
    path.write_text(path.read_text() + '\n[compensation]\nnose_from = ["../dxf/job.toml", "../piecs11/job.toml"]\n')
    _opened.clear()
    yield path


def test_every_file_that_is_read_is_in_the_id_and_kept_from_being_overwritten(job: Path) -> None:
    folder = job.parents[1].resolve()
    read = read_job(job)
    opened = {path.resolve() for path in _opened if path.resolve().is_relative_to(folder) and path.is_file()}
    assert {path.resolve() for path in read.files} == opened
    assert len(read.inputs.inputs_sha256) == len(opened) > 5


@pytest.mark.parametrize("file", ["dxf/touches.csv", "dxf/piecs11.dxf", "piecs11/finish.nc", "modbas2/touches.csv"])
def test_a_changed_file_changes_the_id(job: Path, file: str) -> None:
    before = record_id(dict(read_job(job).inputs.inputs_sha256), {})
    changed = job.parents[1] / file
    changed.write_bytes(changed.read_bytes() + b"\n")
    assert record_id(dict(read_job(job).inputs.inputs_sha256), {}) != before


def test_a_part_read_alone_tells_its_files(job: Path) -> None:
    part = read_part(job.parents[1] / "piecs11/job.toml")
    assert [path.name for path in part.files] == ["job.toml", "finish.nc"]
