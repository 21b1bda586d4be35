"""A link to a running LinuxCNC: what runs or is loaded there is not replaced, anything else is."""

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.running_lathe import LONGEST_S, RunningLathe, running_lathe
from tests.support.refusals import refused
from tests.support.tool_tables import LINUXCNC
from trueloop.controllers.links.folder import Busy, linuxcnc_busy, linuxcnc_reads
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
from trueloop.errors import Code

MAIN = ("-c", "from trueloop.cli.main import main; main()", "link")
OPERATOR = """
import sys, time
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
nc = linuxcnc_module("linuxcnc")
command, status = nc.command(), nc.stat()
def until(reached):
    end = time.monotonic() + 30
    status.poll()
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.01)
        status.poll()
command.abort()
command.wait_complete(10)
until(lambda: status.interp_state == nc.INTERP_IDLE)
command.mode(nc.MODE_AUTO)
command.wait_complete(10)
command.program_open(sys.argv[1])
until(lambda: status.file == sys.argv[1])
if "run" in sys.argv:
    command.auto(nc.AUTO_RUN, 0)
    until(lambda: status.interp_state != nc.INTERP_IDLE)
"""

TOOLS = """
from trueloop.controllers.linuxcnc.realtime.signals.component import linuxcnc_module
status = linuxcnc_module("linuxcnc").stat()
status.poll()
print(sorted((one.id, one.xoffset, one.zoffset) for one in status.tool_table if one.id > 0))
"""


class Shop:
    """The lathe, its folder of programs, and links.toml."""

    def __init__(self, lathe: RunningLathe, place: Path) -> None:
        self.lathe, self.place, self.programs = lathe, place, lathe.config / "nc"
        self.programs.mkdir()
        (place / "links.toml").write_text(
            f'[linuxcnc.lathe]\nini = "{lathe.ini}"\nfolder = "{self.programs}"\n'
            f'[linuxcnc.table]\nini = "{lathe.ini}"\nfolder = "{lathe.config}"\ntool_table = "tool.tbl"\n'
        )

    def put(self, text: str, name: str, link: str = "lathe") -> str:
        """What `link put --replace` says, in LinuxCNC's own namespaces."""
        (self.place / "new.ngc").write_text(text)
        words = ("put", str(self.place / "new.ngc"), "--name", name, "--replace", "-l", link)
        return self.beside(*MAIN, *words, "--settings", str(self.place / "links.toml"))

    def beside(self, *words: str) -> str:
        """What a Python says that shares LinuxCNC's memory and home, where it keeps its tools."""
        environment = os.environ | {"HOME": str(self.lathe.folder / "home")}
        process = self.lathe.python(*words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        said: str = process.communicate(timeout=LONGEST_S)[0]
        return said

    def operator(self, name: str, *words: str) -> None:
        """Loads a program, and with `run` starts it."""
        path = str(self.programs / name)
        assert not self.beside("-c", OPERATOR, path, *words)


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shop]:
    with running_lathe({}) as lathe:
        yield Shop(lathe, tmp_path_factory.mktemp("shop"))


def test_what_runs_or_is_loaded_is_not_replaced(shop: Shop) -> None:
    long, other = "G21\nG4 P300\nM2\n", "G21\nM2\n"
    assert "read back" in shop.put(long, "long.ngc") and "read back" in shop.put(other, "other.ngc")
    shop.operator("long.ngc")
    assert "'long.ngc' is loaded" in shop.put(other, "long.ngc")
    assert "read back" in shop.put(LINUXCNC, "tool.tbl", "table")
    assert shop.beside("-c", TOOLS) == "[(1, 0.0, 0.1), (2, 0.0, 10.0), (3, 12.5, -3.25)]\n"
    shop.operator("long.ngc", "run")
    assert "'long.ngc' runs" in shop.put(other, "long.ngc")
    assert "tool table is not written" in shop.put("T1 P1 X1\n", "tool.tbl", "table")
    assert "read back" in shop.put("G21\nG4 P1\nM2\n", "other.ngc")
    assert (shop.programs / "long.ngc").read_text() == long
    shop.operator("other.ngc")
    assert "read back" in shop.put(other, "long.ngc")
    ini = shop.place / "other.ini"
    ini.write_text(shop.lathe.ini.read_text().replace("TOOL_TABLE = tool.tbl", "TOOL_TABLE = own.tbl"))
    error = refused(
        lambda: linuxcnc_reads(ini, lambda: linuxcnc_module("linuxcnc"), "tool.tbl")(shop.place / "tool.tbl")
    )
    assert error.code is Code.CTL_LINUXCNC and "own.tbl" in error.message
    shop.lathe.killed()
    linuxcnc_reads(shop.lathe.ini, lambda: linuxcnc_module("linuxcnc"), "tool.tbl")(shop.lathe.config / "tool.tbl")
    assert linuxcnc_busy(shop.lathe.ini, lambda: linuxcnc_module("linuxcnc"))() == Busy()


def test_a_configuration_that_is_not_there_is_named(tmp_path: Path) -> None:
    error = refused(linuxcnc_busy(tmp_path / "no.ini", lambda: linuxcnc_module("linuxcnc")))
    assert error.code is Code.CTL_LINUXCNC and "no.ini" in error.message
