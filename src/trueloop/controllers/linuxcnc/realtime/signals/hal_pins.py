"""The pins of `rtec-signals` in LinuxCNC's hardware layer, by the Python module that LinuxCNC brings."""

import importlib
import sys
from collections.abc import Sequence
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from types import ModuleType
from typing import Any, Final

from trueloop.controllers.linuxcnc.realtime.signals.readings import NEVER_S, Reading
from trueloop.errors import Code
from trueloop.realtime.image import SIGNALS

NAME: Final = "rtec-signals"
DEBIANS: Final = "/usr/lib/python3/dist-packages"
"""Where Debian's package has LinuxCNC's modules, out of sight of other Pythons and of virtual environments."""

HINT: Final = (
    "LinuxCNC's modules are for the system's Python: make an environment of that, "
    "`/usr/bin/python3 -m venv --system-site-packages ENV`, install in it the wheel that `make wheel` writes, "
    "and call ENV/bin/trueloop"
)


def linuxcnc_module(name: str, folder: str = DEBIANS) -> ModuleType:
    """Imports a module of LinuxCNC: this Python's own, else Debian's. Raises RTC-CONNECTION where there is none.

    Debian's folder is not searched for anything else: what else is in there belongs to the system.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        spec = PathFinder.find_spec(name, [folder])
    try:
        if spec is None or spec.loader is None:
            raise ImportError(f"no module {name!r} for it, not in {folder} either")
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
    except ImportError as error:
        version = ".".join(map(str, sys.version_info[:3]))
        raise Code.RTC_CONNECTION.refusal(
            f"Python {version} at {sys.executable!r} cannot load LinuxCNC's module {name!r}: {error}", hint=HINT
        ) from error


class Pins:
    """The component: signals and ages, the program, the heartbeat; in: the spindle's speed."""

    def __init__(self, hal: Any) -> None:
        """Raises RTC-CONNECTION where the hardware layer has no room for it, or has it already."""
        self._hal = hal
        try:
            self._component = hal.component(NAME)
            for number in range(SIGNALS):
                for pin in (f"signal-{number}", f"age-{number}"):
                    self._component.newpin(pin, hal.HAL_FLOAT, hal.HAL_OUT)
            self._component.newpin("program", hal.HAL_S32, hal.HAL_OUT)
            self._component.newpin("heartbeat", hal.HAL_U32, hal.HAL_OUT)
            self._component.newpin("spindle-speed", hal.HAL_FLOAT, hal.HAL_IN)
        except hal.error as error:
            raise Code.RTC_CONNECTION.refusal(
                f"the hardware layer does not take the component {NAME!r}: {str(error)!r}",
                hint="one of them at a time: end the other one, or start LinuxCNC anew",
            ) from error
        for number in range(SIGNALS):
            self._component[f"age-{number}"] = NEVER_S

    def ready(self) -> None:
        """Marks the component as ready, for which `loadusr -W` waits."""
        self._component.ready()

    def spindle_rpm(self) -> float | None:
        """Returns the spindle speed, rev/min, without its sign; None where nothing is linked to the pin."""
        if not self._hal.pin_has_writer(f"{NAME}.spindle-speed"):
            return None
        return abs(float(self._component["spindle-speed"])) * 60

    def give(self, readings: Sequence[Reading], program: int, now_s: float) -> None:
        """Sets the pins, signals in the order of the image."""
        for number, reading in enumerate(readings):
            self._component[f"signal-{number}"] = reading.value
            self._component[f"age-{number}"] = min(reading.age_s(now_s), NEVER_S)
        self._component["program"] = int(program)

    def beat(self, count: int) -> None:
        """Sets the heartbeat."""
        self._component["heartbeat"] = count % 2**32

    def end(self) -> None:
        """Takes the component away."""
        self._component.exit()
