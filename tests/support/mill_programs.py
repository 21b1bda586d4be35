"""A plate's program in the words of five controls, written from its own list of cuts; nothing of the product."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

Control = Literal["fanuc-mill", "haas-mill", "linuxcnc", "siemens", "heidenhain"]
CONTROLS: tuple[Control, ...] = ("fanuc-mill", "haas-mill", "linuxcnc", "siemens", "heidenhain")
RADIUS = {1: 10.0, 2: 4.0, 3: 3.0, 5: 2.9, 6: 3.0}
"""Cutters and drills of the shop, mm."""


@dataclass
class Writer:
    """Writes moves; `d_of` and `h_of` are the registers that a tool is called with, its own number without."""

    control: Control
    d_of: dict[int, int] = field(default_factory=dict)
    h_of: dict[int, int] = field(default_factory=dict)
    wear_of: dict[int, float] = field(default_factory=dict)  # radii of cutters whose D holds wear alone
    lines: list[str] = field(default_factory=list)
    tool: int = 0
    side: str = ""

    @property
    def klartext(self) -> bool:
        return self.control == "heidenhain"

    def begin(self) -> None:
        head = {
            "siemens": ["G17 G71 G90 G40"],
            "heidenhain": ["BEGIN PGM PLATE MM"],
            "linuxcnc": ["G21 G17 G90 G40 G80 G49"],
        }
        self.lines += head.get(self.control, ["%", "O1000", "G21 G17 G90 G40 G80 G49"])

    def end(self) -> str:
        last = {"heidenhain": ["M30", "END PGM PLATE MM"], "siemens": ["M30"], "linuxcnc": ["M2"]}
        self.lines += last.get(self.control, ["M30", "%"])
        if self.klartext:
            self.lines = [f"{k} {line}" for k, line in enumerate(self.lines)]
        return "\n".join(self.lines) + "\n"

    def change(self, tool: int, following: int, offset: int = 1) -> None:
        """Calls a tool, and gets the following one ready, as most programs do."""
        self.tool = tool
        if self.klartext:
            self.lines += [f"TOOL CALL {tool} Z S3000", f"CYCL DEF 247 DATUM SETTING Q339={offset}", "M3"]
            return
        name = f"G{53 + offset}"
        self.lines += [f"T{tool} M6"]
        self.lines += ["D1"] if self.control == "siemens" else []
        self.lines += [f"T{following}"] if following else []
        self.lines += [f"{name} G0 X0. Y0. S3000 M3"]
        h = self.h_of.get(tool, tool)
        self.lines += ["G0 Z50."] if self.control == "siemens" else [f"G43 H{h} Z50."]

    def rapid(self, x: float, y: float, z: float) -> None:
        if self.klartext:
            self.lines += [f"L Z{50.0:+.3f} FMAX", f"L X{x:+.4f} Y{y:+.4f} FMAX", f"L Z{z:+.4f} FMAX"]
        else:
            self.lines += ["G0 Z50.", f"G0 X{x:.4f} Y{y:.4f}", f"Z{z:.4f}"]

    def plunge(self, z: float) -> None:
        self.lines += [f"L Z{z:+.4f} F200"] if self.klartext else [f"G1 Z{z:.4f} F200."]

    def line(self, x: float, y: float) -> None:
        if self.klartext:
            self.lines += [f"L X{x:+.4f} Y{y:+.4f}{self.side}"]
        else:
            self.lines += [f"{self.side}G1 X{x:.4f} Y{y:.4f}"]
        self.side = ""

    def arc(self, ccw: bool, x: float, y: float, centre: tuple[float, float], start: tuple[float, float]) -> None:
        if self.klartext:
            turn = "DR+" if ccw else "DR-"
            self.lines += [f"CC X{centre[0]:+.4f} Y{centre[1]:+.4f}", f"C X{x:+.4f} Y{y:+.4f} {turn}"]
        else:
            i, j = centre[0] - start[0], centre[1] - start[1]
            self.lines += [f"{'G3' if ccw else 'G2'} X{x:.4f} Y{y:.4f} I{i:.4f} J{j:.4f}"]

    def compensate(self, left: bool | None) -> None:
        """Switches compensation with the next line."""
        if self.klartext:
            self.side = {True: " RL", False: " RR", None: " R0"}[left]
            return
        d = self.d_of.get(self.tool, self.tool)
        word = {True: "G41", False: "G42", None: "G40"}[left]
        self.side = f"{word} " if left is None or self.control == "siemens" else f"{word} D{d} "

    def drill(self, x: float, y: float, bottom: float) -> None:
        if self.klartext:
            self.rapid(x, y, 5.0)
            self.lines += [
                f"CYCL DEF 200 DRILLING Q200=2 Q201={bottom:.3f} Q206=100 Q202=50 Q210=0 Q203=0 Q204=20 Q211=0",
                f"L X{x:+.4f} Y{y:+.4f} FMAX M99",
            ]
        elif self.control == "siemens":
            self.rapid(x, y, 5.0)
            self.lines += [f"MCALL CYCLE81(20,0,2,{bottom:.3f})", f"X{x:.4f} Y{y:.4f}", "MCALL"]
        else:
            self.lines += ["G0 Z20.", f"G99 G81 X{x:.4f} Y{y:.4f} Z{bottom:.4f} R2. F100.", "G80"]

    def circle(self, x: float, y: float, radius: float, ccw: bool, levels: tuple[float, ...], inside: bool) -> None:
        """Goes around, under the compensation that was switched, as four quarters; the way in is along a radius."""
        side, away = self.side, 0.0 if inside else radius + 25.0
        radius += (-1.0 if inside else 1.0) * (self.wear_of.get(self.tool, 0.0) if side else 0.0)
        for z in levels:
            self.rapid(x + away, y, z + 3.0)
            self.plunge(z)
            self.side = side
            self.line(x + radius, y)
            start = (x + radius, y)
            for quarter in (1, 2, 3, 4):
                angle = quarter * math.pi / 2.0 * (1.0 if ccw else -1.0)
                to = (x + radius * math.cos(angle), y + radius * math.sin(angle))
                self.arc(ccw, *to, (x, y), start)
                start = to
            if side:
                self.compensate(None)
            self.line(x + away, y)
        self.side = ""

    def pocket(self, box: tuple[float, float, float, float], corner: float, ccw: bool, z: float) -> None:
        """Goes around the inside of a rectangle (x0, y0, x1, y1) with rounded corners, from its middle."""
        wear = self.wear_of.get(self.tool, 0.0)
        (x0, y0, x1, y1), corner = (box[0] + wear, box[1] + wear, box[2] - wear, box[3] - wear), corner - wear
        side, middle = self.side, (0.5 * (x0 + x1), 0.5 * (y0 + y1))
        self.side = ""
        self.rapid(*middle, z + 3.0)
        self.plunge(z)
        self.side = side
        sides = [
            ((x1 - corner, y0), (x1, y0 + corner), (x1 - corner, y0 + corner)),
            ((x1, y1 - corner), (x1 - corner, y1), (x1 - corner, y1 - corner)),
            ((x0 + corner, y1), (x0, y1 - corner), (x0 + corner, y1 - corner)),
            ((x0, y0 + corner), (x0 + corner, y0), (x0 + corner, y0 + corner)),
        ]
        if not ccw:
            sides = [(end, start, centre) for start, end, centre in reversed(sides)]
        self.line(sides[-1][1][0], sides[-1][1][1])
        for start, end, centre in sides:
            self.line(*start)
            self.arc(ccw, *end, centre, start)
        if side:
            self.compensate(None)
        self.line(*middle)
        self.side = ""


def plate(control: Control, change: Callable[[Writer], None] | None = None) -> str:
    """Returns the program of the plate: bores, bosses, a pocket, a drilled hole, a rib, and three planes.

    Tool 1 faces, roughs the bores and the bosses by paths of its centre, and finishes the bosses by G41; tool 2
    finishes the bores (G41, climb) and the pocket (G42, conventional); tool 3 mills the rib by paths of its centre,
    climb; 5 drills and 6 reams.
    """
    w = Writer(control, d_of={1: 21, 2: 22} if control in ("fanuc-mill", "haas-mill") else {}, h_of={})
    if change is not None:
        change(w)
    w.begin()
    w.change(1, 2)
    for z, y in ((0.0, 60.0), (-8.0, 75.0), (-15.0, 90.0)):
        w.rapid(-90.0, y, z + 2.0)
        w.plunge(z)
        w.line(90.0, y)
        w.line(90.0, y + 5.0)
        w.line(-90.0, y + 5.0)
    for u in (-25.0, 25.0):
        w.circle(u, 0.0, 8.0 + 10.0 + 0.3, False, (-10.0,), inside=False)
        w.compensate(True)
        w.circle(u, 0.0, 8.0, False, (-10.0,), inside=False)
    w.change(2, 3)
    for k, (x, y) in enumerate([(-50, -30), (0, -30), (50, -30), (-50, 30), (0, 30), (50, 30)]):
        w.circle(x, y, 6.0 + k - 4.0 - 0.2, True, (-20.0,), inside=True)
        w.compensate(True)
        w.circle(x, y, 6.0 + k, True, (-10.0, -20.0), inside=True)
    w.compensate(False)
    w.pocket((60.0, -10.0, 90.0, 10.0), 6.0, False, -12.0)
    w.change(3, 5)
    for y, to in ((-50.0 + 2.0 + 3.0, 1.0), (-50.0 - 2.0 - 3.0, -1.0)):
        w.rapid(-to * 40.0, y, 2.0)
        w.plunge(-5.0)
        w.line(to * 40.0, y)
    w.change(5, 6)
    w.drill(80.0, 40.0, -22.0)
    w.change(6, 0)
    w.drill(80.0, 40.0, -20.0)
    return w.end()
