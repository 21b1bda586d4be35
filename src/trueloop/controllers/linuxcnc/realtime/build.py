"""The component, compiled on the machine that it shall run on: C around an object file that comes with trueloop."""

from functools import cache
from typing import Final

from trueloop import _core
from trueloop.controllers.linuxcnc.component import compiled, source
from trueloop.errors import Code

OBJECT: Final = "trueloop_rtec.o"


def sources() -> dict[str, bytes]:
    """All that is compiled, by file name."""
    return {
        "rtec.comp": source("realtime/rtec.comp").encode(),
        "rtec.h": _core.realtime_header().encode(),
        OBJECT: _core.realtime_library(),
    }


@cache
def component() -> bytes:
    """rtec.so. Raises RTC-BUILD with the compiler's words, CTL-LINUXCNC where LinuxCNC is missing."""
    return compiled("rtec", sources(), f"-Wl,--gc-sections {{folder}}/{OBJECT}", Code.RTC_BUILD)


@cache
def recorder() -> bytes:
    """recorder.so: for sessions that are judged. Raises RTC-BUILD, CTL-LINUXCNC."""
    return compiled("recorder", {"recorder.comp": source("realtime/recorder.comp").encode()}, code=Code.RTC_BUILD)
