"""A run watched from outside: every period as LinuxCNC's own recorder has it, the live page, the page at the end."""

import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support.bad_images import good_image
from tests.support.chromium import console_errors
from tests.support.hal_session import SAMPLER, Hal, hal_session, send
from tests.support.live_browser import live_page
from trueloop.arrays import Array, Integers
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.formats.realtime.samples_csv import read_samples
from trueloop.realtime.samples import Samples
from trueloop.report.style import plain, signed

WATCH = (str(Path(sys.executable).with_name("trueloop")), "realtime", "watch")
WAIT_S = 60.0
SHOWN = "Object.fromEntries([...document.querySelectorAll('span[id]')].map(e => [e.id, e.textContent]))"
BESIDE = """\
addf sampler.2 servo-thread
net watch-rtec-periods rtec.periods => sampler.2.pin.0
net x rtec.at-0 => sampler.2.pin.1
net z rtec.at-2 => sampler.2.pin.2
net watch-rtec-corr-0 rtec.corr-0 => sampler.2.pin.3
net watch-rtec-out-2 rtec.out-2 => sampler.2.pin.4
net watch-rtec-in-use-0 rtec.in-use-0 => sampler.2.pin.5
net watch-rtec-phase rtec.phase => sampler.2.pin.6
"""
"""A third stream, for LinuxCNC's own halsampler."""


def _image() -> bytes:
    """A hundredth of the test image's model, so that no correction reaches the limit; no table."""
    image = good_image()
    assert image.bank is not None
    small = replace(
        image.bank,
        slope=image.bank.slope / 100,
        bodies=tuple(
            replace(
                body, powers=body.powers / 100, per_unit=tuple((place, added / 100) for place, added in body.per_unit)
            )
            for body in image.bank.bodies
        ),
    )
    identity = replace(image.identity, program_sha256="", program="")
    return image_to_bytes(replace(image, bank=small, blocks=(), identity=identity))


@pytest.fixture(scope="module")
def image_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("image") / "lathe.rtec"
    file.write_bytes(_image())
    return file


@pytest.fixture(scope="module")
def hal(image_file: Path) -> Iterator[Hal]:
    sampler = re.sub(r"depth=(\S+) cfg=(\S+)", r"depth=\1,8000 cfg=\2,ufffffs", SAMPLER) + "\n" + BESIDE
    with hal_session(image_file.read_bytes(), sampler=sampler) as running:
        running.run("halcmd", "setp", "rtec.enable", "1")
        running.run("halcmd", "setp", "rtec.heartbeat", "1")
        yield running


def _watching(hal: Hal, out: Path, *more: str) -> "tuple[subprocess.Popen[bytes], str]":
    """The command, and where its live page is."""
    process = hal.start(*WATCH, "--out", str(out), *more)
    assert process.stderr is not None
    line = process.stderr.readline().decode()
    assert line.startswith("live page: "), line
    return process, line.split()[-1]


def _until(reached: Callable[[], bool]) -> None:
    end = time.monotonic() + WAIT_S
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.02)


def _rows(out: Path, name: str = "samples.csv") -> int:
    return (out / name).read_bytes().count(b"\n") if (out / name).exists() else 0


