"""Every way in which sources of signals, and a LinuxCNC that cannot be reached, are refused."""

import sys
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from tests.support.files import read_as_file
from trueloop.controllers.linuxcnc.realtime.signals.component import Pins, linuxcnc_module
from trueloop.errors import Code, TrueloopError
from trueloop.formats.realtime.signals_toml import read_signals


class HalError(Exception):
    """As LinuxCNC's module has one."""


def _refused_component(_name: str) -> object:
    raise HalError("rtec-signals: HAL: ERROR: duplicate component name, -17")


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.RTC_SOURCE: lambda: read_as_file('image = "lathe.img"\ncycle_hz = 0\n', read_signals),
    Code.RTC_CONNECTION: lambda: Pins(SimpleNamespace(component=_refused_component, error=HalError)),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PRODUCERS[code]()
    assert refusal.value.code is code
    assert any(character.isdigit() for character in refusal.value.message)
    assert refusal.value.hint


def test_a_python_that_linuxcnc_is_not_for_is_told_which_one_is(tmp_path: object) -> None:
    with pytest.raises(TrueloopError, match="cannot load LinuxCNC's module 'hal_of_nobody'") as refusal:
        linuxcnc_module("hal_of_nobody", str(tmp_path))
    assert refusal.value.code is Code.RTC_CONNECTION
    assert sys.executable in refusal.value.message
    assert "/usr/bin/python3 -m venv --system-site-packages" in refusal.value.hint
