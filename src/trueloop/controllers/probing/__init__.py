"""Probing programs, one control a file, and the choice between them."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from trueloop.controllers.probing import fanuc, ge2000t, linuxcnc, siemens
from trueloop.controllers.probing.settings import Settings
from trueloop.errors import Code, TrueloopError
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


def probing_program(plan: ProbePlan, control: str, settings: Settings) -> str:
    """The program that touches the plan's points. Raises PRB-LOG for a control that is not known, PRB-AXIS."""
    if control not in WRITERS:
        raise TrueloopError(
            Code.PRB_LOG, f"no probing for a control named {control!r}", hint=f"choose one of: {', '.join(WRITERS)}"
        )
    return WRITERS[control](plan, settings)


__all__ = ["WRITERS", "Settings", "probing_program"]
