"""What a configuration makes, and how each mistake in it is said: with file, line and hint."""

import hashlib
import json
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, run
from tests.support.realtime_signals import model_of, write_configuration, write_image
from trueloop.controllers.linuxcnc.realtime.signals.mqtt import Mqtt, Topic
from trueloop.controllers.linuxcnc.realtime.signals.mtconnect import MtConnect
from trueloop.controllers.linuxcnc.realtime.signals.readings import Board
from trueloop.controllers.linuxcnc.realtime.signals.serial_lines import SerialLines
from trueloop.controllers.linuxcnc.realtime.signals.setup import OneWire
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.signals_toml import SignalsFile
from trueloop.jobs.realtime.wired import prepared
from trueloop.machine.model.history import Lag

SCREW = Lag("screw", "T1", 60.0)

WHOLE = """
[serial.box]
port = "/dev/ttyUSB0"
baud = 115200
[one_wire.bus]
folder = "w1"
[mqtt.shop]
host = "broker"
user_env = "TEST_SIGNALS_USER"
password_env = "TEST_SIGNALS_PASSWORD"
tls = true
[mtconnect.agent]
url = "http://10.0.0.7:5000/lathe"
held = true

[signals.T1]
source = "box"
column = 2
unit = "degC"
[signals.T2]
source = "box"
pattern = 'T2=([\\d.]+)'
unit = "degF"
[signals.T3]
source = "bus"
device = "28-1"
[signals.T4]
source = "shop"
topic = "lathe/T4"
path = "value"
time_path = "at"
qos = 1
unit = "degC"
[signals.T5]
source = "agent"
item = "Xtemp"
unit = "degC"
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("TEST_SIGNALS_USER", "lathe")
    monkeypatch.setenv("TEST_SIGNALS_PASSWORD", "secret")
    write_image(tmp_path, model_of(("T2", "T1", "screw"), (SCREW,)))
    yield tmp_path


def test_sources_are_made_as_configured(folder: Path) -> None:
    write_image(folder, model_of(("T1", "T2", "T3", "T4", "T5")))
    setup = prepared(write_configuration(folder, WHOLE)).setup
    box, bus, shop, agent = (setup.feeds[name] for name in ("box", "bus", "shop", "agent"))
    assert isinstance(box, SerialLines)
    assert (box.port, box.baud) == ("/dev/ttyUSB0", 115200)
    assert box.parts["T1"].value("1,20.5") == 20.5
    assert box.parts["T2"].value("x T2=70.5") == 70.5
    assert bus == OneWire({"T3": "28-1"}, 1.0, folder / "w1")
    assert isinstance(shop, Mqtt)
    assert (shop.host, shop.port, shop.user, shop.password, shop.tls) == ("broker", 8883, "lathe", "secret", True)
    assert shop.topics == {"T4": Topic("lathe/T4", "value", "at", 1)}
    assert agent == MtConnect("http://10.0.0.7:5000/lathe", {"T5": "Xtemp"}, 1.0, True)
    board = Board(setup.scale)
    for name in setup.sensors:
        board.put(name, 212.0, 0.0)
    boiling = {name: read.value for name, read in board.readings().items()}
    assert boiling == pytest.approx({**dict.fromkeys(setup.sensors, 212.0), "T2": 100.0})


PAIR = """
[replay.log]
file = "log.csv"
[signals.T1]
source = "log"
[signals.T2]
source = "log"
"""


def write_log(folder: Path, values: "np.ndarray | list[float]" = (20.0, 20.0, 30.0)) -> None:  # type: ignore[assignment]
    rows = [f"{100 * k},{value},21" for k, value in enumerate(values)]
    (folder / "log.csv").write_text("\n".join(["time_s,T1_degC,T2_degC", *rows, ""]))


def test_order_is_the_images_and_lags_come_from_the_model(folder: Path) -> None:
    write_log(folder)
    setup = prepared(write_configuration(folder, PAIR, {"model": '"model.json"', "log": '"signals.csv"'})).setup
    assert [signal.name for signal in setup.wanted] == ["T2", "T1", "screw"]
    assert setup.sensors == ("T2", "T1")
    assert setup.lags == (SCREW,)
    assert setup.log is not None
    assert setup.log.columns == ("T2_degC", "T1_degC")
    assert setup.log.keep_s == 8 * 60
    assert setup.states["screw"] is not None
    assert setup.states["screw"].known(SCREW, setup.rules)


def test_a_replay_that_begins_later_has_the_past_of_its_log(folder: Path) -> None:
    """At 200 s T1 has risen by 10 K in 100 s, straight: what lags of 60 s behind is 10/100·τ·(1 − e^(−100/60))."""
    write_log(folder, [20.0, 20.0, 30.0, 30.0])
    later = PAIR.replace('"log.csv"', '"log.csv"\nstart_s = 200')
    state = prepared(write_configuration(folder, later, {"model": '"model.json"'})).setup.states["screw"]
    assert state is not None
    assert state.value == pytest.approx(30 - 6 * (1 - np.exp(-100 / 60)), abs=1e-9)
    assert state.input == 30.0
    assert state.stated


T1 = '[signals.T1]\nsource = "box"\n'
BOX = '[serial.box]\nport = "/dev/ttyUSB0"\n'
FULL = BOX + T1 + 'column = 1\nunit = "degC"\n'
MISTAKES = {
    "unknown key": (FULL + "colum = 2\n", 9, "did you mean 'column'"),
    "unknown source": ('[signals.T1]\nsource = "bax"\n', 4, "[serial.bax]"),
    "two sources": (BOX + '[mqtt.box]\nhost = "a"\n' + T1, 8, "its name there once"),
    "the same signal twice": (FULL + T1, 9, "keep one"),
    "signal not needed": (FULL + FULL.replace("T1", "T11").replace(BOX, ""), 9, "did you mean 'T1'"),
    "signal without a source": (BOX, None, "[signals.T1]"),
    "a constant": ('[signals.T1]\nsource = "constant"\nvalue = 20.0\nunit = "degC"\n', 4, "constants = true"),
    "no unit": (BOX + T1 + "column = 1\n", 5, "unit"),
    "no column": (BOX + T1 + 'unit = "degC"\n', 5, "column"),
    "another kind's key": (FULL + 'topic = "a"\n', 9, "pattern, column"),
    "unit of another kind": (FULL.replace("degC", "rpm"), 8, "is it the sensor"),
    "no unit at all": (FULL.replace("degC", "K"), 8, "docs/realtime-signals.md"),
    "pattern that is none": (BOX + T1 + "pattern = '(T1'\nunit = \"degC\"\n", 7, "docs/realtime-signals.md"),
    "pattern without group": (BOX + T1 + "pattern = 'T1'\nunit = \"degC\"\n", 7, "docs/realtime-signals.md"),
    "wildcard": ('[mqtt.a]\nhost = "a"\n[signals.T1]\nsource="a"\ntopic="a/#"\nunit="degC"\n', 7, "docs"),
    "variable not set": (
        '[mqtt.a]\nhost = "a"\npassword_env = "NOT_SET_HERE"\n[signals.T1]\nsource="a"\ntopic="a"\nunit="degC"\n',
        5,
        "where LinuxCNC is started",
    ),
    "address": ('[mtconnect.a]\nurl = "a:5000"\n[signals.T1]\nsource="a"\nitem="x"\nunit="degC"\n', 4, "http://"),
    "value out of bounds": (FULL.replace('B0"', 'B0"\nbaud = 5'), 5, "docs/realtime-signals.md"),
    "log without it": ('[replay.a]\nfile="log.csv"\n[signals.T1]\nsource="a"\nrecorded="T7"\n', 5, "recorded"),
    "start outside the log": ('[replay.a]\nfile="log.csv"\nstart_s=900\n[signals.T1]\nsource="a"\n', 5, "time_s"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_said_with_its_line(tmp_path: Path, mistake: str) -> None:
    text, line, hint = MISTAKES[mistake]
    write_image(tmp_path, model_of(("T1",)))
    write_log(tmp_path)
    path = write_configuration(tmp_path, text)
    with pytest.raises(TrueloopError) as refused:
        prepared(path)
    assert refused.value.code is Code.RTC_SOURCE
    assert refused.value.place.file == str(path)
    assert refused.value.place.line == line, refused.value
    assert hint in refused.value.hint


def refusal(path: Path) -> TrueloopError:
    with pytest.raises(TrueloopError) as refused:
        prepared(path)
    assert refused.value.place.file == str(path)
    return refused.value


def test_a_lag_is_not_read_but_computed(folder: Path) -> None:
    write_log(folder)
    text = PAIR + '[signals.screw]\nsource = "log"\n'
    assert "computed from that" in refusal(write_configuration(folder, text, {"model": '"model.json"'})).message
    missing = refusal(write_configuration(folder, PAIR))
    assert "'screw'" in missing.message
    assert "`model`" in missing.hint


def test_another_model_is_refused(folder: Path) -> None:
    write_log(folder)
    path = write_configuration(folder, PAIR, {"model": '"model.json"'})
    prepared(path)
    (folder / "model.json").write_text((folder / "model.json").read_text() + " ")
    found = hashlib.sha256((folder / "model.json").read_bytes()).hexdigest()
    assert found[:12] in refusal(path).message


def test_replays_run_at_one_speed_and_with_nothing_measured(tmp_path: Path) -> None:
    write_image(tmp_path, model_of(("T1", "T2")))
    write_log(tmp_path)
    fast = '[replay.a]\nfile="log.csv"\nspeed=2.0\n[signals.T1]\nsource="a"\n'
    other = fast.replace("[replay.a]", "[replay.b]").replace("2.0", "3.0").replace("T1", "T2").replace('"a"', '"b"')
    assert "2 speeds: 2, 3" in refusal(write_configuration(tmp_path, fast + other)).message
    live = BOX + '[signals.T2]\nsource="box"\ncolumn=1\nunit="degC"\n'
    assert "2 times their pace" in refusal(write_configuration(tmp_path, fast + live)).message
    both = prepared(write_configuration(tmp_path, fast + other.replace("3.0", "2.0"), {"every_s": 0.5})).setup
    assert (both.clock.speed, both.rules.least_gap_s) == (2.0, 3.0), "three turns of half a second, a second each"
    assert prepared(write_configuration(tmp_path, fast.replace("2.0", "1.0") + live))


def test_equilibrium_is_a_moment_that_was(folder: Path) -> None:
    write_log(folder)
    past, future = (datetime.now(UTC) + timedelta(seconds=s) for s in (-600, 600))
    setup = prepared(write_configuration(folder, PAIR, {"model": '"model.json"', "equilibrium": past.isoformat()}))
    assert setup.setup.rules.equilibrium_s == pytest.approx(time.time() - 600, abs=60)
    top = {"model": '"model.json"', "equilibrium": future.isoformat()}
    assert "in the future" in refusal(write_configuration(folder, PAIR, top)).message


def test_check_prints_values_and_judges_ranges(tmp_path: Path) -> None:
    write_image(tmp_path, model_of(("T1", "T2")))
    write_log(tmp_path)
    path = write_configuration(tmp_path, PAIR)
    good = json.loads(run("realtime", "signals", path, "--check", "--json"))["signals"]
    assert [(one["name"], one["source"], one["fault"]) for one in good] == [("T1", "log", ""), ("T2", "log", "")]
    assert good[0]["value"] == pytest.approx(20.0)
    assert 0 <= good[0]["age_s"] < 10
    assert "good" in run("realtime", "signals", path, "--check")
    write_log(tmp_path, [70.0, 70.0, 70.0])
    out = invoke("realtime", "signals", path, "--check", status=1).stdout
    assert "outside the range" in out
    assert "10 … 60" in out
    assert not (tmp_path / "signals.csv").exists()


def test_check_says_why_a_signal_is_not_there(folder: Path) -> None:
    sensor = folder / "28-1"
    sensor.mkdir()
    nine = "50 05 4b 46 7f ff 0c 10 1c"
    text = '[one_wire.bus]\nfolder = "."\n[signals.T1]\nsource="bus"\ndevice="28-1"\n'
    text += '[signals.T2]\nsource="bus"\ndevice="28-2"\n'
    path = write_configuration(folder, text, {"model": '"model.json"'})
    (sensor / "w1_slave").write_text(f"{nine} : crc=1c YES\n{nine} t=21312\n")
    found = invoke("realtime", "signals", path, "--check", "--json", "--wait", "2.5", status=1).stdout
    t2, t1, screw = json.loads(found)["signals"]
    assert (t1["value"], t1["fault"]) == (21.312, "")
    assert t2["value"] is None
    assert "28-2" in t2["fault"]
    assert screw["value"] is None
    assert "known in 0.08 h" in screw["fault"]
    (sensor / "w1_slave").write_text(f"{nine} : crc=1c NO\n{nine} t=21312\n")
    assert "checksum" in invoke("realtime", "signals", path, "--check", "--wait", "0.3", status=1).stdout


def test_every_key_is_documented() -> None:
    page = Path(__file__).parents[4].joinpath("docs", "realtime-signals.md").read_text(encoding="utf-8")
    for name, field in SignalsFile.model_fields.items():
        assert f"`{name}`" in page or f"[{name}." in page, name
        for inner in getattr(field.annotation, "__args__", ()):
            for key in getattr(inner, "model_fields", {}):
                assert f"`{key}`" in page, key
