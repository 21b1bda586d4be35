"""What a translation has to know of each control: one row a dialect.

A row holds only what differs from control to control. Codes that all of them share (G00 to G03, G40 to G42, G96, G97,
I, J and K from the start of an arc) are written by `gcode`; Klartext has a writer of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final, Literal

PLANES: Final = MappingProxyType({17: "G17", 18: "G18", 19: "G19"})
OFFSETS: Final = MappingProxyType({number: f"G{53 + number}" for number in range(1, 7)})
RADIUS: Final = MappingProxyType({False: ""})
DIAMETER: Final = MappingProxyType({True: ""})


@dataclass(frozen=True)
class Control:
    """The words of one dialect; None where it has none, an empty string where it is always so.

    `kind`: what its programs are for. `inch`: the words of inch (True) and of millimetres; without
    inch it is a setting of the control. `planes`, `offsets`: by the
    number of `ToolPath.plane`, of `ToolPath.work_offset`. `diameter`: the words of X as a diameter (True) and as a
    radius. `feeds`: of feed a revolution (True) and a minute. `register` sets the position register, `machine` moves in
    machine coordinates, `home` goes home by `home_letters`, `thread` cuts one of the lead that follows `lead`, of three
    letters that of the axis on which it is longest. `dwell` takes
    seconds; `dwell_letters` says how many seconds are in one unit of a dwell's word. `tool_offset`: how the tool's own
    offset comes into force: by T (`T0101`), by G43, or with the tool (`D`: and D0 takes it away; `call`). `speed_limit`
    takes 1/min. `functions_that_move`: M codes from this on change how it moves.
    """

    kind: Literal["turning", "milling", "either"]
    begin: tuple[str, ...] = ()
    end: tuple[str, ...] = ()
    inch: Mapping[bool, str] = field(default_factory=lambda: {True: "G20", False: "G21"})
    absolute: str = "G90"
    planes: Mapping[int, str] = field(default_factory=lambda: PLANES)
    diameter: Mapping[bool, str] = field(default_factory=lambda: RADIUS)
    feeds: Mapping[bool, str] = field(default_factory=lambda: {False: "G94", True: "G95"})
    register: str | None = "G92"
    machine: str | None = "G53"
    home: tuple[str, str] | None = ("G91 G28", "G90")
    home_letters: str = "XYZ"
    offsets: Mapping[int, str] = field(default_factory=lambda: OFFSETS)
    thread: str | None = "G33"
    lead: str = "F"
    dwell: str = "G04 X{}"
    dwell_letters: Mapping[str, float] = field(default_factory=lambda: {"X": 1.0, "U": 1.0, "P": 1e-3})
    tool_offset: Literal["T", "G43", "D", "call"] = "G43"
    names_compensation: bool = False
    speed_limit: str | None = None
    functions_that_move: int = 1000


_FANUC_MILL = Control("milling", begin=("%", "O{number:04d}"), end=("%",), names_compensation=True)
_FANUC_LATHE_B = replace(
    _FANUC_MILL,
    kind="turning",
    diameter=DIAMETER,
    home=("G28", ""),
    home_letters="UVW",
    tool_offset="T",
    names_compensation=False,
    speed_limit="G92 S{}",
)
_FANUC_LATHE = replace(
    _FANUC_LATHE_B,
    absolute="",
    feeds={False: "G98", True: "G99"},
    register="G50",
    thread="G32",
    speed_limit="G50 S{}",
)

CONTROLS: Final[Mapping[str, Control]] = MappingProxyType(
    {
        "ge2000t": Control(
            "turning",
            inch={True: "G70", False: "G71"},
            planes={18: ""},
            diameter=DIAMETER,
            machine=None,
            home=None,
            offsets={1: ""},
            thread=None,
            dwell_letters={"X": 1.0},
            tool_offset="T",
        ),
        "linuxcnc": Control(
            "either",
            absolute="G90 G91.1",
            diameter={True: "G07", False: "G08"},
            offsets=MappingProxyType({**OFFSETS, 7: "G59.1", 8: "G59.2", 9: "G59.3"}),
            lead="K",
            dwell="G04 P{}",
            dwell_letters={"P": 1.0},
            names_compensation=True,
        ),
        "fanuc-lathe": _FANUC_LATHE,
        "fanuc-lathe-b": _FANUC_LATHE_B,
        "fanuc-mill": _FANUC_MILL,
        "haas-lathe": replace(_FANUC_LATHE, dwell="G04 P{}"),
        "haas-mill": replace(_FANUC_MILL, dwell="G04 P{}"),
        "siemens": Control(
            "either",
            inch={True: "G700", False: "G710"},
            diameter={True: "DIAMON", False: "DIAMOF"},
            register=None,
            home=None,
            offsets=MappingProxyType({0: "G500", **{n: OFFSETS[n] for n in range(1, 5)}, 5: "G505", 6: "G506"}),
            lead="IJK",
            dwell="G04 F{}",
            dwell_letters={"F": 1.0},
            tool_offset="D",
            speed_limit="LIMS={}",
        ),
        "heidenhain": Control(
            "milling",
            register=None,
            home=None,
            offsets={1: ""},
            thread=None,
            dwell_letters={},
            tool_offset="call",
            functions_that_move=89,
        ),
        "okuma-lathe": Control(
            "turning",
            inch={False: ""},
            planes={18: "G18"},
            diameter=DIAMETER,
            register="G50",
            machine=None,
            home=None,
            offsets={1: ""},
            thread=None,
            dwell="G04 F{}",
            dwell_letters={"F": 1.0},
            tool_offset="T",
            speed_limit="G50 S{}",
        ),
    }
)
"""The row of every dialect."""
