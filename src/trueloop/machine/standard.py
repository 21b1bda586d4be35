"""The usual set of error terms of a machine, each once: what one error says is taken out of the others.

A positioning or angular error is zero at the datum position. A straightness error is zero at both ends of travel, so
that the slope is squareness alone. The first of X, Y, Z is the reference of squareness, the second lies in the plane
of the first two, so three linear axes have three squareness errors and 21 terms in all. On a turning centre the
spindle axis is the reference [4773 §2.4], whose δz(x), δx(z) contain squareness and parallelism.
"""

from trueloop.machine.chain import Axis, AxisKind, Chain
from trueloop.machine.names import ErrorName, error_name
from trueloop.machine.position_basis import segments
from trueloop.machine.term import Part, Term

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


def _motion(axis: Axis, component: str, degree: int, count: int, datum: float | None, both_ways: bool) -> Term:
    assert axis.kind is AxisKind.LINEAR
    name = ErrorName(component, axis.name)
    low, high = axis.travel
    straightness = not name.is_rotation and name.number != axis.number
    zeros = (low, high) if straightness else (min(max(datum if datum is not None else low, low), high),)
    return Term(name, (Part(segments(low, high, count, degree, zeros)),), both_ways)
