"""Probing programs, one control a file, and the choice between them."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from trueloop.controllers.probing import fanuc, ge2000t, linuxcnc, siemens
from trueloop.controllers.probing.settings import Settings
from trueloop.errors import Code
from trueloop.probing.probe_plan import ProbePlan

Writer = Callable[[ProbePlan, Settings], str]

WRITERS: Mapping[str, Writer] = MappingProxyType(
    {
        "linuxcnc": linuxcnc.program,
        "fanuc": fanuc.program,
        "haas": fanuc.haas_program,
        "renishaw": fanuc.macro_program,
        "siemens": siemens.program,
        "ge2000t": ge2000t.program,
    }
)
"""Every control that a probing program can be written for, by its name."""


ONE_TOUCH: Mapping[str, str] = MappingProxyType(
    {
        "renishaw": "P9811 approaches, backs off and sets its feeds by itself",
        "ge2000t": "the control has no skip and cannot back off from where the probe touched",
    }
)
"""Controls whose programs touch a point once, and why."""


def probing_program(plan: ProbePlan, control: str, settings: Settings) -> str:
    """Writes the program that touches the plan's points. Raises PRB-LOG, PRB-SECOND (no second touch), PRB-AXIS."""
    if control not in WRITERS:
        raise Code.PRB_LOG.refusal(
            f"no probing for a control named {control!r}", hint=f"choose one of: {', '.join(WRITERS)}"
        )
    second = plan.approach.second
    if second is not None and control in ONE_TOUCH:
        raise Code.PRB_SECOND.refusal(
            f"a second touch at {second.feed_mm_per_min:g} mm/min cannot be programmed for {control!r}: "
            f"{ONE_TOUCH[control]}",
            hint="take `second_feed_mm_per_min` and `second_back_off_mm` out of the probe file's table [program]",
            values={"control": control, "feed_mm_per_min": second.feed_mm_per_min},
        )
    return WRITERS[control](plan, settings)


__all__ = ["WRITERS", "Settings", "probing_program"]
