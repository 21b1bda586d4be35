"""`trueloop measure convert`: what one program wrote for another to read."""

from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.qdas import HEAD, characteristic, value_line
from trueloop.cli.terminal import ExitStatus
from trueloop.formats.examples import example
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "part.dfq"
    path.write_text(HEAD + characteristic(1, unit="") + value_line("0.4", "0.4") + "K0014/0 S1\n")
    return path


@pytest.fixture
def two(tmp_path: Path) -> Path:
    path = tmp_path / "two.dfq"
    path.write_text(HEAD + characteristic(1, K2142="") + characteristic(2, "Length 2") + value_line("10.02", "9"))
    return path


@pytest.mark.parametrize("name", ["out.qif", "OUT.DFQ", "new/out.qif", "out.dmo"])
def test_it_holds_what_was_read(two: Path, name: str) -> None:
    target = two.parent / name
    done = invoke("measure", "convert", two, "--unit", "mm", "-o", target)
    assert done.exit_code == ExitStatus.DONE and "1 inspections, 2 values" in done.stderr
    (inspection,) = read_measured_file(target, StatedFacts()).inspections
    assert [(one.characteristic, one.actual, one.nominal) for one in inspection.readings] == [
        ("Diameter 1", 10.02, 10.0),
        ("Length 2", 9.0, 10.0),
    ]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("part.dfq", "-o", "out.qif"), "MSR-VALUE"),
        (("two.dfq", "-o", "out.qif"), "MSR-UNIT"),
        (("two.dfq", "--unit", "mm", "-o", "out.pdf"), "MSR-FORMAT"),
        (("two.dfq", "--unit", "mm", "-o", "two.dfq"), "OUT-INPUT"),
        (("tow.dfq", "-o", "out.qif"), "did you mean"),
    ],
)
def test_what_cannot_be_converted_is_refused_and_nothing_written(
    source: Path, two: Path, arguments: tuple[str, ...], says: str
) -> None:
    paths = [str(two.parent / one) if one.endswith(("dfq", "qif", "pdf")) else one for one in arguments]
    before = {path.name: path.read_bytes() for path in source.parent.iterdir()}
    done = invoke("measure", "convert", *paths)
    assert done.exit_code != ExitStatus.DONE and says in done.stderr and "Traceback" not in done.stderr
    assert {path.name: path.read_bytes() for path in source.parent.iterdir()} == before


@pytest.mark.parametrize("name", ["out.qif", "out.dfq", "out.dmo"])
def test_touches_have_no_other_format_and_are_not_lost_in_one(tmp_path: Path, name: str) -> None:
    done = invoke("measure", "convert", example("modbas2/touches.csv"), "-o", tmp_path / name)
    assert done.exit_code == ExitStatus.REFUSED
    assert "MSR-FORMAT" in done.stderr and "32 touches" in done.stderr and not (tmp_path / name).exists()
