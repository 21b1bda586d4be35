"""A component that cannot be compiled, and configurations of LinuxCNC that the corrector cannot be put into."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

from trueloop.controllers.linuxcnc.component import compiled, source
from trueloop.controllers.linuxcnc.realtime.configuration import read_configuration
from trueloop.controllers.linuxcnc.realtime.hal_lines import wiring
from trueloop.controllers.linuxcnc.realtime.install import check_symbols, check_version
from trueloop.controllers.linuxcnc.realtime.session import with_entries
from trueloop.errors import Code, TrueloopError


def _wired(*entries: tuple[str, str, str], hal: str = "") -> object:
    """The virtual lathe with other entries in its INI file, or more lines of HAL."""
    with tempfile.TemporaryDirectory() as folder:
        ini = Path(folder, "machine.ini")
        ini.write_text(with_entries(source("machine.ini"), entries))
        Path(folder, "machine.hal").write_text(source("machine.hal"))
        Path(folder, "extra.hal").write_text(hal)
        return wiring(read_configuration(ini))


def _five_axes() -> object:
    return _wired(("KINS", "KINEMATICS", "5axiskins"))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.RTC_BUILD: lambda: check_version("2.8.4"),
    Code.RTC_HAL: _five_axes,
}
HAL = "a configuration"
OTHERS: dict[str, Callable[[], object]] = {
    "two joints of one axis": lambda: _wired(("KINS", "KINEMATICS", "trivkins coordinates=xx")),
    "a table of its own": lambda: _wired(("JOINT_1", "COMP_FILE", "z.comp")),
    "another unit": lambda: _wired(("TRAJ", "LINEAR_UNITS", "cubit")),
    "there already": lambda: _wired(hal="addf rtec.read servo-thread\n"),
    "a script": lambda: _wired(("HAL", "POSTGUI_HALFILE", "2wire.tcl")),
    "a file that is not there": lambda: _wired(("HAL", "POSTGUI_HALFILE", "2none.hal")),
    "a file without an end": lambda: _wired(hal="source extra.hal\n"),
    "no INI": lambda: read_configuration(Path("no-such-machine-1.ini")),
}
SAYS = {
    "two joints of one axis": "axis X has joints 0 and 1",
    "a table of its own": "joint 1 has COMP_FILE = z.comp",
    "another unit": "LINEAR_UNITS = cubit",
    "there already": "the corrector is in it already: 'addf rtec.read servo-thread'",
    "a script": "2wire.tcl is a script",
    "a file that is not there": "2none.hal",
    "a file without an end": "extra.hal is sourced 51 levels deep",
    "no INI": "no-such-machine-1.ini",
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_configuration_is_refused_by_what_stands_in_the_way(what: str) -> None:
    with pytest.raises(TrueloopError, match=r".") as refusal:
        OTHERS[what]()
    assert refusal.value.code is Code.RTC_HAL
    assert SAYS[what] in refusal.value.message
    assert refusal.value.hint
    assert refusal.value.place.file


@pytest.mark.parametrize("version", ["2.8.4", "2.10.0~pre2", "3.0", "of no version"])
def test_versions_that_it_is_not_made_for_are_refused(version: str) -> None:
    with pytest.raises(TrueloopError, match=version) as refusal:
        check_version(version)
    assert refusal.value.code is Code.RTC_BUILD


@pytest.mark.parametrize("version", ["2.9.0~pre1+git20230208.f1270d6ed7", "2.9.4", "2.9.7"])
def test_versions_that_it_is_made_for_pass(version: str) -> None:
    check_version(version)


def test_the_compiler_s_words_are_told() -> None:
    component = (
        b'component broken; pin in bit p; function _; license "GPL";\n;;\nFUNCTION(_) {}\n#error "line 4 of it"\n'
    )
    with pytest.raises(TrueloopError, match="line 4 of it") as refusal:
        compiled("broken", {"broken.comp": component}, code=Code.RTC_BUILD)
    assert refusal.value.code is Code.RTC_BUILD
    assert refusal.value.place.file == "broken.comp"


def test_a_module_that_could_panic_is_refused() -> None:
    component = b"""component panics; pin in bit p; function _; license "GPL";
;;
void core_panicking_panic(void);
void core_panicking_panic(void) { for (;;) {} }
FUNCTION(_) { if (period < 0) core_panicking_panic(); }
"""
    with pytest.raises(TrueloopError, match="core_panicking_panic") as refusal:
        check_symbols(compiled("panics", {"panics.comp": component}, code=Code.RTC_BUILD))
    assert refusal.value.code is Code.RTC_BUILD


def test_what_is_no_module_is_refused() -> None:
    with pytest.raises(TrueloopError, match=r"rtec\.so"):
        check_symbols(b"no module at all, 1")
