"""Cycles that run on a contour kept elsewhere in the program: which one finishes it, and which ones rough it.

Copies of a contour that a cycle names: behind a subroutine, before a section between labels.

A contour of its own for the finishing cycle, so that correcting it does not change the roughing on the given one.

The blocks that roughing reads stay, to the byte. Where they lie between two numbered blocks (G70 P Q), the finishing
cycle is written out: the contour's blocks in its place, and the rapid move back to where it began. No control has to
find a second contour then, or to pass it over. Where the contour has a number or a name (LinuxCNC, Sinumerik, OSP), the
cycle gets a copy under one of its own.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import Final, Literal

import numpy as np

from trueloop.arrays import Integers
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import Edit, coordinate_text, line_ending
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import Motion, ToolPath

_BOTH: Final = range(9, 13)
_ROUGHS: Final = range(1, 5)
"""VARI of CYCLE95: those that rough, and those that finish after it."""
_VARI: Final = 8
_VARI_952: Final = 3
_FINISHING: Final = 2


@dataclass(frozen=True)
class ContourCycle:
    """A cycle and its contour: the block, its word, and what names the contour, as it compares.

    `by`: the contour lies between the blocks of two numbers (P, Q), is the subroutine of a number (Q of LinuxCNC), or
    has a name: a subprogram's, or two labels (Sinumerik); it may stand in an earlier block (CYCLE62).
    Or it has the sequence name of its first block (OSP), which is then `word`.
    """

    block: Block
    word: Word
    named: tuple[str, ...]
    roughs: bool
    finishes: bool
    by: Literal["numbers", "subroutine", "name", "earlier", "sequence"]


def finishing_cycle(program: Program, path: ToolPath, move: int) -> ContourCycle | None:
    """Returns the finishing cycle that runs the contour of a move; None of a move in the program's own course."""
    call = int(path.call[move])
    found = _cycle(program, program.block(int(path.calls[call, 0]))) if call >= 0 else None
    return found if found is not None and found.finishes else None


def roughing_cycles(program: Program) -> list[ContourCycle]:
    """Returns the cycles that rough a contour, without the blocks that only state how."""
    return [found for found in _cycles(program) if found.roughs]


def roughed_by(program: Program, cycle: ContourCycle) -> list[ContourCycle]:
    """Returns the roughing cycles on the contour that this finishing cycle runs; itself where it does both."""
    return [found for found in roughing_cycles(program) if found.named == cycle.named]


def _cycles(program: Program) -> Iterator[ContourCycle]:
    return (found for block in program.blocks if (found := _cycle(program, block)) is not None)


def _cycle(program: Program, block: Block) -> ContourCycle | None:
    for word in block.words:
        meaning = (program.core.meaning(word.index) or "") if word.letter == "G" or word.kind == "name" else ""
        finishes = meaning in ("FinishContour", "Profile(Finish)")
        if finishes or meaning.startswith(("RoughContour", "Profile")):
            letters = "Q" if meaning.startswith("Profile") else "PQ"
            named = tuple(other.text[1:].strip().lstrip("0") for other in block.words if other.letter in letters)
            by: Literal["numbers", "subroutine"] = "subroutine" if letters == "Q" else "numbers"
            if len(named) == len(letters):
                return ContourCycle(block=block, word=word, named=named, roughs=not finishes, finishes=finishes, by=by)
        if meaning.startswith(("Lap(Rough", "Lap(Finish")):
            return _lap(block, word, finishes=meaning == "Lap(Finish)")
        if meaning == "Removal(Stock)":
            # CYCLE95: its first argument names the contour, the ninth says what it does
            given = arguments(word)
            kind = given[_VARI].strip() if len(given) > _VARI else ""
            number = int(kind) if kind.isdigit() else 0
            name = given[0].strip().strip('"').lower()
            roughs, both = number in _ROUGHS or not number, number in _BOTH
            return ContourCycle(
                block=block, word=word, named=(name,), roughs=roughs or both, finishes=not roughs, by="name"
            )
        if meaning == "Removal(Contour)":
            return _contour_turning(program, block, word)
    return None


def _lap(block: Block, word: Word, *, finishes: bool) -> ContourCycle | None:
    """G85, G86, G87 of OSP: the sequence name behind the code."""
    behind = [other for other in block.words if other.start > word.start and other.letter == "N"]
    if not behind:
        return None
    return ContourCycle(
        block=block,
        word=behind[0],
        named=(behind[0].text[1:].lstrip("0").upper(),),
        roughs=not finishes,
        finishes=finishes,
        by="sequence",
    )


def _contour_turning(program: Program, block: Block, word: Word) -> ContourCycle:
    """CYCLE952: the last CYCLE62 names the contour, the tens of the fourth argument say what it does."""
    given = arguments(word)
    kind = given[_VARI_952].strip() if len(given) > _VARI_952 else ""
    finishes = kind.isdigit() and int(kind) // 10 % 10 == _FINISHING
    earlier = (other for before in program.blocks if before.index < block.index for other in before.words)
    names = [other for other in earlier if program.core.meaning(other.index) == "Removal(Names)"]
    named = tuple(arguments(names[-1])) if names else ()
    return ContourCycle(block=block, word=word, named=named, roughs=not finishes, finishes=finishes, by="earlier")


