"""Which tool offsets a program runs with: those that cut the contour, feature by feature, and the others."""

from collections.abc import Mapping, Set
from dataclasses import dataclass

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.loops.turned.commanded import Commanded
from trueloop.nc.program.called import Called, called
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion
from trueloop.turned.options import By
from trueloop.wording import wording


@dataclass(frozen=True)
class ContourTools:
    """Tool offsets by feature, None where the tool has no number; `others`: numbers that cut something else.

    `sharing`: the T words of several tools that run with the offset that cuts the contour.
    """

    calls: tuple[Called | None, ...]
    others: tuple[int, ...]
    sharing: tuple[int, ...] = ()

    @property
    def cut_by(self) -> tuple[int | None, ...]:
        """Numbers of the offsets by feature."""
        return tuple(None if call is None else call.number for call in self.calls)

    @property
    def several(self) -> bool:
        """Whether the contour is cut with more than one offset: then no single one corrects it."""
        return len(set(self.calls)) > 1

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know where there are several offsets, or several tools of one."""
        if self.sharing:
            return (
                wording(
                    "{count} tools ({tools}) use offset {number}: it moves what each of them cuts, so that the contour "
                    "is corrected in the program.",
                    count=len(self.sharing),
                    tools=self._sharing_words,
                    number=self.cut_by[0] or 0,
                ),
            )
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

    @property
    def _sharing_words(self) -> str:
        return ", ".join(f"T{word:04d}" for word in self.sharing)

    def by(self, asked: By) -> By:
        """How to correct. Raises NC-OFFSET where an offset is asked for and there are several, or tools share it."""
        if not self.several and not self.sharing:
            return asked
        if asked == "offset" and self.sharing:
            raise TrueloopError(
                Code.NC_OFFSET,
                f"{len(self.sharing)} tools ({self._sharing_words}) use offset {self.cut_by[0]}: it moves what each of "
                "them cuts",
                hint="give the finishing tool an offset number of its own, or leave out `compensation.by`",
            )
        if asked == "offset":
            raise TrueloopError(
                Code.NC_OFFSET,
                f"the contour is cut with {len(set(self.calls))} tool offsets: one of them moves a part of it alone",
                hint='leave out `compensation.by = "offset"`: the contour is corrected then',
            )
        return "contour"


def contour_tools(program: Program, matched: Commanded, alone: bool = False) -> ContourTools:
    """The tools of a finish program that was matched with its profile; `alone`: the others are corrected beside it."""
    path = matched.path

    def of(move: int) -> Called | None:
        return called(program.dialect, path, move)

    calls = tuple(of(feature.moves[0].move.index) for feature in matched.match.features)
    if alone:
        return ContourTools(calls, ())
    cutting = np.isin(path.motion, (Motion.LINE, Motion.ARC))
    words, first = np.unique(path.tool[cutting], return_index=True)
    firsts = zip(words.tolist(), np.flatnonzero(cutting)[first].tolist(), strict=True)
    by_word = {word: call for word, move in firsts if (call := of(move)) is not None}
    numbers = {call.number for call in calls if call is not None}
    others = sorted({call.number for call in by_word.values()} - numbers)
    return ContourTools(calls, tuple(others), _sharing(program, by_word, set(calls)))


def _sharing(program: Program, by_word: Mapping[int, Called], calls: Set[Called | None]) -> tuple[int, ...]:
    """The T words of several tools that cut with the contour's only offset: T0101 and T0201."""
    if not program.dialect.offset_in_t or len(calls) > 1:
        return ()
    words = sorted(word for word, call in by_word.items() if call in calls and word >= 100)
    return tuple(words) if len({word // 100 for word in words}) > 1 else ()
