"""What an integrator has to decide: what no line of HAL says."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from trueloop.controllers.linuxcnc.realtime.configuration import LIBRARY, Configuration
from trueloop.controllers.linuxcnc.realtime.hal_checks import AXES, mm_per_unit
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
    yield from _travels(configuration, joints)
    for from_, pin, why in TO_MOTION:
        if signal := configuration.signal_of(pin):
            yield f"{pin} is on signal {signal} already: bring {from_} there too, by an or2 ({why})."
    for joint in joints.values():
        for entry in configuration.all(f"JOINT_{joint}", "BACKLASH"):
            if float(entry.value or 0) != 0:
                yield f"Joint {joint} has BACKLASH = {entry.value}: a model that knows it too corrects it twice."
    if image is None:
        yield "Without an image nothing is said of signals: name it with --image."
    yield "Enable is the integrator's: net a switch, or halui, to rtec.enable; nothing is added before."


def _travels(configuration: Configuration, joints: dict[int, int]) -> Iterator[str]:
    """Soft limits are motion's, which does not see what is added."""
    unit = mm_per_unit(configuration)
    for axis, joint in joints.items():
        ends = [configuration.value(f"JOINT_{joint}", key) for key in ("MIN_LIMIT", "MAX_LIMIT")]
        if all(ends):
            low, high = (float(end) * unit for end in ends)
            yield (
                f"Soft limits of {AXES[axis]}, {low:g} to {high:g} mm, do not see the correction: the image's travel"
                " is what the drive may not leave. Set them further in by the limit, and no program meets that fault."
            )
