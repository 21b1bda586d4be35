"""Samples that cannot be judged, and a LinuxCNC that cannot be watched."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.files import read_as_file
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.samples_csv import read_samples

PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.RTC_SAMPLES: lambda: read_as_file("time_s,command_x_mm\n0.0,0.0\n0.001,0.0\n", read_samples)
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PRODUCERS[code]()
    assert refusal.value.code is code
    assert any(character.isdigit() for character in refusal.value.message)
    assert refusal.value.hint


def test_samples_that_are_not_there_are_named() -> None:
    with pytest.raises(TrueloopError) as refusal:
        read_samples(Path("no-such-samples-1.csv"))
    assert refusal.value.code is Code.RTC_SAMPLES
