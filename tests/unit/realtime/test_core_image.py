"""The core takes the images that the writer writes, and refuses others by the names that the writer's reader has."""

import re
from pathlib import Path

import pytest

from tests.support.bad_images import BAD, PROGRAM, SERIAL, good_image
from trueloop import _core
from trueloop.formats.realtime.image_file import image_to_bytes


def test_a_good_image_is_taken() -> None:
    content = image_to_bytes(good_image())
    assert _core.RealTimeCore(content, SERIAL, PROGRAM).signals == 1
    assert _core.RealTimeCore(content).signals == 1


@pytest.mark.parametrize("what", BAD)
def test_a_bad_one_is_refused_by_the_same_name(what: str) -> None:
    refusal, made = BAD[what]
    with pytest.raises(_core.RealTimeRefusalError) as raised:
        _core.RealTimeCore(made(image_to_bytes(good_image())), SERIAL, PROGRAM)
    number, name, _ = raised.value.args
    assert name == refusal
    assert raised.value.args in _core.realtime_names()["refusals"]
    assert number > 0


@pytest.mark.parametrize("kind", ["phases", "faults", "refusals", "waits"])
def test_names_are_numbered_without_gaps_and_differ(kind: str) -> None:
    names = _core.realtime_names()[kind]
    assert [number for number, _, _ in names] == list(range(len(names)))
    assert len({name for _, name, _ in names}) == len(names)
    assert all(meaning and re.fullmatch("[a-z ]+", name) for _, name, meaning in names)


def test_columns_that_do_not_fit_are_refused() -> None:
    core = _core.RealTimeCore(image_to_bytes(good_image()))
    with pytest.raises(ValueError, match="no column is called x"):
        core.wanted({"position": [[0.0, 0.0, 0.0]], "x": 1})
    with pytest.raises(ValueError, match="no column position"):
        core.step({"signal": 20.0}, {})
    with pytest.raises(ValueError, match=r"travel has shape \[2\], not \(1, up to 3\)"):
        core.wanted({"position": [[0.0, 0.0, 0.0]], "travel": [1.0, 1.0]})
    with pytest.raises(ValueError, match="no setting is called slow"):
        core.step({"position": [[0.0, 0.0, 0.0]]}, {"slow": 1.0})


def test_the_seed_of_the_fuzzer_is_a_good_image() -> None:
    seed = Path(__file__).parents[3] / "crates" / "rtec" / "fuzz" / "seeds" / "good.img"
    assert _core.RealTimeCore(seed.read_bytes(), SERIAL, PROGRAM).signals == 1
