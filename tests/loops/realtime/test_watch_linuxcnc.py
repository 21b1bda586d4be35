"""LinuxCNC itself watched while it cuts: samples.csv beside doubles that a component recorded in the same periods."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.bad_images import good_image
from tests.support.linuxcnc_start import STARTED, STARTER
from tests.support.refusals import refused
from trueloop.controllers.linuxcnc.realtime.configuration import read_configuration
from trueloop.controllers.linuxcnc.realtime.hal_lines import watching, wiring
from trueloop.controllers.linuxcnc.realtime.watch import MOST_PINS, sampled_pins, sampler_lines
from trueloop.errors import Code
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.formats.realtime.samples_csv import read_samples
from trueloop_lab.linuxcnc.realtime.session import QUIET, WIRE, Setup, drive, home, on, put, record
from trueloop_lab.linuxcnc.session import source

RECORDED = ("rtec.periods", "joint.0.pos-cmd", "joint.1.pos-cmd", "rtec.corr-0", "joint.1.f-error", "rtec.in-use-0")
PASSES = "G21 G90 G94 G53 G1 X40. Z-20. F2400\n" + 20 * "G1 X60. Z-120. F2400\nX40. Z-20.\n" + "M2\n"


def _linked() -> dict[str, str]:
    """Signals of the session's own wiring."""
    wiring_of_session = source("realtime/machine.hal") + WIRE
    nets = [line.split() for line in wiring_of_session.splitlines() if line.startswith("net ")]
    return {pin: words[1] for words in nets for pin in words[2:] if pin != "=>"}


def test_every_period_is_as_linuxcnc_had_it(tmp_path: Path) -> None:
    image = good_image()
    lines = sampler_lines(sampled_pins({0: 0, 2: 1}, 1), _linked())
    out, files = tmp_path / "record", {"part.ngc": PASSES.encode(), **STARTER}
    setup = Setup(image_to_bytes(image), files, RECORDED, QUIET + "\n".join(lines) + "\n")
    steps = [
        *(on(), home(), put("rtec.signal-0", 25.0), put("rtec.heartbeat", 1), record()),
        ("start", "part.ngc"),
        ("hal", "loadusr", "-w", *STARTED.split(), "realtime", "watch", "--out", str(out), "--for", "1.5"),
        record(False),
        ("abort",),
    ]
    driven = drive(setup, steps)
    samples = read_samples(out / "samples.csv")
    theirs = {pin: driven[pin] for pin in RECORDED}
    first = theirs["rtec.periods"][np.argmin(np.abs(theirs["joint.0.pos-cmd"] - samples.columns["command_x_mm"][0]))]
    counts = np.round(samples.time_s / samples.period_s)
    best = max(
        (first + shift for shift in range(-3, 4)),
        key=lambda start: _agreeing(counts + start, samples.columns["command_x_mm"], theirs),
    )
    both, mine, other = np.intersect1d(counts + best, theirs["rtec.periods"], return_indices=True)
    assert len(both) > 500
    row = samples.rows(mine)
    np.testing.assert_allclose(row.columns["command_x_mm"], theirs["joint.0.pos-cmd"][other], atol=0.6e-9)
    np.testing.assert_allclose(row.columns["command_z_mm"], theirs["joint.1.pos-cmd"][other], atol=0.6e-9)
    np.testing.assert_allclose(row.mm("correction")[:, 0], theirs["rtec.corr-0"][other], atol=0.6e-9)
    np.testing.assert_allclose(row.mm("following_error")[:, 2], theirs["joint.1.f-error"][other], atol=0.6e-9)
    np.testing.assert_allclose(row.columns["signal_0"], theirs["rtec.in-use-0"][other], atol=0.6e-6)


def _agreeing(counts: np.ndarray, command: np.ndarray, theirs: dict[str, np.ndarray]) -> int:
    _, mine, other = np.intersect1d(counts, theirs["rtec.periods"], return_indices=True)
    return int(np.sum(np.abs(command[mine] - theirs["joint.0.pos-cmd"][other]) < 1e-8))


@pytest.fixture
def ini(tmp_path: Path) -> Path:
    for file in ("machine.ini", "machine.hal"):
        (tmp_path / file).write_text(source(file))
    (tmp_path / "extra.hal").write_text("")
    return tmp_path / "machine.ini"


def test_lines_join_the_signals_that_pins_are_on(ini: Path) -> None:
    configuration = read_configuration(ini)
    made = wiring(configuration)
    changes = watching(configuration, made, 2)
    nets = [change.text.split() for change in changes if change.text.startswith("net ")]
    before = [change.text.split() for change in made.changes if change.text.startswith("net ")]
    on_signal = {pin: words[1] for words in before for pin in words[2:] if pin != "=>"}
    assert on_signal["rtec.at-0"] == next(words[1] for words in nets if "rtec.at-0" in words)
    assert on_signal["rtec.out-2"] == next(words[1] for words in nets if "rtec.out-2" in words)
    pins = [words[2] for words in nets]
    assert {"joint.1.f-error", "rtec.in-use-1", "rtec.write.time"} < set(pins)
    load = next(change.text for change in changes if change.text.startswith("loadrt"))
    kinds = load.partition("cfg=")[2].split(",")
    assert sum(map(len, kinds)) == len(nets)
    assert max(map(len, kinds)) <= MOST_PINS
    assert all(words[2] == "rtec.periods" for words in nets if words[-1].endswith(".pin.0"))


def test_a_second_sampler_is_refused(ini: Path) -> None:
    (ini.parent / "extra.hal").write_text("loadrt sampler depth=100 cfg=f\n")
    configuration = read_configuration(ini)
    error = refused(watching, configuration, wiring(configuration), 0)
    assert error.code is Code.RTC_HAL
    assert error.place.line == 1
