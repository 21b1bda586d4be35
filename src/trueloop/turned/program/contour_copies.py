"""Copies of a contour that a cycle names: behind a subroutine, before a section between labels."""

import re
from collections.abc import Iterator
from itertools import count
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import Edit, line_ending
from trueloop.nc.program.program import Block, Program
from trueloop.turned.program.contour_cycles import ContourCycle

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
    first, last = (_line_at(program, found.start()) for found in ends)
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


def _line_at(program: Program, at: int) -> Block:
    return program.block(program.source.count(b"\n", 0, at))


def refusal(program: Program, cycle: Block, what: str) -> TrueloopError:
    """Returns the refusal where a finishing cycle gets no contour of its own."""
    return Code.NC_EDIT.refusal(
        f"roughing shall stay where it is, and {what} cannot be given a contour of its own",
        hint='have the roughing move along: `programs.roughing = "moves"`',
        place=program.place(cycle.start),
    )
