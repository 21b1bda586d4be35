"""A component that cannot be compiled, and configurations of LinuxCNC that the corrector cannot be put into."""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from trueloop.controllers.linuxcnc.realtime.configuration import read_configuration
from trueloop.controllers.linuxcnc.realtime.hal_lines import wiring
from trueloop.controllers.linuxcnc.realtime.install import check_symbols, check_version, compiled
from trueloop.errors import Code, TrueloopError
from trueloop.realtime.image import Bank, Identity, Image, RealTimeLimits
from trueloop_lab.linuxcnc.realtime.session import with_entries
from trueloop_lab.linuxcnc.session import source

MOVES = ((-500.0, 2000.0), (-1.0, 1.0), (-2000.0, 2000.0))
"""Travel of the virtual lathe: X and Z as its limits are, and no Y."""


def _image(*travel: tuple[float, float]) -> Image:
    limits = RealTimeLimits((*travel, *MOVES[len(travel) :]))  # type: ignore[arg-type]
    return Image(Identity("lathe", "4711"), limits, Bank((), (), np.zeros((1, 3, 3))))


def _wired(*entries: tuple[str, str, str], hal: str = "", image: Image | None = None) -> object:
    """The virtual lathe with other entries in its INI file, or more lines of HAL."""
    with tempfile.TemporaryDirectory() as folder:
        ini = Path(folder, "machine.ini")
        ini.write_text(with_entries(source("machine.ini"), entries))
        Path(folder, "machine.hal").write_text(source("machine.hal"))
        Path(folder, "extra.hal").write_text(hal)
        return wiring(read_configuration(ini), image)


def _five_axes() -> object:
    return _wired(("KINS", "KINEMATICS", "5axiskins"))


PRODUCERS: dict[Code, Callable[[], object]] = {Code.RTC_BUILD: lambda: check_version("2.8.4"), Code.RTC_HAL: _five_axes}
HAL = "a configuration"
OTHERS: dict[str, Callable[[], object]] = {
    "two joints of one axis": lambda: _wired(("KINS", "KINEMATICS", "trivkins coordinates=xx")),
    "a table of its own": lambda: _wired(("JOINT_1", "COMP_FILE", "z.comp")),
    "another unit": lambda: _wired(("TRAJ", "LINEAR_UNITS", "cubit")),
    "there already": lambda: _wired(hal="addf rtec.read servo-thread\n"),
    "a script": lambda: _wired(("HAL", "POSTGUI_HALFILE", "2wire.tcl")),
    "a file that is not there": lambda: _wired(("HAL", "POSTGUI_HALFILE", "2none.hal")),
    "a file without an end": lambda: _wired(hal="source extra.hal\n"),
    "limits outside the travel": lambda: _wired(image=_image((-30.0, 2000.0))),
    "limits outside by two tolerances": lambda: _wired(("JOINT_1", "MAX_LIMIT", "2000.0002"), image=_image()),
    "limits of another unit": lambda: _wired(("TRAJ", "LINEAR_UNITS", "inch"), image=_image()),
    "no limit": lambda: _wired(("JOINT_0", "MIN_LIMIT", ""), image=_image()),
    "an axis too many": lambda: _wired(image=_image(MOVES[0], (-200.0, 200.0))),
    "an axis that never stands at 0": lambda: _wired(image=_image(MOVES[0], (1.0, 2.0))),
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
    "limits outside the travel": "X may be commanded from -500 to 2000 mm ([JOINT_0]), the image's travel is -30",
    "limits outside by two tolerances": "Z may be commanded from -2000 to 2000 mm ([JOINT_1])",
    "limits of another unit": "X may be commanded from -12700 to 50800 mm",
    "no limit": "[JOINT_0]MIN_LIMIT =  is not a number",
    "an axis too many": "an axis Y that travels from -200 to 200 mm, the configuration has X, Z alone",
    "an axis that never stands at 0": "an axis Y that travels from 1 to 2 mm",
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


def test_limits_at_the_ends_of_the_travel_belong_to_it() -> None:
    """To 0.1 µm, in whatever unit; and of numbers that fit in another unit that unit is named."""
    assert _wired(image=_image())
    assert _wired(("JOINT_1", "MAX_LIMIT", "2000.00009"), image=_image())
    inches = [("TRAJ", "LINEAR_UNITS", "inch"), ("JOINT_0", "MIN_LIMIT", "-10"), ("JOINT_0", "MAX_LIMIT", "10")]
    inches += [("JOINT_1", "MIN_LIMIT", "-78.74015748"), ("JOINT_1", "MAX_LIMIT", "78.74")]
    assert _wired(*inches, image=_image((-254.0, 254.0)))
    with pytest.raises(TrueloopError, match="X may be commanded from -254 to 254 mm") as refusal:
        _wired(*inches, image=_image((-10.0, 10.0)))
    assert "in mm all limits are inside the travel" in refusal.value.hint


def test_a_limit_that_the_joint_leaves_out_is_that_of_the_axis_or_none() -> None:
    def without(*sections: str) -> str:
        text = source("machine.ini")
        for section in sections:
            head, _, rest = text.partition(f"[{section}]\n")
            text = f"{head}[{section}]\n{rest.replace('MIN_LIMIT', 'NO_LIMIT', 1)}"
        return text

    with tempfile.TemporaryDirectory() as folder:
        ini = Path(folder, "machine.ini")
        Path(folder, "machine.hal").write_text(source("machine.hal"))
        Path(folder, "extra.hal").write_text("")
        ini.write_text(without("JOINT_0"))
        assert wiring(read_configuration(ini), _image())
        ini.write_text(without("JOINT_0", "AXIS_X"))
        with pytest.raises(TrueloopError, match=r"\[JOINT_0\] has no MIN_LIMIT: commands of X have no end"):
            wiring(read_configuration(ini), _image())


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
