"""What the machine's model left on parts: what an axis error is looked for in."""

from collections.abc import Mapping
from dataclasses import dataclass

from trueloop.arrays import Array, Integers, by_content
from trueloop.machine.model.model import State


@by_content
@dataclass(frozen=True)
class Residuals:
    """ERROR_MTG,RESID at n gauging points of many parts: `residual_mm` (n,) along the outward normals (n, 3).

    Positive where material is left on [6876 §3.5]. `part` (n,) numbers the parts in the order in which they were cut.
    `state` is the machine in each point at which it erred so: positions (n, axes), tool, signals () or (n,), travel
    where it is known. What CMM and corrected touches differ by arose while probing: then `tool_mm` is the stylus.
    `element` names the signal that is the temperature of each axis' element, as
    {"X": "cross slide", "Z": "carriage", "C": "spindle"}.
    """

    part: Integers
    normal: Array
    state: State
    residual_mm: Array
    element: Mapping[str, str]
