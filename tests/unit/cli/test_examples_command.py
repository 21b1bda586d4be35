"""`trueloop examples` lists what comes with trueloop, and copies it whole."""

from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code
from trueloop.formats.examples import EXAMPLES, titles


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)


def test_every_folder_has_a_title() -> None:
    listed = invoke("examples", status=0).stdout.splitlines()
    assert [line.split()[0] for line in listed] == sorted(one.name for one in EXAMPLES.iterdir() if one.is_dir())
    assert all(titles().values())


def test_a_copy_is_the_example_with_its_folders() -> None:
    assert "written: examples/surface" in invoke("examples", "surface", "shaft", status=0).stdout
    for name in ("surface", "shaft"):
        source, copy = EXAMPLES / name, Path("examples") / name
        files = {file.relative_to(source) for file in source.rglob("*") if file.is_file()}
        assert {file.relative_to(copy) for file in copy.rglob("*") if file.is_file()} == files
        assert all((copy / file).read_bytes() == (source / file).read_bytes() for file in files)


def test_what_is_there_stays() -> None:
    own = Path("mine/shaft/job.toml")
    own.parent.mkdir(parents=True)
    own.write_text("mine", encoding="utf-8")
    assert Code.JOB_EXISTS in invoke("examples", "shaft", "-o", "mine", status=ExitStatus.REFUSED).stderr
    assert own.read_text(encoding="utf-8") == "mine" and len(list(own.parent.iterdir())) == 1


def test_an_example_that_there_is_not_is_named_and_nothing_is_copied() -> None:
    refused = invoke("examples", "shaft", "../nist", status=ExitStatus.USAGE).stderr
    assert "'../nist'" in refused and "modbas2" in refused
    assert not Path("examples").exists()
