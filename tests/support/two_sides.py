"""A shaft that is turned at one side, turned round, and turned at the other: programs by hand, a model of its cut.

The part's frame, x a radius: front face at z = 0 (x 4 to 15), chamfer of 45° to seat 18 (z −3 to −30), a face, collar
26 (to −50), a face that looks to −z, back seat 19 (to −78), an edge of R 2, back face at z = −80 (x 17 to 11), a
chamfer of 45° into bore 10 (z −79 to −62). The first set-up's zero is the front face; in the second the part is turned
round, its zero is the back face, and its Z is −80 − z. Paths are those of the nose's centre, worked out beside each
line. Shares no code with trueloop.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from tests.support.grooved import Cutting, dense
from tests.support.linuxcnc import Move, Tool, interpret
from trueloop.arrays import Array

FIRST, SECOND, BORE = 1, 2, 4
"""Tools: the first side's, the second side's, and the boring bar of the second side."""
NOSE_MM: Final = {FIRST: 0.8, SECOND: 0.8, BORE: 0.4}
SETUP_OF: Final = {FIRST: "first", SECOND: "second", BORE: "second"}

PROFILE: Final = """side = "around"  # out of the bore, over the back face, along the outside: material on the right
start = [10.0, -62.0]  # x is a radius

[[part.feature]]
name = "bore"
to = [10.0, -79.0]

[[part.feature]]
name = "bore-chamfer"
to = [11.0, -80.0]

[[part.feature]]
name = "back"
to = [17.0, -80.0]

[[part.feature]]
name = "edge"
to = [19.0, -78.0]
radius = 2.0

[[part.feature]]
name = "back-seat"
to = [19.0, -50.0]

[[part.feature]]
name = "back-step"
to = [26.0, -50.0]

[[part.feature]]
name = "collar"
to = [26.0, -30.0]

[[part.feature]]
name = "step"
to = [18.0, -30.0]

[[part.feature]]
name = "seat"
to = [18.0, -3.0]

[[part.feature]]
name = "chamfer"
to = [15.0, 0.0]

[[part.feature]]
name = "front"
to = [4.0, 0.0]
"""

Control = Literal["fanuc-lathe", "linuxcnc"]
CALLS: Final[Mapping[Control, str]] = {"fanuc-lathe": "T{0:02}{0:02}", "linuxcnc": "T{0} M6 G43 H{0}"}
HEAD: Final[Mapping[Control, str]] = {
    "fanuc-lathe": "%\nO{0:04} (SHAFT, SIDE {0})\nG21 G18 G40 G99\nG97 S800 M03",
    "linuxcnc": "G21 G18 G7 G40 G90 G95\nG97 S800 M3",
}
END: Final[Mapping[Control, str]] = {"fanuc-lathe": "M30\n%\n", "linuxcnc": "M2\n"}
ENDING: Final[Mapping[Control, str]] = {"fanuc-lathe": "nc", "linuxcnc": "ngc"}
R2: Final = 2.0**0.5


def _to(word: str, x_mm: float, z_mm: float) -> str:
    return f"{word} X{2 * x_mm:.4f} Z{z_mm:.4f}"


def first(control: Control = "fanuc-lathe", tool: int = FIRST) -> str:
    """The program of the first side."""
    r = NOSE_MM[FIRST]
    lines = [
        HEAD[control].format(1),
        CALLS[control].format(tool),
        _to("G00", 3.0, 4.0),
        _to("G01", 3.0, r) + " F0.1",
        _to("G01", 15.0 + r * (R2 - 1.0), r),  # the chamfer's centre line is x + z = 15 + r √2
        _to("G01", 18.0 + r, -3.0 + r * (R2 - 1.0)),
        _to("G01", 18.0 + r, -30.0 + r),
        _to("G01", 26.0 + r, -30.0 + r),
        _to("G01", 26.0 + r, -50.5),
        "G00 X80. Z20.",
        END[control],
    ]
    return "\n".join(lines)


def second(control: Control = "fanuc-lathe", tool: int = SECOND, sign: float = 1.0) -> str:
    """The program of the second side, in its own frame; `sign` −1: as if its Z were the other way round."""
    r, b, s = NOSE_MM[SECOND], NOSE_MM[BORE], sign
    arc = "G03" if sign > 0 else "G02"
    lines = [
        HEAD[control].format(2),
        CALLS[control].format(tool),
        _to("G00", 9.0, 4.0 * s),
        _to("G01", 9.0, r * s) + " F0.1",
        _to("G01", 17.0, r * s),
        _to(arc, 19.0 + r, -2.0 * s) + f" I0. K{-(2.0 + r) * s:.4f}",  # about (17, −2), from +Z to +X
        _to("G01", 19.0 + r, (-30.0 + r) * s),
        _to("G01", 27.0, (-30.0 + r) * s),
        f"G00 X80. Z{20 * s:.0f}.",
        CALLS[control].format(BORE),
        _to("G00", 13.0 - b * R2, 2.0 * s),  # the chamfer's centre line is x − Z = 11 − r √2
        _to("G01", 10.0 - b, (-1.0 + b * (R2 - 1.0)) * s) + " F0.08",
        _to("G01", 10.0 - b, -18.0 * s),
        _to("G00", 9.0, -18.0 * s),
        f"G00 Z{20 * s:.0f}.",
        "G00 X80.",
        END[control],
    ]
    return "\n".join(lines)


@dataclass(frozen=True)
class Place:
    """Where the part is touched, in the part's frame: x a radius, z, the normal (x, z), and the tool that cuts it."""

    feature: str
    x_mm: float
    z_mm: float
    normal: tuple[float, float]
    tool: int

    def on_machine(self, turned_round: bool) -> tuple[tuple[float, float], tuple[float, float]]:
        """The place and its normal as the machine has them: (x, Z), (n_x, n_Z).

        The second side's zero is the back face. Turned round, Z is −80 − z; taken over as it is, Z is z + 80.
        """
        (x, z), (n_x, n_z) = (self.x_mm, self.z_mm), self.normal
        if self.tool == FIRST:
            return (x, z), (n_x, n_z)
        return ((x, -80.0 - z), (n_x, -n_z)) if turned_round else ((x, z + 80.0), (n_x, n_z))


