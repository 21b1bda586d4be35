"""Structures in the letters of ISO 10791: from the work through the bed to the tool, as `w X b Y Z (C) t`.

Axes left of `b` carry the work, those right of it the tool; letters in brackets are spindles.
"""

import difflib
import re
from collections.abc import Sequence
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import Axis, AxisKind, Chain, ErrorName, error_name
from trueloop.machine.model.term import Part, Term, segments

SQUARENESS = ("EC0Y", "EB0Z", "EA0Z")


def mill_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Returns eighteen motion errors of X, Y, Z (splines of `count` segments) and three squareness errors."""
    motions = [_motion(chain.axis(axis), c, degree, count, datum, both_ways) for axis in "XYZ" for c in "XYZABC"]
    return tuple(motions) + tuple(Term(error_name(name)) for name in SQUARENESS)


def turning_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Cross slide and carriage in the plane of turning, squareness and parallelism to the spindle axis."""
    motions = [_motion(chain.axis(axis), c, degree, count, datum, both_ways) for axis in "XZ" for c in "XZB"]
    return tuple(motions) + tuple(Term(error_name(name)) for name in ("EB0X", "EB0Z"))


def five_axis_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Returns a mill's terms and six motion errors of each rotary axis, zero at 0; lines are `frame_terms`."""
    rotary = [axis for axis in chain.axes if axis.kind is AxisKind.ROTARY]
    turns = [_turn(axis, component, degree, count, both_ways) for axis in rotary for component in "XYZABC"]
    return mill_terms(chain, degree=degree, count=count, datum=datum, both_ways=both_ways) + tuple(turns)


def frame_terms(chain: Chain, terms: Sequence[Term]) -> tuple[Term, ...]:
    """Returns every constant of place not in `terms`: directions of linear axes, lines of rotary ones, the spindle."""
    taken = {term.name for term in terms}
    return tuple(Term(name) for name in chain.errors() if name.place and name not in taken)


def _turn(axis: Axis, component: str, degree: int, count: int, both_ways: bool) -> Term:
    zero = min(max(0.0, axis.travel[0]), axis.travel[1])
    return Term(ErrorName(component, axis.name), (Part(segments(*axis.travel, count, degree, (zero,))),), both_ways)


def _motion(axis: Axis, component: str, degree: int, count: int, datum: float | None, both_ways: bool) -> Term:
    assert axis.kind is AxisKind.LINEAR
    name = ErrorName(component, axis.name)
    low, high = axis.travel
    straightness = not name.is_rotation and name.number != axis.number
    zeros = (low, high) if straightness else (min(max(datum if datum is not None else low, low), high),)
    return Term(name, (Part(segments(low, high, count, degree, zeros)),), both_ways)


PRESETS: Final = {
    "turning": "w (C) b Z X t",
    "mill-table-xy": "w X Y b Z (S) t",
    "mill-table-yx": "w Y X b Z (S) t",
    "mill-table-x": "w X b Y Z (S) t",
    "mill-table-y": "w Y b X Z (S) t",
    "mill-travelling-column": "w b X Y Z (S) t",
    "mill-gantry": "w b Y X Z (S) t",
    "mill-horizontal-table-x": "w X b Z Y (S) t",
    "mill-horizontal-table-z": "w Z b X Y (S) t",
    "five-axis-table-table-ac": "w C A b X Y Z (S) t",
    "five-axis-table-table-bc": "w C B b X Y Z (S) t",
    "five-axis-head-table-bc": "w C b X Y Z B (S) t",
    "five-axis-head-table-ac": "w C b X Y Z A (S) t",
    "five-axis-head-head-ca": "w b X Y Z C A (S) t",
    "five-axis-head-head-cb": "w b X Y Z C B (S) t",
}
"""Usual configurations by name. In `turning` Z is the carriage and X the cross slide on it [4773 Fig. 6]."""

_TOKEN: Final = re.compile(r"\s*(\(([A-Z])\)|[A-Z]|[wbt])")
_DIRECTION: Final = {letter: number % 3 for number, letter in enumerate("XYZABCUVW")} | {"S": 2}


def chain_of(structure: str) -> Chain:
    """Returns the chain of a preset or of letters, all frames at the bed's origin. Raises MCH-STRUCTURE."""
    text = PRESETS.get(structure, structure)
    tokens = _TOKEN.findall(text)
    letters = [token for token, _ in tokens]
    whole = "".join(letters) == re.sub(r"\s", "", text)
    if not whole or [t for t in letters if t.islower()] != ["w", "b", "t"] or letters[0] != "w" or letters[-1] != "t":
        raise _no_structure(structure)
    axes = [token if token == "b" else _axis(token, spindle, structure) for token, spindle in tokens[1:-1]]
    bed = axes.index("b")
    work = [axis for axis in axes[:bed] if isinstance(axis, Axis)]
    return Chain(tuple(reversed(work)), tuple(axis for axis in axes[bed + 1 :] if isinstance(axis, Axis)))


def _axis(token: str, spindle: str, structure: str) -> Axis:
    letter = spindle or token
    if letter not in _DIRECTION:
        raise _no_structure(structure)
    if spindle:
        return Axis(letter, AxisKind.SPINDLE, _DIRECTION[letter])
    return Axis(letter, AxisKind.ROTARY if letter in "ABC" else AxisKind.LINEAR, _DIRECTION[letter])


def _no_structure(structure: str) -> TrueloopError:
    near = difflib.get_close_matches(structure, PRESETS, n=1)
    return Code.MCH_STRUCTURE.refusal(
        f"{structure!r} is neither one of the {len(PRESETS)} presets nor a structure from work to tool",
        hint=f"did you mean {near[0]!r}?"
        if near
        else "write the axes from work to bed to tool, spindles in brackets: w X b Y Z (S) t; presets: "
        + ", ".join(PRESETS),
    )
