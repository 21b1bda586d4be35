"""What of a configuration the corrector needs to know, and what it cannot be put into."""

import re
from typing import Final

from trueloop.controllers.linuxcnc.realtime.configuration import Configuration, Entry, HalLine
from trueloop.errors import Code, Place, TrueloopError

AXES: Final = "XYZ"
MM_PER_UNIT: Final = {"mm": 1.0, "metric": 1.0, "cm": 10.0, "in": 25.4, "inch": 25.4, "imperial": 25.4}
GANTRY: Final = "docs/realtime-component.md shows the lines of HAL that give a second joint the correction of the first"


def check_free(configuration: Configuration) -> None:
    """Raises RTC-HAL where the corrector is already."""
    found = next((line for line in configuration.hal if any(word.startswith("rtec.") for word in line.words)), None)
    if found:
        raise TrueloopError(
            Code.RTC_HAL,
            f"the corrector is in it already: {found.text.strip()!r}",
            hint="take its lines out to have all of them anew",
            place=found.place,
        )


def joints_of(configuration: Configuration) -> dict[int, int]:
    """Returns the joint of each axis, 0, 1, 2 for X, Y, Z. Raises RTC-HAL where joints are no axes, or two are one."""
    kinematics = configuration.all("KINS", "KINEMATICS")
    words = kinematics[0].value.split() if kinematics else []
    if words[:1] != ["trivkins"]:
        raise TrueloopError(
            Code.RTC_HAL,
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
        raise TrueloopError(
            Code.RTC_HAL,
            f"axis {twice[0]} has joints {' and '.join(joints)}: the corrector has one output an axis",
            hint=GANTRY,
            place=kinematics[0].place,
        )
    return {AXES.index(letter): joint for joint, letter in enumerate(letters) if letter in AXES}


def check_compensation(configuration: Configuration, joints: dict[int, int]) -> None:
    """Raises RTC-HAL where LinuxCNC corrects an axis by itself."""
    for joint in joints.values():
        for entry in configuration.all(f"JOINT_{joint}", "COMP_FILE"):
            raise TrueloopError(
                Code.RTC_HAL,
                f"joint {joint} has COMP_FILE = {entry.value}: its error would be corrected twice",
                hint="take COMP_FILE out; the model holds that term too",
                place=entry.place,
            )


def added(configuration: Configuration, function: str) -> HalLine:
    """Returns the line that puts a function into a thread. Raises RTC-HAL without one, and for a place by number."""
    found = [line for line in configuration.commands("addf") if line.words[1] == function and len(line.words) > 2]
    if not found:
        raise TrueloopError(
            Code.RTC_HAL,
            f"no line says `addf {function} THREAD`",
            hint="the corrector's functions go before and after motion's",
            place=Place(str(configuration.ini)),
        )
    if found[0].words[3:] not in ((), ("-1",)):
        raise TrueloopError(
            Code.RTC_HAL,
            f"{function} has its place in the thread by number: {found[0].text.strip()!r}",
            hint="add the functions in the order in which they shall run, and take the numbers out",
            place=found[0].place,
        )
    return found[0]


def units(configuration: Configuration) -> Entry:
    """Returns the entry of the machine's unit. Raises RTC-HAL without one."""
    found = configuration.all("TRAJ", "LINEAR_UNITS")
    if not found:
        raise TrueloopError(
            Code.RTC_HAL,
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
        raise TrueloopError(
            Code.RTC_HAL,
            f"[TRAJ]LINEAR_UNITS = {entry.value} is no known unit",
            hint=f"write one of {', '.join(MM_PER_UNIT)}",
            place=entry.place,
        )
    return MM_PER_UNIT[entry.value.lower()]
