"""The user's options of memory."""

from dataclasses import dataclass
from math import radians
from typing import Annotated, Final, Literal, TypeAlias

from trueloop.domain.option import Option

Use: TypeAlias = Literal["on", "bands", "frozen", "off"]


@dataclass(frozen=True)
class MemoryOptions:
    """The way in which earlier parts of an edge take part in a correction.

    `memory`: "on"; "bands": the correction is today's own fit, earlier parts give only its band; "frozen": nothing is
    learned from parts after `last_part`; "off": earlier parts are not used at all. `first_weight`: share of the
    correction that is applied until one inspected part has confirmed what the actuator does [4773 §2.5].
    """

    memory: Annotated[
        Use,
        Option(
            "memory.use",
            '`"on"`; `"bands"`: the correction is the fit of today\'s touches, earlier parts give only the band; '
            '`"frozen"`: nothing is learned from parts after `last_part`; `"off"`.',
        ),
    ] = "on"
    last_part: Annotated[
        str, Option("memory.last_part", 'With `"frozen"`: the serial number of the last part that is learned from.')
    ] = ""
    first_weight: Annotated[
        float,
        Option(
            "memory.first_weight",
            "Share of the correction that is applied until an inspected part has confirmed what the machine makes of "
            "a correction.",
            above=0,
            most=1,
        ),
    ] = 0.75
    unseen_rad: Annotated[
        float,
        Option(
            "memory.unseen_deg",
            "How far a contact angle may be from the nearest that was touched or inspected; beyond, nothing is "
            "predicted.",
            above=0,
            most=45,
        ),
    ] = radians(6.0)


IN_FULL: Final = MemoryOptions(first_weight=1.0)
"""The options for contours: a corrected program takes off the amount it states, read back from it, from the first part
on."""
