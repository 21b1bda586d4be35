"""Runs inside Debian's own Python: LinuxCNC's interpreter turns one program into moves, written as JSON.

Called by `linuxcnc.py` as `linuxcnc_interpreter.py REQUEST.json ANSWER.json` in a folder of its own that is also HOME,
where LinuxCNC keeps its shared tool table. The `gcode` module gives inches whatever the program's unit;
they leave as mm.
"""

import ctypes
import json
import math
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gcode

MM_PER_INCH = 25.4
FULL_TURN_BELOW_RAD = 1e-6  # LinuxCNC's own bound: an arc that turns less than this is a full turn
PLANE_AXES = {1: (0, 1), 2: (1, 2), 3: (2, 0)}  # G17 (x, y), G19 (y, z), G18 (z, x): G03 turns the first to the second
EMPTY_POCKET = (-1, *[0.0] * 12, 0)

Vector = tuple[float, ...]


class Canon:
    """What the interpreter calls. A call that is not here is one the judge does not understand, and ends the run."""

    def __init__(self, tools: Sequence[tuple[float, ...]], parameter_file: str, block_delete: bool) -> None:
        self.tools = [EMPTY_POCKET, *tools]
        self.parameter_file = parameter_file
        self.block_delete = block_delete
        self.line = 0
        self.axes = PLANE_AXES[1]
        self.position_mm: Vector = (0.0, 0.0, 0.0)
        self.offset_mm: dict[str, Vector] = {"g5x": (0.0, 0.0, 0.0), "g92": (0.0, 0.0, 0.0), "tool": (0.0, 0.0, 0.0)}
        self.turned_degrees = 0.0
        self.moves: list[dict[str, Any]] = []

    def next_line(self, state: Any) -> None:
        self.line = state.sequence_number

    def straight_traverse(self, *words: float) -> None:
        self._move("rapid", to_mm(words[:3]))

    def straight_feed(self, *words: float) -> None:
        self._move("line", to_mm(words[:3]))

    def straight_probe(self, *words: float) -> None:
        """Ends at its programmed point here: no part is met."""
        self._move("probe", to_mm(words[:3]))

    def arc_feed(
        self, first: float, second: float, first_centre: float, second_centre: float, turns: int, *words: float
    ) -> None:
        end, centre = list(self.position_mm), list(self.position_mm)
        i, j = self.axes
        end[i], end[j], end[3 - i - j] = to_mm((first, second, words[0]))
        centre[i], centre[j] = to_mm((first_centre, second_centre))
        sweep = sweep_rad(self.position_mm, end, centre, self.axes, turns)
        self._move("arc", tuple(end), centre_mm=tuple(centre), sweep_rad=sweep)

    def _move(self, kind: str, end_mm: Vector, **arc: object) -> None:
        origin_mm = tuple(map(sum, zip(*self.offset_mm.values(), strict=True)))
        told = {"kind": kind, "line": self.line, "start_mm": self.position_mm, "end_mm": end_mm, "origin_mm": origin_mm}
        self.moves.append(told | arc)
        self.position_mm = end_mm

    def set_g5x_offset(self, _system: int, *words: float) -> None:
        self._shift_origin("g5x", to_mm(words[:3]))

    def set_g92_offset(self, *words: float) -> None:
        self._shift_origin("g92", to_mm(words[:3]))

    def tool_offset(self, *words: float) -> None:
        self._shift_origin("tool", to_mm(words[:3]))

    def _shift_origin(self, name: str, offset_mm: Vector) -> None:
        """The tool stands still while the coordinates it is told in change."""
        machine = self._machine_mm(self.position_mm)
        self.offset_mm[name] = offset_mm
        self.position_mm = self._program_mm(machine)

    def set_xy_rotation(self, degrees: float) -> None:
        """machine = g5x + tool + turned(program + g92)."""
        machine = self._machine_mm(self.position_mm)
        self.turned_degrees = degrees
        self.position_mm = self._program_mm(machine)

    def _machine_mm(self, program_mm: Vector) -> Vector:
        x, y, z = turned([p + o for p, o in zip(program_mm, self.offset_mm["g92"], strict=True)], self.turned_degrees)
        g5x, tool = self.offset_mm["g5x"], self.offset_mm["tool"]
        return tuple(p + o + t for p, o, t in zip((x, y, z), g5x, tool, strict=True))

    def _program_mm(self, machine_mm: Vector) -> Vector:
        g5x, g92, tool = (self.offset_mm[name] for name in ("g5x", "g92", "tool"))
        flat = [m - o - t for m, o, t in zip(machine_mm, g5x, tool, strict=True)]
        return tuple(p - o for p, o in zip(turned(flat, -self.turned_degrees), g92, strict=True))

    def set_plane(self, plane: int) -> None:
        self.axes = PLANE_AXES[plane]

    def change_tool(self, pocket: int) -> None:
        # Nose compensation reads pocket 0: without the copy the radius is 0 and nobody says so.
        self.tools[0] = self.get_tool(pocket)

    def get_tool(self, pocket: int) -> tuple[float, ...]:
        return self.tools[pocket] if pocket < len(self.tools) else EMPTY_POCKET

    def get_block_delete(self) -> bool:
        return self.block_delete

    def get_external_length_units(self) -> float:
        return 1.0  # the machine's unit: mm

    def get_external_angular_units(self) -> float:
        return 1.0

    def get_axis_mask(self) -> int:
        return 0b111

    def ignored(self, *_: object) -> None:
        """Nothing of these shows in the path."""

    check_abort = comment = dwell = message = user_defined_function = ignored
    set_feed_rate = set_spindle_rate = set_traverse_rate = ignored


