"""Every way in which a program's contour is refused."""

from collections.abc import Callable

import pytest

from tests.support.feed_moves import cut, to
from tests.support.profiles import NOSE_RADIUS_MM, facetst
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Line
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.validate import checked_profile
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.cuts import cutters_of
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.match.cutters import CuttingEdge, cutters
from trueloop.nc.match.matching import match_contour
from trueloop.nc.program.along import feed_moves, nose_centre_moves
from trueloop.nc.program.called import CalledOffset
from trueloop.nc.program.program import read_program

PATH = nose_centre_path(facetst(), NOSE_RADIUS_MM).features
COMPENSATED = b"G21 G18 G8 G90 F100\nG0 X30 Z5\nG42 G1 X20 Z5\nG1 Z-10\nM2\n"
BORED = COMPENSATED.replace(b"G42", b"G41")

GROOVE = [Line("wall", (25.0, -40.0), (20.0, -40.0)), Line("floor", (20.0, -40.0), (20.0, -34.0))]
LEFT, RIGHT = CuttingEdge(CalledOffset(5), 0.0, "left"), CuttingEdge(CalledOffset(15), 0.0, "right")


def _groove_cut_by(*calls: CalledOffset) -> tuple[CuttingEdge | None, ...]:
    """The wall and the floor of a groove, cut by the one and the floor again by the other."""
    moves = [*cut(GROOVE), *cut(GROOVE[1:], first=2, chain=1)]
    calling = {move.index: call for move, call in zip(moves, (calls[0], *calls), strict=True)}
    of_edge = [[move for move in moves if calling[move.index] == edge.called] for edge in (LEFT, RIGHT)]
    return cutters(checked_profile(GROOVE), of_edge, (LEFT, RIGHT)).edge_of


def _calls(words: bytes) -> object:
    source = read_program(b"G21\n" + words + b"\nG1 X20. Z-20. F1\n", "fanuc-lathe")
    return cutters_of(source, Run({}), facetst(), (LEFT,), {})


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.NC_COMPENSATED: lambda: nose_centre_moves(read_program(COMPENSATED, "linuxcnc").run()),
    Code.NC_BORE: lambda: contour_of_program(feed_moves(read_program(BORED, "linuxcnc").run()), 0.4),
    Code.NC_NO_CONTOUR: lambda: contour_of_program([], NOSE_RADIUS_MM),
    Code.NC_NO_MATCH: lambda: match_contour(cut(PATH[:2]), facetst(), NOSE_RADIUS_MM),
    Code.NC_AMBIGUOUS: lambda: match_contour(
        [*cut(PATH), *cut([to(PATH[3].start_mm, PATH[3].end_mm)], first=4, chain=1)], facetst(), NOSE_RADIUS_MM
    ),
    Code.NC_TOOLS: lambda: _groove_cut_by(CalledOffset(5), CalledOffset(15)),
    Code.NC_EDGE: lambda: _groove_cut_by(CalledOffset(15), CalledOffset(15)),
    Code.NC_NO_TOOL: lambda: _calls(b"T0303"),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    with pytest.raises(TrueloopError) as refusal:
        PRODUCERS[code]()
    assert refusal.value.code is code
    assert any(character.isdigit() for character in refusal.value.message)
    assert refusal.value.hint
