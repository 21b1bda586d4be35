"""LinuxCNC's own interpreter as an independent judge of NC programs.

`interpret(program)` runs the interpreter of Debian's `linuxcnc-uspace` in a process of its own and gives the moves it
would command, in full double precision. It shares no code with trueloop.
"""

import json
import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any, Literal

DEBIAN_PYTHON = Path("/usr/bin/python3")
INTERPRETER = Path(__file__).with_name("linuxcnc_interpreter.py")
INSTALL = "apt-get install -y --no-install-recommends linuxcnc-uspace"
LATHE_STARTUP = "G18 G21 G8 G40 G90 G94"

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Move:
    """One commanded move of the controlled point, in the program's coordinates: (x, y, z) in mm, x always a radius.

    `line` counts the program file's lines from 1. An arc has its centre (in its plane; along the third axis that of the
    start) and the signed angle of travel: positive for G02, which is clockwise with z to the right and x up in G18.
    The first move starts at the machine's origin. G92 and G54–G59 change the coordinates, not where the tool stands:
    `origin_mm` is what they add to them.
    """

    kind: Literal["rapid", "line", "arc", "probe"]
    line: int
    start_mm: Vector
    end_mm: Vector
    centre_mm: Vector | None = None
    sweep_rad: float | None = None
    origin_mm: Vector = (0.0, 0.0, 0.0)

    @property
    def machine_mm(self) -> Vector:
        """Where the move ends in machine coordinates, tool offsets left out."""
        x, y, z = (end + origin for end, origin in zip(self.end_mm, self.origin_mm, strict=True))
        return x, y, z


@dataclass(frozen=True)
class Tool:
    """A row of the tool table: offsets in mm, x as a radius; orientation is the lathe's 0–9."""

    number: int
    nose_radius_mm: float = 0.0
    orientation: int = 0
    x_offset_mm: float = 0.0
    z_offset_mm: float = 0.0


class ProgramRefusedError(Exception):
    """The interpreter refused the program: its own message, and the line it was reading, from 1."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(f"line {line}: {message}")
        self.message = message
        self.line = line


class LinuxcncMissingError(Exception):
    """The Debian package is not installed: the tests that need the judge fail and say how to get it."""


def interpret(
    program: Path,
    parameters: Mapping[int | str, float] | None = None,
    tools: Sequence[Tool] = (),
    *,
    startup: str = LATHE_STARTUP,
    block_delete: bool = False,
) -> list[Move]:
    """The moves LinuxCNC commands for a program.

    `parameters` are set before the program runs: `{31: 2.5}` for `#31`, `{"_depth": 2.5}` for the global `#<_depth>`.
    `startup` is the block of modal codes a machine's configuration runs first (RS274NGC_STARTUP_CODE).
    Raises `ProgramRefusedError` where LinuxCNC refuses the program.
    """
    require_linuxcnc()
    request = {
        "program": str(program.resolve(strict=True)),
        "tool_table": "".join(f"T{tool.number} P{place}\n" for place, tool in enumerate(tools, 1)),
        "pockets": [_pocket(tool) for tool in tools],
        "startup": [startup, *(_assignment(name, value) for name, value in (parameters or {}).items())],
        "block_delete": block_delete,
    }
    answer = _run(request)
    if answer["error"] is not None:
        raise ProgramRefusedError(answer["error"], answer["line"])
    return [_move(values) for values in answer["moves"]]


def require_linuxcnc() -> None:
    """Fail with the line to run when the interpreter is not there."""
    if not _has_interpreter(DEBIAN_PYTHON):
        raise LinuxcncMissingError(f"LinuxCNC's interpreter is not installed; run as root:  {INSTALL}")


@cache
def _has_interpreter(python: Path) -> bool:
    command = [str(python), "-c", "import gcode"]
    return python.exists() and subprocess.run(command, capture_output=True, check=False).returncode == 0


def _run(request: Mapping[str, object]) -> dict[str, Any]:
    """A process and a HOME of its own: LinuxCNC's tool table is shared per HOME, and a crash must not end the tests."""
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder, "request.json"), Path(folder, "answer.json")
        asked.write_text(json.dumps(request))
        done = subprocess.run(
            [DEBIAN_PYTHON, INTERPRETER, asked, answered],
            cwd=folder,
            env={"HOME": folder, "PATH": os.defpath},
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            raise RuntimeError(f"LinuxCNC's interpreter ended with status {done.returncode}: {done.stderr.strip()}")
        answer: dict[str, Any] = json.loads(answered.read_text())
        return answer


def _pocket(tool: Tool) -> list[float]:
    """(number, offsets x y z a b c u v w, diameter, front angle, back angle, orientation)."""
    offsets = [tool.x_offset_mm, 0.0, tool.z_offset_mm, *[0.0] * 6]
    return [tool.number, *offsets, 2 * tool.nose_radius_mm, 0.0, 0.0, tool.orientation]


def _assignment(name: int | str, value: float) -> str:
    target = f"#{name}" if isinstance(name, int) else f"#<{name}>"
    return f"{target}={Decimal(repr(value)):f}"  # the interpreter reads no exponents


def _move(values: dict[str, Any]) -> Move:
    vectors = {name: tuple(value) for name, value in values.items() if isinstance(value, list)}
    return Move(**(values | vectors))
