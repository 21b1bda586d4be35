"""M codes beside a move: which act after it, and so go along with its last block where it becomes several."""

from collections.abc import Sequence
from typing import Final

from trueloop.errors import Code, Place
from trueloop.nc.program.program import Block, Word

BEFORE_MOVE: Final = frozenset({3, 4, 6, 7, 8})
"""M codes that act before the move of their block, as far as controls agree: they stay in the first block."""

AFTER_MOVE: Final = frozenset({0, 1, 2, 5, 9, 30, 60, 98, 99})
"""M codes that stop, end or call after the move (M5 and M9 on most controls): they go to the last block."""


def late_codes(words: Sequence[Word], block: Block) -> list[Word]:
    """Returns the M codes that act after the move. Raises NC-EDIT for a code of which that is not known."""
    codes = [word for word in words if word.letter == "M" and word.kind != "assignment"]
    for word in codes:
        if word.value not in BEFORE_MOVE | AFTER_MOVE:
            raise Code.NC_EDIT.refusal(
                f"{word.text} stands in the block of a move that becomes several: whether it acts before or after the "
                "move is the control's affair",
                hint=f"put {word.text} into a block of its own",
                place=Place(line=block.index + 1),
            )
    return [word for word in codes if word.value in AFTER_MOVE]
