"""Images for LinuxCNC: bad ones end `loadrt` by name; others take a running one's place only while it is off."""

import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.loops.realtime.test_component import IN_FORCE, OFF, SECOND_ORDER_MM, steps_of
from tests.support.bad_images import PROGRAM, SERIAL, good_image, write_bad_images
from tests.support.realtime_lathe import LATHE, RECORD, SLEW_MM, SLOPES, LinearLathe, added, commanded
from trueloop.controllers.linuxcnc.realtime.install import component
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop_lab.linuxcnc.realtime.session import Setup, Step, drive, get, home, note, on, put, record, wait
from trueloop_lab.linuxcnc.session import _namespaces

HALRUN = """set -e
mount -t overlay overlay -o lowerdir="$1/modules":/usr/lib/linuxcnc/modules /usr/lib/linuxcnc/modules
cd "$1"
shift
exec halrun "$@" </dev/null 2>&1
"""


@pytest.fixture
def folder() -> Iterator[Path]:
    """One that LinuxCNC's processes may read."""
    with tempfile.TemporaryDirectory() as name:
        made = Path(name)
        made.chmod(0o755)
        for part in ("home", "modules", "images"):
            (made / part).mkdir()
        (made / "home").chmod(0o1777)
        (made / "modules" / "rtec.so").write_bytes(component())
        (made / "part.ngc").write_bytes(PROGRAM)
        yield made


def halrun(folder: Path, *words: str) -> "subprocess.CompletedProcess[str]":
    """HAL alone, in namespaces of its own."""
    environment = os.environ | {
        "HOME": str(folder / "home"),
        "RTAPI_UID": "65534",
        "RTAPI_FIFO_PATH": str(folder / "home" / "rtapi_fifo"),
    }
    command = [*_namespaces(), "bash", "-c", HALRUN, "_", str(folder), *words]
    return subprocess.run(
        command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False
    )


def load(folder: Path, image: Path) -> str:
    return f"loadrt rtec image={image} serial={SERIAL} program={folder}/part.ngc\n"


def test_every_bad_image_is_refused_by_name_and_a_good_one_is_loaded_after_all_of_them(folder: Path) -> None:
    bad = write_bad_images(folder / "images")
    good = folder / "images" / "good.rtec"
    good.write_bytes(image_to_bytes(good_image()))
    lines = [load(folder, path) for path, _ in bad.values()]
    shown = "show pin rtec.enable\n"
    (folder / "all.hal").write_text("".join([*lines, shown, load(folder, good), shown]))
    said = halrun(folder, "-k", "-f", "all.hal").stdout
    refused = re.findall(r"rtec: (/\S+): ([a-z ]+): ", said)  # lines of two processes run into each other
    assert refused == [(str(path), name) for path, name in bad.values()]
    assert said.count("insmod for rtec failed") == len(bad)
    assert len(re.findall(r"FALSE  rtec\.enable$", said, re.MULTILINE)) == 1  # of the two times it was asked for


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ("", "rtec: image: no file is named"),
        ("image={folder}/images", "rtec: {folder}/images: missing: "),
        ("image={good} program={folder}/none.ngc", "rtec: {folder}/none.ngc: missing: "),
        ("image={good} serial=4712", "rtec: {good}: serial: "),
    ],
)
def test_a_refusal_ends_halrun(parameters: str, words: str, folder: Path) -> None:
    good = folder / "images" / "good.rtec"
    good.write_bytes(image_to_bytes(good_image()))
    names = {"folder": folder, "good": good}
    (folder / "one.hal").write_text(f"loadrt rtec {parameters.format(**names)}\nshow pin rtec.enable\n")
    done = halrun(folder, "-f", "one.hal")
    assert done.returncode != 0
    assert words.format(**names) in done.stdout
    assert "FALSE  rtec.enable" not in done.stdout


OTHER = LinearLathe(-2.0 * SLOPES)
FILES = {"other.rtec": OTHER.image, "text.rtec": b"G21\nM2\n", "first.rtec": LATHE.image}
SETTLED: Step = ("sleep", 0.05)


