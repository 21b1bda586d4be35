"""A shaft whose second side is cut with nose compensation and with both corners of a groove insert.

The part's frame, x a radius: that of `two_sides`, with a groove of 6 mm in the back seat, z −68 to −62, down to 16.
The second side is cut in one of three set-ups, whose program has its zero at the back face:

- `flipped`: the part is turned round, Z = −80 − z, the chuck is at lower Z;
- `mirrored`: a sub-spindle has taken it over and the control mirrors Z, Z = −80 − z;
- `taken`: a sub-spindle has taken it over and its program keeps the main spindle's Z, Z = z + 80: the chuck is at
  higher Z, and all of the program is the other way round.

Contours under G41 and G42 are the drawing's own coordinates; where the nose's centre then runs is LinuxCNC's to say.
Shares no code with trueloop.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from tests.support.grooved import Cutting
from tests.support.linuxcnc import Move, Tool, interpret
from tests.support.two_sides import BACK, FIRST, FRONT, OUT, Place, along, first, setup_toml, surface_mm
from tests.support.two_sides import PLACES as UNGROOVED
from tests.support.two_sides import PROFILE as UNGROOVED_PROFILE
from trueloop.arrays import Array

Frame = Literal["flipped", "mirrored", "taken"]
Groove = Literal["centre", "compensated"]
"""Whether the groove is programmed as the path of the nose's centre, or under G41 and G42 too."""

OD, BORE, LEFT, RIGHT = 2, 4, 5, 15
"""Tools of the second side; the two corners of the groove insert are those at lower and at higher Z of its program."""
NOSE_MM: Final = {FIRST: 0.8, OD: 0.8, BORE: 0.4, LEFT: 0.2, RIGHT: 0.2}
WIDTH_MM: Final = 3.0
TIP: Final[Mapping[int, tuple[float, float]]] = {
    FIRST: (0.0, 0.0), OD: (-1.0, -1.0), BORE: (1.0, -1.0), LEFT: (0.0, 0.0), RIGHT: (0.0, 0.0),
}  # fmt: skip
"""Where the controlled point lies from the nose's centre, in nose radii, (x, Z) where the tool comes from Z+: T2 is set
by where it touches a diameter and a face, the bar by a bore and a face, the groove insert by its corners' centres."""
ORIENTATION: Final = {(0.0, 0.0): 0, (-1.0, -1.0): 2, (1.0, -1.0): 3, (-1.0, 1.0): 1, (1.0, 1.0): 4}
"""LinuxCNC's numbers of these tips; that a good part comes out good shows that they are."""

STATES: Final[Mapping[Frame, str]] = {
    "flipped": "zero_at_z_mm = -80.0\nflipped = true",
    "mirrored": "zero_at_z_mm = -80.0\nmirrored_z = true",
    "taken": "zero_at_z_mm = -80.0",
}

_BACK_SEAT = '[[part.feature]]\nname = "back-seat"\nto = [19.0, -50.0]\n'
_GROOVE: Final = (("back-seat", 19, -68), ("back-wall", 16, -68), ("back-floor", 16, -65), ("floor", 16, -62),
                  ("wall", 19, -62), ("shoulder", 19, -50))  # fmt: skip
PROFILE: Final = UNGROOVED_PROFILE.replace(
    _BACK_SEAT, "".join(f'[[part.feature]]\nname = "{name}"\nto = [{x}, {z}]\n' for name, x, z in _GROOVE)
)
_SEAT_OFF: Final = [p for p in UNGROOVED if p.feature != "back-seat"]
_BEFORE: Final = next(k for k, p in enumerate(_SEAT_OFF) if p.feature == "back-step")
PLACES: Final = (
    *_SEAT_OFF[:_BEFORE],
    *(Place("back-seat", 19.0, z, OUT, OD) for z in (-76.5, -73.0, -69.5)),
    *(Place("back-wall", x, -68.0, FRONT, -1) for x in (18.4, 17.5, 16.6)),
    *(Place("back-floor", 16.0, z, OUT, -1) for z in (-67.2, -66.4, -65.6)),
    *(Place("floor", 16.0, z, OUT, -2) for z in (-64.4, -63.6, -62.8)),
    *(Place("wall", x, -62.0, BACK, -2) for x in (16.6, 17.5, 18.4)),
    *(Place("shoulder", 19.0, z, OUT, OD) for z in (-60.5, -56.0, -51.5)),
    *_SEAT_OFF[_BEFORE:],
)
"""Edge −1 is that which cuts the half of the groove at the back face, −2 the other: which corner that is depends on
which way Z points."""


