"""1-Wire thermometers, their files laid out as the kernel does."""

from pathlib import Path

import pytest

from tests.support.signals import reading
from trueloop.controllers.linuxcnc.realtime.signals.setup import OneWire, temperature_degC

NINE = "50 05 4b 46 7f ff 0c 10 1c"


def device(folder: Path, text: str, file: str = "w1_slave") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / file).write_text(text)
    return folder


def w1(milli: int, verdict: str = "YES", nine: str = NINE) -> str:
    return f"{nine} : crc=1c {verdict}\n{nine} t={milli}\n"


@pytest.mark.parametrize(("milli", "degC"), [(21312, 21.312), (-1062, -1.062), (0, 0.0), (84937, 84.937)])
def test_a_reading_is_taken(tmp_path: Path, milli: int, degC: float) -> None:
    assert temperature_degC(device(tmp_path / "28-1", w1(milli))) == degC
    assert temperature_degC(device(tmp_path / "28-2", f"{milli}\n", "temperature")) == degC


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (w1(21312, "NO"), "checksum"),
        (w1(85000), "power"),
        (w1(0, nine="00 00 00 00 00 00 00 00 00"), "pulled down"),
        ("", "is not the output"),
        (f"{NINE} : crc=1c YES\n", "is not the output"),
        ("t=21312\n", "is not the output"),
    ],
)
def test_what_is_no_reading_is_refused(tmp_path: Path, text: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        temperature_degC(device(tmp_path / "28-1", text))


@pytest.mark.parametrize("text", ["85000\n", "", "warm\n"])
def test_the_other_file_is_refused_alike(tmp_path: Path, text: str) -> None:
    with pytest.raises(ValueError, match=r"power|invalid literal"):
        temperature_degC(device(tmp_path / "28-1", text, "temperature"))


def test_one_sensor_that_fails_leaves_the_others_alone(tmp_path: Path) -> None:
    device(tmp_path / "28-1", w1(21312))
    with reading(OneWire({"T1": "28-1", "T2": "28-2"}, 0.01, tmp_path)) as source:
        first = source.wait_for("T1")
        source.wait_for("T1", lambda later: later.time_s > first.time_s)
        assert "T2" not in source.board.readings()
        assert "28-2" in source.reader.why("T2")
        assert len([line for line in source.said if "T2" in line]) == 1
        device(tmp_path / "28-2", w1(19500))
        assert source.wait_for("T2").value == 19.5
        assert source.reader.why("T2") == ""
        device(tmp_path / "28-2", w1(85000))
        source.wait_for("T1", lambda later: bool(source.reader.why("T2")))
        assert source.board.readings()["T2"].value == 19.5
