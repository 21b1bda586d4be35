"""The usual set of error terms of a machine, each once: what one error says is taken out of the others.

A positioning or angular error is zero at the datum position. A straightness error is zero at both ends of travel, so
that the slope is squareness alone. The first of X, Y, Z is the reference of squareness, the second lies in the plane
of the first two, so three linear axes have three squareness errors and 21 terms in all. On a turning centre the
spindle axis is the reference [4773 §2.4], whose δz(x), δx(z) contain squareness and parallelism.

That reference is a choice. Readings that know directions, places and tool lengths absolutely contain more: how the
axes lie towards what the readings count from, where lines of rotation are, how the spindle leans. These are the terms
of `frame_terms`, which a fit takes as far as the readings determine them. Motion, squareness and frame together can
represent every machine of the structure whose errors are as smooth as the functions; a model written apart from this
one proves it (`tests/unit/machine/test_every_machine.py`). Arms of rotations are counted as `kinematics.py` says.
"""

from collections.abc import Sequence

from trueloop.machine.model.chain import Axis, AxisKind, Chain
from trueloop.machine.model.names import ErrorName, error_name
from trueloop.machine.model.position_basis import segments
from trueloop.machine.model.term import Part, Term

SQUARENESS = ("EC0Y", "EB0Z", "EA0Z")


def mill_terms(
    chain: Chain, *, degree: int = 3, count: int = 1, datum: float | None = None, both_ways: bool = False
) -> tuple[Term, ...]:
    """Eighteen motion errors of X, Y, Z (splines of `count` segments) and three squareness errors."""
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
    """Those of a mill, and six motion errors of each rotary axis, zero where it stands at 0. Where its line lies is
    one of the `frame_terms`.
    """
    rotary = [axis for axis in chain.axes if axis.kind is AxisKind.ROTARY]
    turns = [_turn(axis, component, degree, count, both_ways) for axis in rotary for component in "XYZABC"]
    return mill_terms(chain, degree=degree, count=count, datum=datum, both_ways=both_ways) + tuple(turns)


def frame_terms(chain: Chain, terms: Sequence[Term]) -> tuple[Term, ...]:
    """Every constant of place not among `terms`: directions of linear axes, lines of rotary ones, the spindle."""
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