def places(frame: Frame) -> list[Place]:
    """All places with the edges that cut them: the wall at z −68 looks to z+ of the part, which is Z− of a program
    whose Z is turned; a corner at lower Z cuts walls that look to Z+.
    """
    corner = {-1: LEFT, -2: RIGHT} if frame == "taken" else {-1: RIGHT, -2: LEFT}
    return [Place(p.feature, p.x_mm, p.z_mm, p.normal, corner.get(p.tool, p.tool)) for p in PLACES]


@dataclass(frozen=True)
class Words:
    """How a contour is written that comes from Z+ (`sign` 1), or the other way round."""

    sign: float

    def to(self, word: str, x_mm: float, z_mm: float) -> str:
        """A block that ends there."""
        return f"{word} X{2 * x_mm:.4f} Z{z_mm * self.sign:.4f}"

    def turned(self, code: str) -> str:
        """G02 and G03, G41 and G42, which a mirror exchanges."""
        other = {"G02": "G03", "G03": "G02", "G41": "G42", "G42": "G41"}
        return code if self.sign > 0 else other[code]


def second(frame: Frame, groove: Groove = "centre") -> str:
    """The second side's program for LinuxCNC."""
    w = Words(-1.0 if frame == "taken" else 1.0)
    near, far = (LEFT, RIGHT) if w.sign > 0 else (RIGHT, LEFT)
    lines = [
        "G21 G18 G7 G40 G90 G95\nG97 S800 M3",
        f"T{OD} M6 G43 H{OD}",
        w.to("G0", 3.0, 4.0),
        w.to(f"{w.turned('G42')} G0", 8.0, 0.0),
        w.to("G1", 17.0, 0.0) + " F0.1",
        w.to(w.turned("G03").replace("G0", "G"), 19.0, -2.0) + f" I0. K{-2.0 * w.sign:.4f}",
        w.to("G1", 19.0, -30.0),
        w.to("G1", 27.0, -30.0),
        w.to("G40 G0", 40.0, 20.0),
        f"T{BORE} M6 G43 H{BORE}",
        w.to("G0", 9.0, 4.0),
        w.to(f"{w.turned('G41')} G0", 12.0, 1.0),
        w.to("G1", 10.0, -1.0) + " F0.08",
        w.to("G1", 10.0, -18.0),
        w.to("G40 G0", 8.0, -18.0),
        w.to("G0", 8.0, 20.0),
        w.to("G0", 40.0, 20.0),
        f"T{LEFT} M6 G43 H{near}",
        *_plunge(w, groove, "G41", near, -18.0, 1.0),
        f"G43 H{far}",
        *_plunge(w, groove, "G42", far, -12.0, -1.0),
        w.to("G0", 40.0, 20.0),
        "M2\n",
    ]
    return "\n".join(lines)


def _plunge(w: Words, groove: Groove, code: str, tool: int, wall_z_mm: float, inwards: float) -> list[str]:
    """Down a wall and along half the floor, then out: `inwards` is +1 where the groove lies at higher Z of the wall."""
    r = NOSE_MM[tool] if groove == "centre" else 0.0
    on, off = ("", "") if r else (f"{w.turned(code)} D{tool} ", "G40 ")
    wall_z_mm += r * inwards
    return [
        *([] if r else [w.to("G0", 24.0, wall_z_mm + inwards)]),
        w.to(f"{on}G0", 20.5, wall_z_mm),
        w.to("G1", 16.0 + r, wall_z_mm) + " F0.05",
        w.to("G1", 16.0 + r, -15.0),
        w.to(f"{off}G0", 30.0, -15.0),
    ]