OUT, IN, FRONT, BACK = (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)
H: Final = 0.5**0.5
_EDGE_RAD: Final = np.radians([15.0, 30.0, 45.0, 60.0, 75.0])
PLACES: Final = (
    *(Place("bore", 10.0, z, IN, BORE) for z in (-64.0, -70.0, -76.0)),
    *(Place("bore-chamfer", 10.0 + t, -79.0 - t, (-H, -H), BORE) for t in (0.3, 0.5, 0.7)),
    *(Place("back", x, -80.0, BACK, SECOND) for x in (12.5, 14.0, 15.5)),
    *(
        Place("edge", 17.0 + 2.0 * np.sin(a), -78.0 - 2.0 * np.cos(a), (float(np.sin(a)), float(-np.cos(a))), SECOND)
        for a in _EDGE_RAD
    ),
    *(Place("back-seat", 19.0, z, OUT, SECOND) for z in (-74.0, -66.0, -58.0, -52.0)),
    *(Place("back-step", x, -50.0, BACK, SECOND) for x in (20.5, 22.5, 24.5)),
    *(Place("collar", 26.0, z, OUT, FIRST) for z in (-46.0, -40.0, -34.0)),
    *(Place("step", x, -30.0, FRONT, FIRST) for x in (24.5, 22.0, 19.5)),
    *(Place("seat", 18.0, z, OUT, FIRST) for z in (-26.0, -18.0, -12.0, -6.0)),
    *(Place("chamfer", 15.0 + t, -t, (H, H), FIRST) for t in (2.4, 1.5, 0.6)),
    *(Place("front", x, 0.0, FRONT, FIRST) for x in (13.0, 10.0, 7.0)),
)


def surface_mm(
    centres_mm: Array, nose_radius_mm: float, cutting: Cutting, place: Place, turned_round: bool = True
) -> float:
    """How far the surface stands off the nominal along the normal, where a nose has run along centres on its machine.

    A ray from the place along the normal enters the circle about c at t = n·(c − p) − √(R² − q²), q the distance of c
    from the ray; the material ends at the smallest of these. A worn nose leaves w more, by the normal on the machine.
    """
    point, normal = place.on_machine(turned_round)
    apart = centres_mm + np.array(cutting.off_mm) - np.array(point)
    along = apart @ np.array(normal)
    across2 = np.sum(apart**2, axis=1) - along**2
    reached = across2 < nose_radius_mm**2
    entered = along[reached] - np.sqrt(nose_radius_mm**2 - across2[reached])
    return float(np.min(entered)) + cutting.wear(normal)