def arguments(word: Word) -> list[str]:
    """Returns the arguments in brackets behind a name, as they are written."""
    return word.text.partition("(")[2].rpartition(")")[0].split(",")


def require_named(program: Program, path: ToolPath, move: int, axis: int, letter: str) -> None:
    """Raises NC-EDIT where an axis would be written into a contour that roughing cycles share before it names the axis.

    The value would be that of the finishing cycle's beginning, and the roughing would go there, through the part.
    """
    cycle = finishing_cycle(program, path, move)
    if cycle is None or cycle.by != "subroutine" or not roughed_by(program, cycle):
        return
    own = (path.call[: move + 1] == path.call[move]) & (path.word[: move + 1, axis] >= 0)
    if not own.any():
        raise Code.NC_EDIT.refusal(
            f"{letter} is displaced on the contour before it names {letter}, and a roughing cycle begins it elsewhere",
            hint='name X and Z in the first block of the contour, or have `programs.roughing = "stays"`',
            place=program.place(program.block(int(path.block[move])).start),
        )


_O_WORD: Final = re.compile(r"o\s*(\d+)\s*(?=sub|endsub)", re.IGNORECASE)
_HEAD: Final = r"(?im)^%_N_{}_SPF"
_NEXT: Final = re.compile(r"(?m)^%")


def of_subroutine(program: Program, cycle: ContourCycle) -> list[Edit]:
    """Copies the O-word subroutine behind itself, and puts the number of the copy into the cycle."""
    name = next(word for word in cycle.block.data if word.letter == "Q")
    text = _text(program)
    ends = [found for found in _O_WORD.finditer(text) if float(found[1]) == name.value]
    if len(ends) != 2:
        raise refusal(program, cycle.block, f"this cycle, whose subroutine {name.text} is not there once,")
    taken = {int(found) for found in re.findall(r"(?i)\bo\s*(\d+)", text)}
    number = next(number for number in count(int(name.value) + 1) if number not in taken)
    first, last = (program.block(program.source.count(b"\n", 0, found.start())) for found in ends)
    copy = _O_WORD.sub(lambda found: found[0].replace(found[1], str(number)), text[first.start : last.end])
    copy = _unnumbered(copy)
    return [Edit(name.value_start, name.end, str(number)), Edit(last.end, last.end, line_ending(program) + copy)]


def of_name(program: Program, cycle: ContourCycle) -> list[Edit]:
    """Copies the subprogram behind itself, or the section before itself, under a name that the cycle then calls."""
    given = re.search(r'"([^"]*)"', cycle.word.text)
    if given is None or cycle.block.skipped:
        raise refusal(program, cycle.block, "this cycle, a block with a slash or one that computes its contour's name,")
    names = given[1].split(":")
    ending = next(f"_{k}" for k in count(2) if not any(_mentions(program, f"{name}_{k}") for name in names))
    at = cycle.word.start + given.start(1)
    call = Edit(at, at + len(given[1]), ":".join(f"{name}{ending}" for name in names))
    copied = _section(program, names, ending) if len(names) == 2 else _subprogram(program, names[0], ending)
    if copied is None:
        raise refusal(program, cycle.block, f"this cycle, whose contour {given[1]} is not there once,")
    return [call, copied]


def of_sequence(program: Program, cycle: ContourCycle) -> list[Edit]:
    """Copies the definition behind itself, under another sequence name: in its course a program passes both over."""
    name = cycle.named[0]
    first = [block for block in program.blocks if _is_called(block, name) and _begins(program, block)]
    ends = [block for block in program.blocks if first and block.index > first[0].index and _ends(program, block)]
    if len(first) != 1 or not ends or cycle.block.skipped:
        raise refusal(program, cycle.block, f"this cycle, whose contour {cycle.word.text} is not there once,")
    names = {word.text.upper() for block in program.blocks for word in block.words if word.letter == "N"}
    other = next(text for k in count(1) if (text := f"NLAP{k}") not in names)
    label = first[0].words[0]
    copy = _unnumbered(_text(program)[label.end : ends[0].end])
    return [
        Edit(cycle.word.start, cycle.word.end, other),
        Edit(ends[0].end, ends[0].end, line_ending(program) + other + copy),
    ]


def _is_called(block: Block, name: str) -> bool:
    first = block.words[0] if block.words else None
    return first is not None and first.letter == "N" and first.text[1:].lstrip("0").upper() == name


def _begins(program: Program, block: Block) -> bool:
    return any((program.core.meaning(word.index) or "").startswith("Lap(B") for word in block.words)


def _ends(program: Program, block: Block) -> bool:
    return any(program.core.meaning(word.index) == "Lap(End)" for word in block.words)


