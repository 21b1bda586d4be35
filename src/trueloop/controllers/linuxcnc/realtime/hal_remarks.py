"""What an integrator has to decide: what no line of HAL says."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from trueloop.controllers.linuxcnc.realtime.configuration import LIBRARY, Configuration
from trueloop.controllers.linuxcnc.realtime.hal_checks import AXES, mm_per_unit
from trueloop.controllers.linuxcnc.realtime.hal_fits import limits_of
from trueloop.realtime.image import Image

TO_MOTION: Final = (
    ("rtec.pause", "halui.program.pause", "a fault pauses the program"),
    ("rtec.active", "motion.homing-inhibit", "no homing while something is added: the switch would be met elsewhere"),
)


def remarks(configuration: Configuration, joints: dict[int, int], image: Image | None) -> Iterator[str]:
    """Sentences for the integrator."""
    own = sorted(
        {line.place.file or "" for line in configuration.hal if LIBRARY in Path(line.place.file or "").parents}
    )
    for file in own:
        yield f"{file} is LinuxCNC's own: copy it beside the INI file, and make the changes there."
    yield from _travels(configuration, joints, image)
    for from_, pin, why in TO_MOTION:
        if signal := configuration.signal_of(pin):
            yield f"{pin} is on signal {signal} already: bring {from_} there too, by an or2 ({why})."
    for joint in joints.values():
        for entry in configuration.all(f"JOINT_{joint}", "BACKLASH"):
            if float(entry.value or 0) != 0:
                yield f"Joint {joint} has BACKLASH = {entry.value}: a model that knows it too corrects it twice."
    if image is None:
        yield "Without an image signals are not wired and nothing is compared: name it with --image."
    yield "Enable is the integrator's: net a switch, or halui, to rtec.enable; nothing is added before."


def _travels(configuration: Configuration, joints: dict[int, int], image: Image | None) -> Iterator[str]:
    """Soft limits are motion's, which does not see what is added."""
    unit = mm_per_unit(configuration)
    for axis, joint in joints.items():
        limits = limits_of(configuration, joint, axis)
        low, high = limits.in_mm(unit)
        if image is None:
            if len(limits.entries) == 2:
                yield f"Soft limits of {AXES[axis]} are {low:g} and {high:g} mm: with --image they are compared."
            continue
        limit = image.limits.limit_mm
        inside = limits.inside_mm(unit, image.limits.travel_mm[axis])
        if min(inside) < limit:
            low, high = (max(value, 0.0) for value in inside)
            yield (
                f"Soft limits of {AXES[axis]} are {low:g} and {high:g} mm inside the image's travel: a correction "
                f"of up to {limit:g} mm towards an end has less room there, and faults. Set them {limit:g} mm inside."
            )