def offered(source: str) -> tuple[Step, ...]:
    """A file in place of the image, and what comes of it once the component has looked."""
    taken = (("put", source, "image.rtec"),) if source else (("remove", "image.rtec"),)
    return (*taken, put("rtec.reload", 1), ("sleep", 0.3), put("rtec.reload", 0), ("sleep", 0.05))


def test_another_image_waits_until_nothing_is_added_and_a_refused_one_changes_nothing() -> None:
    files = {
        "other.rtec": OTHER.image,
        "half.rtec": OTHER.image[:700],
        "text.rtec": b"G21\nM2\n",
        "first.rtec": LATHE.image,
    }
    said = ("rtec.generation", "rtec.reload-error")
    steps: list[Step] = [
        on(),
        home(),
        record(),
        *IN_FORCE,
        *offered("other.rtec"),
        get("while on", *said),
        note("still"),
    ]
    steps += [*OFF, wait("rtec.generation", 2), *IN_FORCE, get("taken", *said), ("sleep", 0.05), note("taken at")]
    steps += [*OFF]
    for source in ("half.rtec", "text.rtec", ""):
        steps += [*offered(source), get(source, *said)]
    steps += [*IN_FORCE, SETTLED, note("after"), *offered("first.rtec"), get("mended", *said), *OFF]
    driven = drive(
        Setup(LATHE.image, files, RECORD),
        [*steps, wait("rtec.generation", 3), *IN_FORCE, ("sleep", 0.05), record(False)],
    )
    got, c = driven.got, added(driven)
    at = commanded(driven)
    assert got["while on"] == [1, 0]
    np.testing.assert_allclose(c[got["still"] - 1], LATHE.added_mm(at)[got["still"] - 1], atol=SECOND_ORDER_MM)
    assert got["taken"] == [2, 0]
    for row in (got["taken at"] - 1, got["after"] - 1):
        np.testing.assert_allclose(c[row], OTHER.added_mm(at)[row], atol=4 * SECOND_ORDER_MM)
    assert [got["half.rtec"], got["text.rtec"], got[""]] == [[2, 3], [2, 6], [2, 1]]
    assert got["mended"] == [2, 0]
    np.testing.assert_allclose(c[-1], LATHE.added_mm(at)[-1], atol=SECOND_ORDER_MM)
    assert steps_of(driven) <= SLEW_MM + 1e-12
    # in the period of an exchange nothing is asked for, and nothing is added, neither before nor after it
    for row in np.flatnonzero(np.diff(driven["rtec.generation"])):
        assert not driven["rtec.enable"][row + 1]
        assert np.abs(c[row : row + 2]).max() == 0.0


def test_of_two_offers_the_later_one_is_taken_and_a_bad_one_takes_the_first_away() -> None:
    begun: list[Step] = [on(), home(), *IN_FORCE]
    steps = [*begun, *offered("other.rtec"), *offered("first.rtec"), *OFF, wait("rtec.generation", 2), *IN_FORCE]
    bad = [*offered("other.rtec"), *offered("text.rtec"), *OFF, SETTLED]
    told = get("bad", "rtec.generation", "rtec.reload-error")
    driven = drive(Setup(LATHE.image, FILES, RECORD), [*steps, record(), SETTLED, record(False), *bad, told])
    np.testing.assert_allclose(added(driven), LATHE.added_mm(commanded(driven)), atol=SECOND_ORDER_MM)
    assert driven.got["bad"] == [2, 6]


def test_while_the_corrector_is_asked_for_and_waits_no_image_is_taken() -> None:
    steps: list[Step] = [on(), put("rtec.enable", 1), wait("rtec.phase", 1), *offered("other.rtec")]
    told = get("waiting", "rtec.active", "rtec.generation", "rtec.reload-error")
    driven = drive(Setup(LATHE.image, FILES), [*steps, told, *OFF, wait("rtec.generation", 2)])
    assert driven.got["waiting"] == [False, 1, 0]