def _section(program: Program, names: list[str], ending: str) -> Edit | None:
    """Before the section, behind the jump that leads past it: where that is not run, neither is the copy."""
    blocks = [list(_labelled(program, name)) for name in names]
    if any(len(found) != 1 for found in blocks):
        return None
    first, last = (found[0] for found in blocks)
    copy = _text(program)[first.start : last.end]
    for name in names:
        copy = re.sub(rf"(?im)^((?:N\d+\s+)?{re.escape(name)})(?=\s*:)", rf"\1{ending}", copy)
    return Edit(first.start, first.start, _unnumbered(copy) + line_ending(program))


def _subprogram(program: Program, name: str, ending: str) -> Edit | None:
    text = _text(program)
    heads = list(re.finditer(_HEAD.format(re.escape(name)), text))
    if len(heads) != 1:
        return None
    after = _NEXT.search(text, heads[0].end())
    end = after.start() if after else len(text)
    body = text[heads[0].start() : end]
    head = heads[0][0][: -len("_SPF")] + ending + heads[0][0][-len("_SPF") :]
    copy = head + body[len(heads[0][0]) :]
    space = "" if body.endswith("\n") else line_ending(program)
    return Edit(end, end, space + copy)


def _labelled(program: Program, name: str) -> Iterator[Block]:
    for block in program.blocks:
        labels = [word.text.rstrip().rstrip(":").rstrip() for word in block.words if word.kind == "label"]
        if any(label.lower() == name.lower() for label in labels):
            yield block


def _mentions(program: Program, name: str) -> bool:
    return re.search(rf"(?i)(?<![A-Z0-9]){re.escape(name)}(?![A-Z0-9_])", _text(program)) is not None


def _unnumbered(text: str) -> str:
    """A copy of blocks without their numbers, which the program has already."""
    return re.sub(r"(?im)^([ \t]*)N\d+[ \t]*", r"\1", text)


def _text(program: Program) -> str:
    return program.source.decode("latin-1")


def refusal(program: Program, cycle: Block, what: str) -> TrueloopError:
    """Returns the refusal where a finishing cycle gets no contour of its own."""
    return Code.NC_EDIT.refusal(
        f"roughing shall stay where it is, and {what} cannot be given a contour of its own",
        hint='have the roughing move along: `programs.roughing = "moves"`',
        place=program.place(cycle.start),
    )


def own_contour(program: Program, path: ToolPath, move: int) -> list[Edit]:
    """Returns the edits by which no roughing cycle reads the blocks of the contour of `move`. Raises NC-EDIT."""
    cycle = finishing_cycle(program, path, move)
    if cycle is None or not roughed_by(program, cycle):
        return []
    if cycle.roughs or cycle.by == "earlier":
        raise refusal(program, cycle.block, "this cycle, which roughs too or takes its contour from an earlier block,")
    if cycle.by == "numbers":
        # Writes the contour in the place of the cycle's words; the block's other words come first
        block, moves = cycle.block, np.flatnonzero(path.call == int(path.call[move]))
        contour = [program.block(index) for index in _between(program, path, block, moves[[0, -1]])]
        blocks = [_without(program, one, _number_of(one)) for one in contour]
        own = [word for word in block.data if word.letter in "PQ" or word == cycle.word]
        others = _without(program, block, [*_number_of(block), *own])
        lines = [*([others] if re.search(r"\w", others) else []), *blocks, *_way_back(program, path, int(moves[-1]))]
        return [Edit(block.data[0].start, block.end, line_ending(program).join(lines))]
    copies = {"subroutine": of_subroutine, "name": of_name, "sequence": of_sequence}
    return copies[cycle.by](program, cycle)


def _between(program: Program, path: ToolPath, cycle: Block, moves: Integers) -> range:
    """Returns the blocks from P to Q: of those with these numbers the ones next to the contour (first, last)."""
    named = {word.letter: word.value for word in cycle.data if word.letter in "PQ"}
    first = [b.index for b in program.blocks if b.number == named["P"] and b.index <= path.block[moves[0]]]
    last = [b.index for b in program.blocks if b.number == named["Q"] and b.index >= path.block[moves[1]]]
    if cycle.skipped or not (first and last):
        raise refusal(program, cycle, "this cycle, a block with a slash or one that computes P or Q,")
    return range(first[-1], last[0] + 1)


def _number_of(block: Block) -> list[Word]:
    return [word for word in block.words if word.letter == "N"]


def _without(program: Program, block: Block, words: list[Word]) -> str:
    """Returns the text of a block without some of its words."""
    done, text = block.start, ""
    for word in words:
        text, done = text + program.source[done : word.start].decode("latin-1").rstrip(" \t"), word.end
    return (text + program.source[done : block.end].decode("latin-1")).strip(" \t\r")


def _way_back(program: Program, path: ToolPath, last: int) -> list[str]:
    """Returns the cycle's last move, which no word sets."""
    back = last + 1
    if back == len(path) or path.block[back] != path.block[last] or path.motion[back] != Motion.RAPID:
        return []
    state = path.coordinate_state(back)
    from_mm = path.start_mm[back] if state.incremental else np.zeros(3)
    ends = zip("XZ", (path.end_mm[back] - from_mm)[[0, 2]], strict=True)
    return [" ".join(["G00", *(coordinate_text(program.dialect, axis, float(end), state) for axis, end in ends)])]
