"""The files of the virtual lathe, and its components, built for LinuxCNC's hardware layer."""

from functools import cache
from importlib import resources

from trueloop.controllers.linuxcnc.realtime.install import compiled
from trueloop.errors import Code


def source(name: str) -> str:
    """Returns the text of a file that comes with this package."""
    return (resources.files("trueloop_lab.linuxcnc") / name).read_text()


@cache
def virtual_part() -> bytes:
    """Compiles the virtual part to a shared object, once a run. Raises CTL-LINUXCNC with the compiler's words."""
    return compiled("virtual_part", {"virtual_part.comp": source("virtual_part.comp").encode()})


@cache
def recorder() -> bytes:
    """Compiles recorder.so, for sessions that are judged. Raises RTC-BUILD, CTL-LINUXCNC."""
    return compiled("recorder", {"recorder.comp": source("realtime/recorder.comp").encode()}, code=Code.RTC_BUILD)
