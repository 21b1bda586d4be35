"""The probe file: the second touch, which changes what is recorded."""

from pathlib import Path

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.probe_toml import read_probe
from trueloop.probing.probe_plan import SecondTouch

STYLUS = "[stylus]\nball_radius_mm = 1.5\nstem_radius_mm = 0.75\n\n[program]\n"


def read(folder: Path, program: str) -> SecondTouch | None:
    file = folder / "probe.toml"
    file.write_text(STYLUS + program)
    return read_probe(file).approach.second


def test_a_point_is_touched_once_unless_the_file_says_otherwise(tmp_path: Path) -> None:
    assert read(tmp_path, "") is None


def test_a_second_touch_has_its_feed_and_its_way_back(tmp_path: Path) -> None:
    second = read(tmp_path, "probe_feed_mm_per_min = 600\nsecond_feed_mm_per_min = 30\nsecond_back_off_mm = 0.4\n")
    assert second == SecondTouch(back_off_mm=0.4, feed_mm_per_min=30.0)


@pytest.mark.parametrize(
    ("program", "line", "says"),
    [
        ("second_feed_mm_per_min = 30\n", 5, "`second_feed_mm_per_min` and `second_back_off_mm` go together"),
        ("second_back_off_mm = 0.4\n", 5, "`second_feed_mm_per_min` and `second_back_off_mm` go together"),
        (
            "second_feed_mm_per_min = 90\nsecond_back_off_mm = 0.4\n",
            5,
            "`second_feed_mm_per_min` is 90, faster than the first touch at 60",
        ),
        ("second_feed_mm_per_min = 30\nsecond_back_off_mm = 0.05\n", 7, "greater than or equal to 0.1, given 0.05"),
    ],
)
def test_what_makes_no_second_touch_is_refused_with_the_line(
    tmp_path: Path, program: str, line: int, says: str
) -> None:
    with pytest.raises(TrueloopError) as refused:
        read(tmp_path, program)
    assert refused.value.code is Code.PRB_FILE and says in refused.value.message
    assert refused.value.place.line == line


CALIBRATION = (
    "[calibration]\neffective_radius_mm = 1.4946\ncosine_um = 3.1\nsine_um = -0.4\nlobes = 3\nscatter_um = 0.3\n"
    "radius_u_um = 0.2\nfrom_deg = -10.0\nto_deg = 190.0\n"
)


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [
        ("1.4946", "2.9892", "more than 0.3 mm off `stylus.ball_radius_mm` 1.5"),  # the diameter
        ("1.4946", "0.05884", "more than 0.3 mm off"),  # inch
        ("1.4946", "nan", "finite"),
        ("1.4946", "1.49\u00ff46", "not a TOML file"),
        ("= 3.1", "= 3100", "3100 µm of lobing"),
        ("to_deg = 190.0", "to_deg = -190.0", "is not a range"),
        ("lobes = 3", "lobes = 0", "lobes"),
    ],
)
def test_a_corrupted_calibration_is_refused(tmp_path: Path, right: str, wrong: str, says: str) -> None:
    assert right in CALIBRATION
    file = tmp_path / "probe.toml"
    file.write_text(STYLUS + CALIBRATION)
    found = read_probe(file).calibration
    assert found is not None and found.effective_radius_mm == 1.4946
    file.write_text(STYLUS + CALIBRATION.replace(right, wrong))
    with pytest.raises(TrueloopError) as refused:
        read_probe(file)
    assert refused.value.code is Code.PRB_FILE and says in refused.value.message


def test_a_calibration_cut_short_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "probe.toml"
    file.write_text(STYLUS + CALIBRATION.partition("from_deg")[0])
    with pytest.raises(TrueloopError) as refused:
        read_probe(file)
    assert refused.value.code is Code.PRB_FILE and "from_deg" in refused.value.message
