"""Every drawing, by the name of its file."""

from collections.abc import Callable
from typing import Final

from scripts.manual.drawings import loops, signs

DRAWINGS: Final[dict[str, Callable[[], str]]] = {
    "sign-frame": signs.frame,
    "sign-error": signs.error,
    "sign-correction": signs.correction,
    "sign-diameter": signs.diameter,
    "sign-angle": signs.angle,
    "sign-machine": signs.machine,
    "three-loops": loops.three_loops,
}