def table(frame: Frame) -> list[Tool]:
    """The tool table: the corner at higher Z lies the insert's width behind the other."""
    sign = -1.0 if frame == "taken" else 1.0
    offsets = {RIGHT: WIDTH_MM}
    return [
        Tool(n, r, ORIENTATION[TIP[n][0], TIP[n][1] * (sign if n != FIRST else 1.0)], z_offset_mm=offsets.get(n, 0.0))
        for n, r in NOSE_MM.items()
    ]


def centres_mm(frame: Frame, programs: Mapping[str, Path]) -> Mapping[int, Array]:
    """Where LinuxCNC sends each nose's centre at feed, densely, on the machine: what a mirrored Z of it means there."""
    found: dict[int, list[Array]] = {}
    for setup, file in programs.items():
        sign = -1.0 if setup == "second" and frame == "taken" else 1.0
        for tool, moves in _by_call(file, interpret(file, tools=table(frame))).items():
            tip = NOSE_MM[tool] * np.array(TIP[tool]) * [1.0, sign]
            path = np.concatenate([along(move) for move in moves]) - tip
            found.setdefault(tool, []).append(path * [1.0, -1.0] if setup == "second" and frame == "mirrored" else path)
    return {tool: np.concatenate(pieces) for tool, pieces in found.items()}


def _by_call(file: Path, moves: Sequence[Move]) -> dict[int, list[Move]]:
    """The feed moves by the offset that was called last, H."""
    calls = {n: int(line.split(" H")[1]) for n, line in enumerate(file.read_text().splitlines(), 1) if " H" in line}
    found: dict[int, list[Move]] = {}
    for move in moves:
        if move.kind in ("line", "arc"):
            found.setdefault(calls[max(line for line in calls if line < move.line)], []).append(move)
    return found


def measured_um(frame: Frame, programs: Mapping[str, Path], cuttings: Mapping[int, Cutting]) -> Array:
    """Errors at all places of the part that these programs cut, µm along the part's normals.

    A part that a sub-spindle took over stands in the machine as drawn, whatever its control makes of Z.
    """
    paths, turned_round = centres_mm(frame, programs), frame == "flipped"
    found = [surface_mm(paths[p.tool], NOSE_MM[p.tool], cuttings[p.tool], p, turned_round) for p in places(frame)]
    return 1e3 * np.array(found)


def given(folder: Path, frame: Frame, groove: Groove = "centre") -> Mapping[str, Path]:
    """Both programs, written."""
    (folder / "first.ngc").write_text(first("linuxcnc"))
    (folder / "second.ngc").write_text(second(frame, groove))
    return {name: folder / f"{name}.ngc" for name in ("first", "second")}


def tools_toml(frame: Frame, exchanged: bool = False) -> str:
    """Tables of the second side's tools; `exchanged`: with the groove's corners called by each other's names."""
    corner = {LEFT: "right", RIGHT: "left"} if exchanged else {LEFT: "left", RIGHT: "right"}
    return "".join(
        f"[[setups.tools]]\nnumber = {n}\nnose_radius_mm = {NOSE_MM[n]}\n"
        + (f'groove_corner = "{corner[n]}"\n' if n in corner else "")
        for n in (OD, BORE, LEFT, RIGHT)
    )


def job(
    folder: Path, frame: Frame, errors_um: Sequence[float] | Array, more: str = "", exchanged: bool = False
) -> Path:
    """A job beside the programs, with these touches."""
    rows = [
        f"{k},{p.feature},{p.x_mm:.6f},{p.z_mm:.6f},{e:.6f}"
        for k, (p, e) in enumerate(zip(PLACES, errors_um, strict=True), 1)
    ]
    (folder / "touches.csv").write_text("\n".join(["point,feature,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    of_first = f"[[setups.tools]]\nnumber = {FIRST}\nnose_radius_mm = {NOSE_MM[FIRST]}\n"
    given = 'cut_with = "given"\n'
    setups = setup_toml("first", "zero_at_z_mm = 0.0", "linuxcnc", of_first, given)
    setups += setup_toml("second", STATES[frame], "linuxcnc", tools_toml(frame, exchanged), given)
    (folder / "job.toml").write_text(
        f'[part]\nname = "second side"\n{PROFILE}{setups}[gauging]\ntouches = "touches.csv"\n{more}'
    )
    return folder / "job.toml"
