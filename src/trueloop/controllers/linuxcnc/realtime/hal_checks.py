"""The facts of a configuration that the corrector needs, and configurations that it does not fit."""

import re
from collections.abc import Mapping
from typing import Final, NamedTuple

from trueloop.controllers.linuxcnc.realtime.configuration import Configuration, Entry, HalLine
from trueloop.errors import Code, Place
from trueloop.realtime.image import TRAVEL_TOLERANCE_MM, Image

AXES: Final = "XYZ"
MM_PER_UNIT: Final = {"mm": 1.0, "metric": 1.0, "cm": 10.0, "in": 25.4, "inch": 25.4, "imperial": 25.4}
GANTRY: Final = "docs/realtime-component.md shows the lines of HAL that give a second joint the correction of the first"


def check_free(configuration: Configuration) -> None:
    """Raises RTC-HAL where the corrector is already."""
    found = next((line for line in configuration.hal if any(word.startswith("rtec.") for word in line.words)), None)
    if found:
        raise Code.RTC_HAL.refusal(
            f"the corrector is in it already: {found.text.strip()!r}",
            hint="take its lines out to have all of them anew",
            place=found.place,
        )


def joints_of(configuration: Configuration) -> dict[int, int]:
    """Returns the joint of each axis, 0, 1, 2 for X, Y, Z. Raises RTC-HAL where joints are not axes, or two are one."""
    kinematics = configuration.all("KINS", "KINEMATICS")
    words = kinematics[0].value.split() if kinematics else []
    if words[:1] != ["trivkins"]:
        raise Code.RTC_HAL.refusal(
            f"[KINS]KINEMATICS is {' '.join(words) or 'not given'}: joints are no axes there",
            hint="the correction is by axis: only trivkins is supported",
            place=kinematics[0].place if kinematics else Place(str(configuration.ini)),
        )
    given = [word.partition("=")[2] for word in words if word.startswith("coordinates=")]
    letters = given[0].upper() if given else "XYZABCUVW"
    count = int(configuration.value("KINS", "JOINTS", str(len(letters))))
    letters = letters[:count]
    twice = [letter for letter in AXES if letters.count(letter) > 1]
    if twice:
        joints = [str(k) for k, letter in enumerate(letters) if letter == twice[0]]
        raise Code.RTC_HAL.refusal(
            f"axis {twice[0]} has joints {' and '.join(joints)}: the corrector has one output an axis",
            hint=GANTRY,
            place=kinematics[0].place,
        )
    return {AXES.index(letter): joint for joint, letter in enumerate(letters) if letter in AXES}


def check_compensation(configuration: Configuration, joints: dict[int, int]) -> None:
    """Raises RTC-HAL where LinuxCNC corrects an axis by itself."""
    for joint in joints.values():
        for entry in configuration.all(f"JOINT_{joint}", "COMP_FILE"):
            raise Code.RTC_HAL.refusal(
                f"joint {joint} has COMP_FILE = {entry.value}: its error would be corrected twice",
                hint="take COMP_FILE out; the model holds that term too",
                place=entry.place,
            )


def added(configuration: Configuration, function: str) -> HalLine:
    """Returns the line that puts a function into a thread. Raises RTC-HAL without one, and for a place by number."""
    found = [line for line in configuration.commands("addf") if line.words[1] == function and len(line.words) > 2]
    if not found:
        raise Code.RTC_HAL.refusal(
            f"no line says `addf {function} THREAD`",
            hint="the corrector's functions go before and after motion's",
            place=Place(str(configuration.ini)),
        )
    if found[0].words[3:] not in ((), ("-1",)):
        raise Code.RTC_HAL.refusal(
            f"{function} has its place in the thread by number: {found[0].text.strip()!r}",
            hint="add the functions in the order in which they shall run, and take the numbers out",
            place=found[0].place,
        )
    return found[0]


def units(configuration: Configuration) -> Entry:
    """Returns the entry of the machine's unit. Raises RTC-HAL without one."""
    found = configuration.all("TRAJ", "LINEAR_UNITS")
    if not found:
        raise Code.RTC_HAL.refusal(
            "[TRAJ]LINEAR_UNITS is not given: mm-per-unit is not known",
            hint="write LINEAR_UNITS = mm, or inch",
            place=Place(str(configuration.ini)),
        )
    return found[0]


def mm_per_unit(configuration: Configuration) -> float:
    """Raises RTC-HAL for a unit that is none."""
    entry = units(configuration)
    if re.fullmatch(r"\d*\.?\d+", entry.value) and float(entry.value) > 0:
        return 1 / float(entry.value)  # a number says how many units a mm has
    if entry.value.lower() not in MM_PER_UNIT:
        raise Code.RTC_HAL.refusal(
            f"[TRAJ]LINEAR_UNITS = {entry.value} is no known unit",
            hint=f"write one of {', '.join(MM_PER_UNIT)}",
            place=entry.place,
        )
    return MM_PER_UNIT[entry.value.lower()]


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
        raise Code.RTC_HAL.refusal(
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
        raise Code.RTC_HAL.refusal(
            "; ".join(_sentence(axis, limits[axis], unit_mm, image) for axis in outside)
            + ": there the corrector faults and pauses the program",
            hint=_hint(configuration, limits, image),
            place=first.entries[0].place if first.entries else Place(str(configuration.ini)),
        )
    for axis in set(range(3)) - set(joints):
        low, high = image.limits.travel_mm[axis]
        if not (low <= 0.0 <= high and high - low <= MOST_OF_NO_AXIS_MM):
            raise Code.RTC_HAL.refusal(
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
