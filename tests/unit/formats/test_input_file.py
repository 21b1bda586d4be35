"""A mistyped name is answered with the nearest one."""

from pathlib import Path

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.formats.input_file import read_input, read_text


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("finish.nc", "semifinish.nc", "Job.toml"):
        (tmp_path / name).write_bytes(b"x\n")
    (tmp_path / "latin.csv").write_bytes("point\nµ".encode("latin-1"))
    (tmp_path / "bom.csv").write_bytes("point".encode("utf-8-sig"))
    return tmp_path


def _refusal(path: Path) -> TrueloopError:
    with pytest.raises(TrueloopError) as refusal:
        read_text(path, Code.NC_FILE, hint="look again")
    return refusal.value


@pytest.mark.parametrize(
    "asked, meant", [("finnish.nc", "finish.nc"), ("semi-finish.nc", "semifinish.nc"), ("job.toml", "Job.toml")]
)
def test_the_nearest_name_is_offered(folder: Path, asked: str, meant: str) -> None:
    refusal = _refusal(folder / asked)
    assert refusal.code is Code.NC_FILE
    assert refusal.hint == f"did you mean {str(folder / meant)!r}?"
    assert refusal.place.file == str(folder / asked)


@pytest.mark.parametrize("asked", ["drawing.dxf", "no/such/folder/finish.nc"])
def test_without_a_name_like_it_the_plain_hint_is_given(folder: Path, asked: str) -> None:
    assert _refusal(folder / asked).hint == "look again"


def test_a_link_that_leads_nowhere_is_not_offered_for_itself(folder: Path) -> None:
    (folder / "drawing.dxf").symlink_to(folder / "gone.dxf")
    assert _refusal(folder / "drawing.dxf").hint == "look again"


def test_a_folder_is_no_file(folder: Path) -> None:
    assert "Is a directory" in _refusal(folder).message


def test_other_encodings_are_refused_with_their_line(folder: Path) -> None:
    refusal = _refusal(folder / "latin.csv")
    assert refusal.place.line == 2


def test_what_is_there_is_read(folder: Path) -> None:
    assert read_input(folder / "finish.nc", Code.NC_FILE, hint="") == b"x\n"
    assert read_text(folder / "bom.csv", Code.NC_FILE, hint="") == "point"