def centres_mm(programs: Mapping[str, Path], tools: Mapping[str, Sequence[int]]) -> Mapping[int, Array]:
    """Where LinuxCNC sends the nose centre of each tool, at feed, densely; `tools` in the order of their calls."""
    found: dict[int, list[Array]] = {}
    for setup, file in programs.items():
        calls = [n for n, line in enumerate(file.read_text().splitlines(), 1) if " M6 " in line]
        for move in interpret(file, tools=[Tool(tool, NOSE_MM[tool]) for tool in NOSE_MM]):
            if move.kind in ("line", "arc"):
                tool = tools[setup][sum(line < move.line for line in calls) - 1]
                found.setdefault(tool, []).append(along(move))
    return {tool: np.concatenate(pieces) for tool, pieces in found.items()}


def along(move: Move) -> Array:
    """Points of a move, (n, 2) as (x, Z)."""
    start, end = np.array(move.start_mm)[[0, 2]], np.array(move.end_mm)[[0, 2]]
    sweep_rad = move.sweep_rad
    if move.centre_mm is None or sweep_rad is None:
        return dense([(float(start[0]), float(start[1])), (float(end[0]), float(end[1]))])
    middle = np.array(move.centre_mm)[[0, 2]]
    radius_mm = float(np.linalg.norm(start - middle))
    angle = np.arctan2(start[0] - middle[0], start[1] - middle[1])
    turned = angle - np.linspace(0.0, sweep_rad, max(int(radius_mm * abs(sweep_rad) / 0.001), 2))
    return np.asarray(middle + radius_mm * np.column_stack([np.sin(turned), np.cos(turned)]))


TOOLS: Final = {"first": (FIRST,), "second": (SECOND, BORE)}


def measured_um(programs: Mapping[str, Path], cuttings: Mapping[int, Cutting], *, turned_round: bool = True) -> Array:
    """Errors at all places of a part that these programs cut, by set-up, µm along the part's normals."""
    paths = centres_mm(programs, TOOLS)
    found = [surface_mm(paths[p.tool], NOSE_MM[p.tool], cuttings[p.tool], p, turned_round) for p in PLACES]
    return 1e3 * np.array(found)


def standing_um(errors_um: Array, stop_mm: float = 0.0) -> Array:
    """Errors of the same part where it stood on its front in the second set-up, at a stop that is off by `stop_mm`
    along z of the part.

    A front that is proud by e lies at z = e, where the program takes z = 0 to be: all that is cut there lies higher by
    e, and by what the stop is off. Along a normal that is n_z times as much.
    """
    front_um = np.mean([e for e, p in zip(errors_um, PLACES, strict=True) if p.feature == "front"])
    higher_um = [0.0 if p.tool == FIRST else p.normal[1] * (front_um + 1e3 * stop_mm) for p in PLACES]
    return np.asarray(errors_um + np.array(higher_um))


def tools_toml(tools: Mapping[int, int]) -> str:
    """Tables [[setups.tools]]: by the number that the program calls, whose nose it has."""
    return "".join(f"[[setups.tools]]\nnumber = {n}\nnose_radius_mm = {NOSE_MM[of]}\n" for n, of in tools.items())


def setup_toml(name: str, frame: str, control: Control, tools: str, programs: str = "") -> str:
    """A table [[setups]]."""
    return (
        f'[[setups]]\nname = "{name}"\n{frame}\n[setups.programs]\ndialect = "{control}"\n'
        f'finish = "{name}.{ENDING[control]}"\n{programs}{tools}'
    )


FRAMES: Final = {"first": "zero_at_z_mm = 0.0", "second": "zero_at_z_mm = -80.0\nflipped = true"}


def job(
    folder: Path,
    errors_um: Sequence[float],
    more: str = "",
    control: Control = "linuxcnc",
    frames: Mapping[str, str] = FRAMES,
    part: str = "",
) -> Path:
    """A job in a folder, with these touches; programs that are not there yet are written."""
    for name, text in (("first", first(control)), ("second", second(control))):
        file = folder / f"{name}.{ENDING[control]}"
        if not file.exists():
            file.write_text(text)
    rows = [
        f"{k},{p.feature},{p.x_mm:.6f},{p.z_mm:.6f},{e:.6f}"
        for k, (p, e) in enumerate(zip(PLACES, errors_um, strict=True), 1)
    ]
    (folder / "touches.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    tools = {"first": {FIRST: FIRST}, "second": {SECOND: SECOND, BORE: BORE}}
    setups = [setup_toml(name, frames[name], control, tools_toml(tools[name])) for name in ("first", "second")]
    (folder / "job.toml").write_text(
        f'[part]\nname = "two sides"\n{PROFILE}{part}\n{"".join(setups)}[gauging]\ntouches = "touches.csv"\n{more}'
    )
    return folder / "job.toml"
