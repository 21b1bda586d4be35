"""A Fanuc control by a FOCAS library: whatever it answers, no program is lost and no offset half written."""

import json
from dataclasses import replace
from decimal import Decimal
from functools import partial
from pathlib import Path

import pytest

from tests.support.cli import output_of
from tests.support.focas_control import FocasControl, compiled
from tests.support.refusals import refused
from tests.support.tool_tables import OFFSET, record_with
from trueloop.controllers.links.focas import TABLE, Focas
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links import Opened, opened, send

OLD, NEW = "O0012 (OLD)\nG1 X10.\nM30\n", "O0012 (NEW)\n" + "G1 X9.9592 Z-5.\n" * 200 + "M30\n"
ASIDE = 9001
X_WEAR, X_GEOMETRY, Z_WEAR, TIP = 0, 1, 2, 6
replacing = partial(send, replace=True)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(tmp_path_factory.mktemp("focas"))


@pytest.fixture
def control(library: Path) -> FocasControl:
    found = FocasControl(library)
    found.type_in(12, OLD)
    return found


@pytest.fixture
def link(control: FocasControl, tmp_path: Path) -> Opened:
    focas = Focas("127.0.0.1", control.library, ASIDE, timeout_s=1, increment=Decimal("0.001"), unit="mm")
    return Opened("lathe", focas, frozenset(), tmp_path / "replaced", TABLE, "mm")


def test_a_program_is_replaced_and_what_was_there_kept(control: FocasControl, link: Opened) -> None:
    for number in range(100, 125):
        control.type_in(number, f"O{number:04d}\nM30\n")
    listed = link.link.listed()
    assert [one.name for one in listed] == ["O0012", *(f"O0{number}" for number in range(100, 125))]
    assert listed[0].size_bytes == len(OLD)
    assert refused(send, link, NEW.encode(), "O0012").code is Code.LNK_EXISTS
    done = replacing(link, NEW.encode(), "O0012")
    assert done.written and done.kept is not None and done.kept.read_bytes() == f"%\n{OLD}%\n".encode()
    assert control.text(12) == NEW and control.text(ASIDE) is None
    assert link.link.read("O0012") == f"%\n{NEW}%\n".encode()
    assert not replacing(link, f"%\r\n{NEW}%".replace("\n", "\r\n").encode(), "O0012").written
    assert send(link, NEW.replace("O0012", "O0013").encode(), "O0013").kept is None


@pytest.mark.parametrize("at", range(1, 90))
def test_a_connection_lost_at_any_call_loses_no_program(control: FocasControl, link: Opened, at: int) -> None:
    new = NEW.replace("G1 X9.9592 Z-5.\n" * 198, "")
    control.fault("lost", at)
    try:
        replacing(link, new.encode(), "O0012")
    except TrueloopError as error:
        assert error.code is Code.LNK_REACH and "focas://127.0.0.1:8193" in error.message
    else:
        assert control.calls() < at or control.text(12) == new
    left, aside = control.text(12), control.text(ASIDE)
    assert left in (OLD, new) or (left is None and aside == new.replace("O0012", "O9001"))
    if left != OLD:
        assert [one.read_bytes() for one in (link.replaced / "lathe").iterdir()] == [f"%\n{OLD}%\n".encode()]
    control.fault("none")
    replacing(link, new.encode(), "O0012")
    assert control.text(12) == new


def test_what_runs_is_not_replaced_main_program_or_subprogram(control: FocasControl, link: Opened) -> None:
    control.type_in(7, "O0007\nM98 P12\nM30\n")
    for runs in (partial(control.runs, 12), partial(control.runs, 7, 12), partial(control.runs, 12, state=1)):
        runs()
        assert refused(replacing, link, NEW.encode(), "O0012").code is Code.LNK_RUNNING
    control.runs(7)
    assert replacing(link, NEW.encode(), "O0012").written
    control.runs(12)
    assert isinstance(link.link, Focas)
    assert refused(link.link.put_in_place, "O0012.part", "O0012").code is Code.LNK_REACH


def test_a_program_that_the_control_does_not_take_leaves_the_old_one(control: FocasControl, link: Opened) -> None:
    control.reset(room=2000)
    control.type_in(12, OLD)
    error = refused(replacing, link, NEW.encode(), "O0012")
    assert error.code is Code.LNK_REACH and "memory is full" in error.message
    control.reset()
    control.type_in(12, OLD)
    control.fault("edits")
    error = refused(replacing, link, NEW.encode(), "O0012")
    assert error.code is Code.LNK_DIFFERS and "X sent 'X9.9592'" in error.message and "X9.9692" in error.message
    control.fault("stalled")
    assert "carried nothing" in refused(replacing, link, NEW.encode(), "O0012").message
    assert control.text(12) == OLD and control.text(ASIDE) is None


