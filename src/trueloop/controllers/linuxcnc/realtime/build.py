"""The component, compiled on the machine that it shall run on."""

import re
from functools import cache
from typing import Final

from trueloop import _core
from trueloop.controllers.linuxcnc.component import compiled, source
from trueloop.errors import Code

LIBRARY: Final = "librtec.a"


@cache
def component() -> bytes:
    """rtec.so: the C of `rtec.comp` and the static library behind `rtec.h`. Raises RTC-BUILD, CTL-LINUXCNC.

    The linker reads libraries before it knows what is asked of them: it is told by name.
    """
    header = _core.realtime_header()
    asked = " ".join(f"-Wl,-u,{name}" for name in functions(header))
    return compiled(
        "rtec",
        {
            "rtec.comp": source("realtime/rtec.comp").encode(),
            "rtec.h": header.encode(),
            LIBRARY: _core.realtime_library(),
        },
        f"-Wl,--gc-sections {asked} {{folder}}/{LIBRARY}",
        Code.RTC_BUILD,
    )


@cache
def recorder() -> bytes:
    """recorder.so: for sessions that are judged. Raises RTC-BUILD, CTL-LINUXCNC."""
    return compiled("recorder", {"recorder.comp": source("realtime/recorder.comp").encode()}, code=Code.RTC_BUILD)


def functions(header: str) -> tuple[str, ...]:
    """The functions that a header declares."""
    return tuple(re.findall(r"^\w[\w ]*[ *](rtec_\w+)\(", header, re.MULTILINE))
