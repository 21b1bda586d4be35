"""What is wrong in a simulated shop, and by how much: written down before anything is drawn."""

from dataclasses import dataclass
from enum import StrEnum


class Fault(StrEnum):
    """What may be wrong. The comments say what `Wrong.size_mm` is the size of."""

    TOOL_OFFSET = "tool offset"  # the tool point is too far out in x by it after the first setting, else at others
    WEAR = "wear"  # what a worn nose leaves on after an hour in cut
    PROBE_OFFSET = "offset of the part probe"  # radii read too large by it
    PROBE_LAG = "lag of the part probe"  # every touch reads too far out by it, along the normal
    UNEQUAL_DEPTH = "unequal depth of cut"  # faces: what the deeper one has more than the others
    TWO_TOOLS = "offsets of two tools"  # `tool` stands too far out in z by it after its first setting
    PART_DEFLECTION = "deflection of the part"  # at the free end, at the usual depth
    FACE_DEFLECTION = "deflection of the tool on a face"  # at the axis, at the usual depth; none at the rim
    CONSTANT_SPEED = "constant spindle speed over a face"  # at the axis; none at the rim
    CHATTER = "chatter"  # root mean square of the marks on shafts
    TOOL_SEAT = "loose tool seat"  # standard deviation in x and in z from part to part
    TOOL_SLIP = "tool that slipped"  # in x from a third of the series on, until it is set anew
    PROBE_LOOSE = "loose part probe"  # standard deviation of what all touches of a part share
    RUN_OUT = "eccentric chuck"  # amplitude of one wave a turn
    JAWS = "three jaws"  # amplitude of three waves a turn at the jaws, once they have let go
    AXIS_ERROR = "error of an axis"  # what the machine's model has wrong: mm, or rad of a rotation


@dataclass(frozen=True)
class Wrong:
    """One fault and its size in mm (rad of an axis' rotation); `tool` "" is every tool.

    `error` names an axis error as ISO 230-1 does, `signal` the temperature that it follows. Of its value at 8 K above
    the reference the share `constant` is there at the reference too; `bend` is how much of it is curved over travel.
    """

    fault: Fault
    size_mm: float
    tool: str = ""
    error: str = ""
    signal: str = ""
    constant: float = 0.0
    bend: float = 0.0


@dataclass(frozen=True)
class Truth:
    """All that is wrong. `gain` is what arrives of a correction that is recorded as whole."""

    wrong: tuple[Wrong, ...] = ()
    gain: float = 1.0

    def of(self, fault: Fault) -> tuple[Wrong, ...]:
        """Those of one kind."""
        return tuple(one for one in self.wrong if one.fault is fault)

    def size_mm(self, fault: Fault, tool: str = "") -> float:
        """Of all of one kind that concern a tool, 0 where there is none."""
        return sum(one.size_mm for one in self.of(fault) if one.tool in ("", tool))
