"""Which tool offsets a program runs with: those that cut the contour, feature by feature, and the others."""

from dataclasses import dataclass

import numpy as np

from trueloop.errors import Code, TrueloopError, in_file
from trueloop.loops.turned.commanded import Commanded
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion
from trueloop.turned.options import By
from trueloop.turned.program.wear import offset_number
from trueloop.wording import wording


@dataclass(frozen=True)
class ContourTools:
    """Numbers of tool offsets: `cut_by` by feature, None before any T word; `others` that cut something else."""

    cut_by: tuple[int | None, ...]
    others: tuple[int, ...]

    @property
    def several(self) -> bool:
        """Whether the contour is cut with more than one offset: then no single one corrects it."""
        return len(set(self.cut_by)) > 1

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know where there are several."""
        if not self.several:
            return ()
        numbers = ", ".join(str(number) for number in sorted({number or 0 for number in self.cut_by}))
        return (
            wording(
                "The contour is cut with the tool offsets {numbers}: it is corrected in the program, since no single "
                "offset moves all of it.",
                numbers=numbers,
            ),
        )

    def by(self, asked: By) -> By:
        """How to correct. Raises NC-OFFSET where an offset is asked for and there are several."""
        if not self.several:
            return asked
        if asked == "offset":
            raise TrueloopError(
                Code.NC_OFFSET,
                f"the contour is cut with {len(set(self.cut_by))} tool offsets: one of them moves a part of it alone",
                hint='leave out `compensation.by = "offset"`: the contour is corrected then',
            )
        return "contour"


def contour_tools(program: Program, matched: Commanded, alone: bool = False) -> ContourTools:
    """The tools of a finish program that was matched with its profile; `alone`: the others are corrected beside it."""
    path = matched.path
    with in_file(program.file):
        cut_by = tuple(offset_number(program, path, of.moves[0].move.index) for of in matched.match.features)
        if alone:
            return ContourTools(cut_by, ())
        cutting = np.isin(path.motion, (Motion.LINE, Motion.ARC))
        firsts = [int(np.flatnonzero(cutting & (path.tool == word))[0]) for word in np.unique(path.tool[cutting])]
        numbers = {offset_number(program, path, first) for first in firsts}
    return ContourTools(cut_by, tuple(sorted(number for number in numbers - set(cut_by) if number)))
