"""One block rewritten by its words: some changed, some left out, new ones put in; its comments and spaces stay."""

from collections.abc import Mapping, Sequence
from typing import Final

from trueloop.errors import Code
from trueloop.nc.edit.edit import Edit, insert_blocks_after
from trueloop.nc.program.late_codes import late_codes
from trueloop.nc.program.program import Block, Program, Word

COORDINATES: Final = frozenset("XYZUVW")
OUT: Final = ""
"""The text of a word that is left out."""


def rewritten(
    program: Program, block: Block, changed: Mapping[int, str], new: Sequence[str], more: Sequence[str]
) -> list[Edit]:
    """Returns edits of a block: the texts of `changed` words by index, `new` words, and `more` blocks after it.

    New words take the place of the first one left out, else they come after the coordinates. M codes that act after a
    move go to the last block. Raises NC-EDIT where it is not known which a code is, and in an optional block.
    """
    late = late_codes(block.data, block) if more else []
    texts = {word.index: changed.get(word.index, word.text) for word in block.data}
    texts |= dict.fromkeys((word.index for word in late), OUT)
    if new:
        place = _place(block, changed)
        texts[place.index] = " ".join(filter(None, [texts[place.index], *new]))
        if b" " in program.source[block.start : block.end] and program.source[place.start - 1 : place.start] != b" ":
            texts[place.index] = " " * (place.start > block.start) + texts[place.index]
    edits = _changes(program, block, texts)
    if more:
        last = " ".join([more[-1], *(word.text for word in late)])
        edits.append(insert_blocks_after(program, block.index, [*more[:-1], last]))
    if edits and block.skipped:
        raise Code.NC_EDIT.refusal(
            "an optional block would have to become several" if more else "an optional block would have to change",
            hint="take the slash away, or write the corner out as a block of its own",
            place=program.place(block.start),
        )
    return edits


def _place(block: Block, changed: Mapping[int, str]) -> Word:
    """The word at which new ones are written."""
    left_out = [word for word in block.data if changed.get(word.index) == OUT]
    coordinates = [word for word in block.data if word.letter in COORDINATES]
    return (left_out or coordinates[-1:] or list(block.data))[0]


def _changes(program: Program, block: Block, texts: Mapping[int, str]) -> list[Edit]:
    """An edit for each word that changes; one left out takes the space before it along."""
    edits = []
    for word in block.data:
        text = texts[word.index]
        if text == word.text:
            continue
        start = word.start
        while text == OUT and program.source[start - 1 : start] in (b" ", b"\t") and start > block.start:
            start -= 1
        edits.append(Edit(start, word.end, text))
    return edits
