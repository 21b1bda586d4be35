"""What `trueloop realtime hal` prints, done by hand on a configuration: the corrector works."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.loops.realtime.test_component import IN_FORCE, PROGRAM, SECOND_ORDER_MM
from tests.support.linuxcnc_start import STARTED, STARTER
from tests.support.realtime_lathe import LATHE, RECORD, WIDE, LinearLathe, added, applied, commanded, stood
from tests.support.realtime_signals import image_bytes, model_of
from trueloop.controllers.linuxcnc.realtime.configuration import read_configuration
from trueloop.controllers.linuxcnc.realtime.hal_lines import Wiring, wiring
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.image_file import image_to_bytes, read_image
from trueloop.realtime.image import TRAVEL_TOLERANCE_MM, Bank, Identity, Image, RealTimeLimits, Signal
from trueloop_lab.linuxcnc.realtime.session import Setup, drive, get, home, on, put, record, run, wait, with_entries
from trueloop_lab.linuxcnc.session import source

EXAMPLES = Path("/usr/share/doc/linuxcnc/examples/sample-configs")


def wired(folder: Path, image: Image | None = None, units: str = "mm") -> tuple[Wiring, dict[str, str]]:
    """The virtual lathe without a corrector, and its files with the changes made."""
    texts = {name: source(name) for name in ("machine.ini", "machine.hal")} | {"extra.hal": "net at joint.0.pos-cmd\n"}
    texts["machine.ini"] = with_entries(texts["machine.ini"], [("TRAJ", "LINEAR_UNITS", units)])
    for name, text in texts.items():
        (folder / name).write_text(text)
    made = wiring(read_configuration(folder / "machine.ini"), image, "image.rtec")
    return made, applied(made.changes, texts)


def test_the_virtual_lathe_wired_by_the_printed_lines_is_corrected(tmp_path: Path) -> None:
    _, files = wired(tmp_path)
    assert "rtec" not in source("machine.hal")
    contents = {name: text.encode() for name, text in files.items()} | {"p.ngc": PROGRAM}
    setup = Setup(LATHE.image, contents, (*RECORD, "rtec.homed", "rtec.machine-on", "rtec.line", "rtec.tool-2"))
    steps = [on(), home(), *IN_FORCE, record(), run("p.ngc"), record(False)]
    steps += [put("rtec.limit", -1)]
    driven = drive(setup, [*steps, wait("rtec.phase", 6), get("pause", "halui.program.pause")])
    assert not driven.messages
    at = commanded(driven)
    assert np.ptp(at, axis=0).min() > 29.0
    np.testing.assert_allclose(stood(driven) - at, LATHE.added_mm(at), atol=SECOND_ORDER_MM)
    assert np.abs(added(driven)).max() > 0.03
    assert max(np.abs(driven[f"joint.{joint}.f-error"]).max() for joint in (0, 1)) < 1e-9
    assert driven["rtec.homed"].all()
    assert driven["rtec.machine-on"].all()
    assert set(driven["rtec.line"]) > {3.0, 4.0}
    assert driven.got["pause"] is True


def test_the_printed_lines_with_signals_run(tmp_path: Path) -> None:
    """LinuxCNC comes up: it waits for the component by its own name, not by that of its program."""
    signals = model_of(("T1",))
    (tmp_path / "made.rtec").write_bytes(image_bytes(signals))
    image = replace(read_image(tmp_path / "made.rtec"), limits=RealTimeLimits(WIDE))
    _, files = wired(tmp_path, image)
    files["rtec.hal"] = re.sub(r"(-Wn \S+) \S+", rf"\1 {STARTED}", files["rtec.hal"])
    contents = {name: text.encode() for name, text in files.items()} | {
        **STARTER,
        "SIGNALS.toml": b'image = "image.rtec"\n[replay.log]\nfile = "log.csv"\n[signals.T1]\nsource = "log"\n',
        "log.csv": b"time_s,T1_degC\n0,30\n100000,30\n",
    }
    steps = [on(), home(), *IN_FORCE, get("now", "rtec.corr-0", "rtec.in-use-0", "rtec.fault-code")]
    driven = drive(Setup(image_to_bytes(image), contents), steps)
    # The spindle, which carries the part, is 1 µm further out for each of 10 °C: the tool has to follow it.
    assert driven.got["now"] == [pytest.approx(0.010, abs=1e-6), 30.0, 0]


def test_a_joint_that_homes_to_the_end_of_its_travel_is_corrected(tmp_path: Path) -> None:
    """Its switch is outside: LinuxCNC brings it to rest at the end from there, a hair outside of it."""
    beyond = []
    for start in (303.0, 310.456):
        entries = [(section, "MAX_LIMIT", "300") for section in ("JOINT_0", "AXIS_X")]
        entries += [("JOINT_0", "HOME_OFFSET", f"{start}")]
        # E of X is 0.1 µm a mm: what is added at X 300 points inwards.
        lathe = LinearLathe(np.diag([1e-4, 0.0, 0.0]), ((-500.0, 300.0), *WIDE[1:]))
        steps = [on(), home(), *IN_FORCE, record(), ("sleep", 0.05), record(False), get("fault", "rtec.fault-code")]
        driven = drive(Setup(lathe.image, ini=entries, record=RECORD), steps)
        assert driven.got["fault"] == 0
        beyond.append(float(driven["joint.0.pos-cmd"][-1]) - 300.0)
        assert driven["rtec.corr-0"][-1] == pytest.approx(-0.03 / (1 + 1e-4), abs=1e-9)
    assert 1e-9 < max(beyond) < TRAVEL_TOLERANCE_MM / 2


def test_signals_and_serial_come_from_the_image(tmp_path: Path) -> None:
    signals = tuple(Signal(name, "°C", 20.0, 10.0, 40.0, 2.0) for name in ("T1", "T2"))
    limits = RealTimeLimits(((-500, 2000), (-1, 1), (-2000, 2000)))
    image = Image(Identity("lathe", "4711"), limits, Bank(signals, (), np.zeros((3, 3, 3))))
    assert len(image_to_bytes(image)) > 1024
    _, files = wired(tmp_path, image)
    assert "loadrt rtec image=image.rtec serial=4711\n" in files["machine.hal"]
    assert files["rtec.hal"].count("rtec-signals.") == 2 + 2 * len(signals)
    assert "\nloadusr -Wn rtec-signals " in files["rtec.hal"]
    without = replace(image, bank=replace(image.bank, signals=(), slope=np.zeros((1, 3, 3))) if image.bank else None)
    assert "rtec-signals" not in wired(tmp_path, without)[1]["rtec.hal"]


def test_a_path_with_a_blank_is_no_word_of_hal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/opt/my tools/ä/bin/python")
    (tmp_path / "made.rtec").write_bytes(image_bytes(model_of(("T1",))))
    image = replace(read_image(tmp_path / "made.rtec"), limits=RealTimeLimits(WIDE))
    made, files = wired(tmp_path, image)
    assert "loadusr -Wn rtec-signals trueloop realtime signals SIGNALS.toml\n" in files["rtec.hal"]
    assert made.remarks[-1].endswith("sudo ln -s '/opt/my tools/ä/bin/trueloop' /usr/local/bin/trueloop")
    with pytest.raises(TrueloopError, match="2 words") as refusal:
        wiring(read_configuration(tmp_path / "machine.ini"), image, "/opt/my tools/image.rtec")
    assert refusal.value.code is Code.RTC_HAL


@pytest.mark.parametrize(
    ("ini", "unit", "axes"),
    [
        ("by_interface/parport/nist-lathe/inch.ini", "25.4", "012"),
        ("by_interface/mesa/hm2-servo/5i20.ini", "25.4", "012"),
        ("by_interface/mesa/hm2-stepper/5i20.ini", "25.4", "012"),
        ("by_interface/parport/stepper/stepper_mm.ini", "1", "012"),
        ("by_interface/parport/etch-servo/etch.ini", "25.4", "01"),
        ("by_machine/sherline/SherlineLathe/SherlineLathe_mm.ini", "1", "012"),
    ],
)
def test_every_drive_of_a_known_configuration_is_wired_to_the_corrector(ini: str, unit: str, axes: str) -> None:
    read = read_configuration(EXAMPLES / ini)
    changes = wiring(read).changes
    named = {Path(change.place.file or "") for change in changes if change.where != "new"}
    before = {path.name: path.read_bytes() for path in named}
    files = applied(changes, {name: content.decode() for name, content in before.items()})
    words = [line.partition("#")[0].split() for text in files.values() for line in text.splitlines()]
    for axis in "012":
        for pin in ("at", "cmd", "out", "drive-fb", "fb", "tool"):
            assert sum(f"rtec.{pin}-{axis}" in line for line in words) == (axis in axes)
    assert f"setp rtec.mm-per-unit {unit}\n" in files["rtec.hal"]
    assert "HALFILE = rtec.hal\n" in files[Path(ini).name]
    thread = [line[1] for line in words if line[:1] == ["addf"] and line[2].startswith("servo")]
    first, last = thread.index("rtec.read"), thread.index("rtec.write")
    assert thread[first : last + 1] == ["rtec.read", "motion-command-handler", "motion-controller", "rtec.write"]
    assert {path.name: path.read_bytes() for path in named} == before


def test_every_configuration_that_comes_with_linuxcnc_is_wired_or_refused_with_a_reason() -> None:
    wired_count = 0
    for ini in sorted(EXAMPLES.rglob("*.ini")):
        try:
            wired_count += bool(wiring(read_configuration(ini)).changes)
        except TrueloopError as refused:
            assert refused.code is Code.RTC_HAL
            assert refused.hint
    assert wired_count > 100


@pytest.mark.parametrize(
    ("written", "mm"), [("mm", "1"), ("inch", "25.4"), ("0.0393700787401575", "25.4"), ("1.0", "1")]
)
def test_a_unit_is_a_word_or_how_many_of_it_a_millimetre_has(written: str, mm: str, tmp_path: Path) -> None:
    _, files = wired(tmp_path, units=written)
    assert f"setp rtec.mm-per-unit {mm}\n" in files["rtec.hal"]