@pytest.mark.parametrize(
    ("text", "name", "code"),
    [
        (NEW, "O12", Code.LNK_NAME),
        (NEW, "finish.nc", Code.LNK_NAME),
        (NEW, "O0013", Code.LNK_NAME),
        ("M30\n", "O0012", Code.LNK_NAME),
        (NEW.replace("O0012", "O12"), "O0012", Code.LNK_NAME),
        ("O0012\n(50% FEED)\nM30\n", "O0012", Code.LNK_CODE),
    ],
)
def test_a_program_goes_by_its_own_number(
    control: FocasControl, link: Opened, text: str, name: str, code: Code
) -> None:
    assert refused(replacing, link, text.encode(), name).code is code
    assert control.text(12) == OLD and control.text(ASIDE) is None


def test_offsets_are_read_and_corrected_number_by_number(control: FocasControl, link: Opened, tmp_path: Path) -> None:
    for kind, counts in ((X_WEAR, -100), (Z_WEAR, 50), (X_GEOMETRY, -155_500), (TIP, 3)):
        control.enter_offset(3, kind, counts)
    (tmp_path / "record.json").write_text(record_with(OFFSET).to_json())
    (tmp_path / "links.toml").write_text(
        f'[focas.lathe]\nhost = "127.0.0.1"\nlibrary = "{control.library}"\naside = {ASIDE}\n'
        'increment = 0.001\ntable_unit = "mm"\n'
    )
    call = ("link", "offsets", "-l", "lathe", "--settings", tmp_path / "links.toml", "--json")
    rows = {(row["tool"], row["kind"]): row for row in json.loads(output_of(*call).split("\n", 1)[1])["rows"]}
    assert len(rows) == 32 and rows[3, "wear"]["x"] == -0.1 and rows[3, "wear"]["tip"] == 3
    assert rows[3, "geometry"]["x"] == -155.5
    output_of(*call, "--apply", tmp_path / "record.json")
    # 12 µm less on the radius are 24 µm on the diameter that this control counts; 4 µm more along Z
    assert (control.offset(3, X_WEAR), control.offset(3, Z_WEAR)) == (-124, 54)
    assert control.offset(3, X_GEOMETRY) == -155_500 and control.offset(4, X_WEAR) == 0
    (kept,) = (tmp_path / "replaced" / "lathe").iterdir()
    assert b"G10 P3 X-0.100 Z0.050 R0.000 Q3" in kept.read_bytes()
    control.runs(7)
    send(link, kept.read_bytes().replace(b"G10 P3 X-0.100 Z0.050", b"G10 P3 X-0.124 Z0.054"), TABLE)  # in force
    assert "tool table is not written" in output_of(
        "link", "put", kept, "--name", TABLE, "--replace", *call[2:6], status=3
    )


def offsets_with(link: Opened, old: bytes, new: bytes) -> bytes:
    text = link.link.read(TABLE)
    assert old in text
    return text.replace(old, new)


def test_an_offset_that_is_refused_puts_the_others_back(control: FocasControl, link: Opened) -> None:
    new = offsets_with(link, b"P3 X0.000 Z0.000", b"P3 X0.010 Z0.020")
    control.fault("range", 2)
    assert refused(replacing, link, new, TABLE).code is Code.LNK_REACH
    assert (control.offset(3, X_WEAR), control.offset(3, Z_WEAR)) == (0, 0)
    control.fault("rounds")
    wrong = new.replace(b"X0.010", b"X0.015")
    error = refused(replacing, link, wrong, TABLE)
    assert error.code is Code.LNK_DIFFERS and "X0.015" in error.message


def test_offsets_without_increment_or_of_a_mill_are_not_touched(control: FocasControl, link: Opened) -> None:
    assert isinstance(link.link, Focas)
    assert refused(replace(link.link, increment=None).read, TABLE).code is Code.OFS_UNIT
    finer = offsets_with(link, b"P3 X0.000", b"P3 X0.0005")
    assert refused(replacing, link, finer, TABLE).code is Code.OFS_NUMBER
    fewer = offsets_with(link, b"G10 P3 X0.000 Z0.000 R0.000 Q0\n", b"")
    assert refused(replacing, link, fewer, TABLE).code is Code.OFS_ROW
    control.is_a_mill()
    assert "lathes alone" in refused(link.link.read, TABLE).message
    assert control.offset(3, X_WEAR) == 0


def test_a_library_that_is_missing_or_another_says_what_to_set(tmp_path: Path, link: Opened) -> None:
    (tmp_path / "links.toml").write_text('[focas.lathe]\nhost = "127.0.0.1"\nlibrary = "fwlib.so"\naside = 9001\n')
    error = refused(opened(tmp_path / "links.toml", "lathe").link.listed)
    assert error.code is Code.LNK_LIBRARY and "`library`" in error.hint and "fwlib.so" in error.message
    assert isinstance(link.link, Focas)
    assert refused(replace(link.link, library=Path("libc.so.6")).listed).code is Code.LNK_LIBRARY
    assert "no connection" in refused(replace(link.link, host="127.0.0.2").listed).message