def test_every_period_is_as_halsampler_has_it(hal: Hal, image_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "record"
    theirs_file = tmp_path / "halsampler.txt"
    halsampler = hal.start("halsampler", "-c", "2", str(theirs_file))
    watching, _ = _watching(hal, out, "--image", str(image_file))
    _until(lambda: _rows(out) > 2500)
    send(watching, signal.SIGINT)
    watching.communicate(timeout=WAIT_S)
    send(halsampler, signal.SIGTERM)
    halsampler.communicate(timeout=WAIT_S)
    samples = read_samples(out / "samples.csv")
    assert samples.signals == ("T1_degC",)
    rows = [line.split() for line in theirs_file.read_text().splitlines()]
    theirs = np.array([row for row in rows if len(row) == 7], np.float64)
    counts = np.round(samples.time_s / samples.period_s).astype(int)
    ours = counts + _shift(counts, samples, theirs)
    both, mine, other = np.intersect1d(ours, theirs[:, 0].astype(int), return_indices=True)
    assert len(both) > 1000
    row = samples.rows(mine)
    columns = {
        1: row.columns["command_x_mm"],
        2: row.columns["command_z_mm"],
        3: row.mm("correction")[:, 0],
        4: row.columns["drive_z_mm"],
        5: row.columns["T1_degC"],
        6: row.columns["phase"],
    }
    for place, column in columns.items():
        np.testing.assert_allclose(column, theirs[other, place], atol=1.01e-6)
    assert np.ptp(columns[3]) > 1e-4  # it was in force, and moved


def _shift(counts: Integers, samples: Samples, theirs: Array) -> int:
    """The count of periods at which our record began: by where the axes were, in both of which none is twice."""
    keys = {(round(x, 5), round(z, 5)): int(n) for n, x, z in theirs[:, :3]}
    place = zip(samples.columns["command_x_mm"], samples.columns["command_z_mm"], strict=True)
    found = [
        keys[key] - n
        for n, (x, z) in zip(counts.tolist(), place, strict=True)
        if (key := (round(x, 5), round(z, 5))) in keys
    ]
    return int(max(set(found), key=found.count))


def test_rows_hold_what_the_page_of_columns_says(hal: Hal, tmp_path: Path) -> None:
    out = tmp_path / "record"
    done = hal.run(*WATCH, "--out", str(out), "--for", "2", "--json")
    said = json.loads(done.stdout)
    samples = read_samples(out / "samples.csv")
    assert said["periods"] == len(samples)
    assert said["lost"] == samples.lost
    assert said["ended"] == "time is up"
    off = samples.mm("drive") - samples.mm("command") - samples.mm("correction")
    assert np.abs(off).max() < 2.1e-9
    assert np.all(samples.columns["write_ns"] > 0)
    assert samples.period_s == pytest.approx(1e-3, rel=1e-4)


def test_live_page_shows_what_is_recorded(hal: Hal, image_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "record"
    watching, address = _watching(hal, out, "--image", str(image_file))
    moments = []
    with live_page(address) as page:
        page.until("(document.getElementById('time')?.textContent ?? '–') !== '–'")
        for _ in range(3):
            shown = page.evaluate(SHOWN)
            moments.append(shown)
            page.until(f"document.getElementById('time').textContent !== '{shown['time']}'")
        assert page.evaluate("document.getElementById('state').textContent") == "in force"
        hal.run("halcmd", "setp", "rtec.signal-0", "nan")
        page.until("document.getElementById('state').textContent.startsWith('frozen')")
        hal.run("halcmd", "setp", "rtec.signal-0", "25")
        page.until("document.getElementById('state').textContent === 'in force'")
        assert "T1_degC" in page.evaluate("document.getElementById('fault').textContent")
        ink = "new Set(document.getElementById('live').getContext('2d').getImageData(0, 0, 1000, 600).data).size"
        assert page.evaluate(ink) > 10
        page.screenshot(tmp_path / "live.png")
        send(watching, signal.SIGTERM)
        output, _ = watching.communicate(timeout=WAIT_S)
        page.until("document.getElementById('state').textContent === 'the record has ended'")
        assert not page.said
    assert watching.returncode == 0
    assert b"stopped: " in output
    samples = read_samples(out / "samples.csv")
    times = np.round(samples.time_s, 3)
    for shown in moments:
        (row,) = np.flatnonzero(times == float(shown["time"]))
        at = {name: float(column[row]) for name, column in samples.columns.items()}
        for axis in "xz":
            assert shown[f"command_{axis}_mm"] == signed(at[f"command_{axis}_mm"], 6)
            for what in ("model", "table", "correction"):
                _same(shown[f"{what}_{axis}_um"], at[f"{what}_{axis}_um"])
        assert shown["T1_degC"] == plain(at["T1_degC"], 4)


def _same(shown: str, value: float) -> None:
    """Four decimals of a value of which the file has six: the last may be rounded twice."""
    assert abs(float(shown.replace("−", "-")) - value) <= 0.5e-4 + 1e-6


def test_page_of_the_run_names_what_happened(hal: Hal, image_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "record"
    watching, _ = _watching(hal, out, "--image", str(image_file))
    _until(lambda: _rows(out) > 300)
    hal.run("halcmd", "setp", "rtec.signal-0", "nan")
    _until(lambda: b",4,0," in (out / "samples.csv").read_bytes().splitlines()[-2])
    hal.run("halcmd", "setp", "rtec.signal-0", "25")
    rows = _rows(out)
    _until(lambda: _rows(out) > rows + 300)
    send(watching, signal.SIGINT)
    watching.communicate(timeout=WAIT_S)
    report = (out / "report.html").read_text()
    samples = read_samples(out / "samples.csv")
    assert len(report) < 1_000_000
    assert f"{len(samples)} periods recorded, {samples.lost} lost; 1 faults or bad signals" in report
    assert "frozen: a signal is outside the range" in report
    assert "(T1_degC)" in report
    median_us = np.quantile(samples.columns["write_ns"], 0.5, method="inverted_cdf") / 1e3
    assert f"{plain(float(median_us), 3)}</td>" in report
    assert not console_errors(out / "report.html")


def test_killed_recorder_leaves_whole_lines(hal: Hal, tmp_path: Path) -> None:
    out = tmp_path / "record"
    watching, _ = _watching(hal, out)
    _until(lambda: _rows(out) > 500)
    send(watching, signal.SIGKILL)
    watching.communicate(timeout=WAIT_S)
    content = (out / "samples.csv").read_bytes()
    lines = content.decode().splitlines()
    assert content.endswith(b"\n")
    assert {line.count(",") for line in lines} == {lines[0].count(",")}
    assert len(read_samples(out / "samples.csv")) == len(lines) - 1
    assert not (out / "report.html").exists()
    again = tmp_path / "again"
    hal.run(*WATCH, "--out", str(again), "--for", "1")  # the stream is free for the next one
    assert len(read_samples(again / "samples.csv"))


def test_long_record_goes_on_in_further_files(hal: Hal, tmp_path: Path) -> None:
    out = tmp_path / "record"
    watching, _ = _watching(hal, out, "--rows", "1000", "--keep", "2")
    _until((out / "samples-3.csv").exists)
    rows = _rows(out, "samples-3.csv")
    _until(lambda: _rows(out, "samples-3.csv") > rows + 10)
    send(watching, signal.SIGINT)
    watching.communicate(timeout=WAIT_S)
    names = sorted(path.name for path in out.glob("samples*.csv"))
    assert len(names) == 2
    assert "samples.csv" not in names
    earlier, later = sorted((read_samples(out / name) for name in names), key=lambda part: part.time_s[0])
    assert len(earlier) == 1000
    assert later.time_s[0] > earlier.time_s[-1]
    assert earlier.time_s[0] > 0.9


def test_record_is_never_written_over(hal: Hal, tmp_path: Path) -> None:
    (tmp_path / "samples.csv").write_text("mine")
    done = hal.run(*WATCH, "--out", str(tmp_path), "--for", "1", check=False)
    assert done.returncode == 4
    assert "OUT-FOLDER" in done.stderr
    assert (tmp_path / "samples.csv").read_text() == "mine"