def turned(position: Sequence[float], degrees: float) -> Vector:
    """Turns X and Y anticlockwise about the origin."""
    if not degrees:
        return tuple(position)
    (x, y, z), cosine, sine = position, math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (cosine * x - sine * y, sine * x + cosine * y, z)


def to_mm(inches: Sequence[float]) -> Vector:
    return tuple(MM_PER_INCH * value for value in inches)


def sweep_rad(start: Vector, end: Sequence[float], centre: Sequence[float], axes: tuple[int, int], turns: int) -> float:
    """Signed angle of travel, positive for G02; `turns` counts turns begun, positive anticlockwise."""
    i, j = axes
    start_angle = math.atan2(start[j] - centre[j], start[i] - centre[i])
    end_angle = math.atan2(end[j] - centre[j], end[i] - centre[i])
    turned = math.copysign(1, turns) * (end_angle - start_angle) % math.tau
    if turned < FULL_TURN_BELOW_RAD:
        turned += math.tau
    return math.copysign(turned + math.tau * (abs(turns) - 1), -turns)


def publish_tools(tool_table: str) -> None:
    """Only rs274 makes the memory map in which `gcode` looks tools up; without it a tool change crashes."""
    Path("tool.tbl").write_text(tool_table)
    Path("empty.ngc").write_text("M2\n")
    subprocess.run(["rs274", "-g", "-t", "tool.tbl", "empty.ngc"], check=True, capture_output=True)
    ctypes.CDLL("libtooldata.so.0")._Z14tool_mmap_userv()


def main(request_file: str, answer_file: str) -> None:
    request = json.loads(Path(request_file).read_text())
    publish_tools(request["tool_table"])
    parameters = Path("parameters.var").resolve()
    parameters.touch()
    canon = Canon([tuple(tool) for tool in request["pockets"]], str(parameters), request["block_delete"])
    status, line = gcode.parse(request["program"], canon, request["startup"])
    error = gcode.strerror(status) if status > gcode.MIN_ERROR else None
    Path(answer_file).write_text(json.dumps({"moves": canon.moves, "error": error, "line": line}))


if __name__ == "__main__":
    main(*sys.argv[1:])
