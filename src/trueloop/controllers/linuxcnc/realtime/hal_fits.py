"""Whether an image and a configuration of LinuxCNC are of one machine: its axes, their limits, the unit they are in."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from trueloop.controllers.linuxcnc.realtime.configuration import Configuration, Entry
from trueloop.controllers.linuxcnc.realtime.hal_checks import AXES, MM_PER_UNIT, mm_per_unit, units
from trueloop.errors import Code, Place, TrueloopError
from trueloop.realtime.image import TRAVEL_TOLERANCE_MM, Image

KEYS: Final = ("MIN_LIMIT", "MAX_LIMIT")
NO_LIMIT: Final = 1e99
"""LinuxCNC's own default, in machine units."""

Ends = tuple[float, float]


class Limits(NamedTuple):
    """Soft limits of one axis in machine units, the entries of the INI file that state them, the joint's section."""

    ends: Ends
    entries: tuple[Entry, ...]
    section: str

    def in_mm(self, unit_mm: float) -> Ends:
        """Returns lowest and highest command, mm, for a machine unit of `unit_mm`."""
        return self.ends[0] * unit_mm, self.ends[1] * unit_mm

    def inside_mm(self, unit_mm: float, travel: Ends) -> Ends:
        """Returns how far MIN_LIMIT and MAX_LIMIT lie inside a travel, mm: a correction's room towards that end."""
        low, high = self.in_mm(unit_mm)
        return low - travel[0], travel[1] - high


def limits_of(configuration: Configuration, joint: int, axis: int) -> Limits:
    """Returns the limits of [JOINT_N], else of [AXIS_L]; ±1e99 where neither has one. Raises RTC-HAL for no number."""
    sections = (f"JOINT_{joint}", f"AXIS_{AXES[axis]}")
    entries, ends = [], []
    for key, default in zip(KEYS, (-NO_LIMIT, NO_LIMIT), strict=True):
        found = [entry for section in sections for entry in configuration.all(section, key)[:1]]
        entries += found[:1]
        ends.append(_number(found[0]) if found else default)
    return Limits((ends[0], ends[1]), tuple(entries), sections[0])


def _number(entry: Entry) -> float:
    try:
        return float(entry.value)
    except ValueError:
        raise TrueloopError(
            Code.RTC_HAL,
            f"[{entry.section}]{entry.key} = {entry.value} is not a number",
            hint="write the limit in machine units",
            place=entry.place,
        ) from None


def check_image(configuration: Configuration, joints: Mapping[int, int], image: Image) -> None:
    """Raises RTC-HAL where commands that the limits let pass leave the image's travel, or axes differ, axis by axis.

    The corrector goes to fault 3 and pauses the program as soon as a command is outside the travel.
    """
    unit_mm = mm_per_unit(configuration)
    limits = {axis: limits_of(configuration, joint, axis) for axis, joint in joints.items()}
    outside = [axis for axis, found in limits.items() if not _within(found, unit_mm, image.limits.travel_mm[axis])]
    if outside:
        first = limits[outside[0]]
        raise TrueloopError(
            Code.RTC_HAL,
            "; ".join(_sentence(axis, limits[axis], unit_mm, image) for axis in outside)
            + ": there the corrector faults and pauses the program",
            hint=_hint(configuration, limits, image),
            place=first.entries[0].place if first.entries else Place(str(configuration.ini)),
        )
    for axis in set(range(3)) - set(joints):
        low, high = image.limits.travel_mm[axis]
        if not (low <= 0.0 <= high and high - low <= MOST_OF_NO_AXIS_MM):
            raise TrueloopError(
                Code.RTC_HAL,
                f"the image's machine has an axis {AXES[axis]} that travels from {low:g} to {high:g} mm, the "
                f"configuration has {', '.join(AXES[known] for known in joints)} alone",
                hint="give the image of this machine: `trueloop realtime show IMAGE` prints which one it is for",
                place=configuration.all("KINS", "KINEMATICS")[0].place,
            )


MOST_OF_NO_AXIS_MM: Final = 2.0
"""`trueloop realtime image` gives an axis that the machine does not have a travel of −1 to 1 mm."""


def _within(limits: Limits, unit_mm: float, travel: Ends) -> bool:
    return min(limits.inside_mm(unit_mm, travel)) >= -TRAVEL_TOLERANCE_MM


def _sentence(axis: int, limits: Limits, unit_mm: float, image: Image) -> str:
    low, high = image.limits.travel_mm[axis]
    (from_mm, to_mm), travel = limits.in_mm(unit_mm), f"the image's travel is {low:g} to {high:g} mm"
    if len(limits.entries) < len(KEYS):
        stated = {entry.key for entry in limits.entries}
        missing = " and ".join(key for key in KEYS if key not in stated)
        return f"[{limits.section}] has no {missing}: commands of {AXES[axis]} have no end, {travel}"
    return f"{AXES[axis]} may be commanded from {from_mm:g} to {to_mm:g} mm ([{limits.section}]), {travel}"


def _hint(configuration: Configuration, limits: Mapping[int, Limits], image: Image) -> str:
    """Names another unit where all limits fit in that one; else what makes them fit."""
    for name, unit_mm in MM_PER_UNIT.items():
        if all(_within(found, unit_mm, image.limits.travel_mm[axis]) for axis, found in limits.items()):
            return f"[TRAJ]LINEAR_UNITS is {units(configuration).value}; in {name} all limits are inside the travel"
    return (
        "give the image of this machine; if it is that, set MIN_LIMIT and MAX_LIMIT inside the travel, or make the "
        "image anew: `trueloop realtime image … --travel AXIS=LOW,HIGH`"
    )
