"""`trueloop realtime install` and `hal`, as they are typed."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.support.bad_images import good_image
from tests.support.realtime_lathe import WIDE
from trueloop.cli.main import app
from trueloop.cli.terminal import ExitStatus
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import RealTimeLimits
from trueloop_lab.linuxcnc.session import source


def typed(*words: str) -> "tuple[int, str, str]":
    done = CliRunner().invoke(app, ["realtime", *words])
    return done.exit_code, done.stdout, done.stderr


@pytest.fixture
def lathe(tmp_path: Path) -> Path:
    for name in ("machine.ini", "machine.hal"):
        (tmp_path / name).write_text(source(name))
    (tmp_path / "extra.hal").write_text("")
    return tmp_path / "machine.ini"


def test_the_component_goes_where_it_shall_and_its_sources_are_kept(tmp_path: Path) -> None:
    (tmp_path / "to").mkdir()
    status, said, _ = typed("install", "--to", str(tmp_path / "to"), "--keep-source", str(tmp_path / "kept"))
    assert status == ExitStatus.DONE
    assert "LinuxCNC 2.9" in said
    assert (tmp_path / "to" / "rtec.so").read_bytes()[:4] == b"\x7fELF"
    kept = tmp_path / "kept"
    assert sorted(file.name for file in kept.iterdir()) == ["rtec.comp", "rtec.h", "trueloop_rtec.o"]
    assert "GPL-2.0-or-later" in (kept / "rtec.comp").read_text()
    assert "MIT OR Apache-2.0" in (kept / "rtec.h").read_text()


def test_without_root_s_rights_the_command_that_is_left_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "root's").mkdir()
    monkeypatch.chdir(tmp_path)
    allowed = os.access
    monkeypatch.setattr("os.access", lambda path, mode: "root's" not in str(path) and allowed(path, mode))
    status, said, _ = typed("install", "--to", str(tmp_path / "root's"), "--json")
    assert status == ExitStatus.DONE
    assert "sudo install -m 644 rtec.so" in json.loads(said)["command"]
    assert (tmp_path / "rtec.so").exists()
    assert not list((tmp_path / "root's").iterdir())


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    status, _, said = typed("install", "--to", str(tmp_path / "none"))
    assert status == ExitStatus.REFUSED
    assert "RTC-BUILD" in said


def test_lines_are_printed_and_no_file_is_changed(lathe: Path) -> None:
    image = lathe.parent / "lathe.rtec"
    image.write_bytes(image_to_bytes(replace(good_image(), limits=RealTimeLimits(WIDE))))
    before = {file: file.read_bytes() for file in lathe.parent.iterdir()}
    status, said, _ = typed("hal", str(lathe), "--image", str(image))
    assert status == ExitStatus.DONE
    for line in (f"loadrt rtec image={image} serial=4711", "addf rtec.write servo-thread", "HALFILE = rtec.hal"):
        assert f"    + {line}\n" in said
    assert "  net rtec-signal-0 rtec-signals.signal-0 => rtec.signal-0 " in said
    as_json = json.loads(typed("hal", str(lathe), "--image", str(image), "--json")[1])
    assert {change["where"] for change in as_json["changes"]} == {"before", "after", "replace", "new"}
    assert all(change["text"].splitlines()[0] in said for change in as_json["changes"])
    assert {file: file.read_bytes() for file in lathe.parent.iterdir()} == before


def test_a_configuration_that_is_not_there_is_refused(lathe: Path) -> None:
    status, _, said = typed("hal", str(lathe.with_name("machin.ini")))
    assert status == ExitStatus.REFUSED
    assert "did you mean" in said
