"""Macros after each move (G66) and with arguments (G65), judged by a program that has them written out by hand."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from trueloop.nc.program.program import read_program

PARAMETERS = {"D": 7, "E": 8, "H": 11, "Q": 17}
"""Letters of arguments and the parameters that they become."""


@dataclass(frozen=True)
class Move:
    """A straight move: to a number, or to the parameter of an argument's letter."""

    code: str
    ends: tuple[tuple[str, int | str], ...]


@dataclass(frozen=True)
class Call:
    """G65, G66 or M98 of a program by its number, so often, with a value for every argument."""

    code: str
    number: int
    times: int
    arguments: tuple[int, ...]


END = "G67"
Block = Move | Call | str
Program = Sequence[Block]
Force = tuple[Call, ...]


def written(block: Block) -> str:
    if isinstance(block, Move):
        ends = (f"{axis}#{PARAMETERS[to]}" if isinstance(to, str) else f"{axis}{to}." for axis, to in block.ends)
        return f"{block.code} {' '.join(ends)}"
    if isinstance(block, Call):
        given = (f"{letter}{value}." for letter, value in zip(PARAMETERS, block.arguments, strict=True))
        values = "" if block.code == "M98" else " ".join(given)
        return f"{block.code} P{block.number} L{block.times} {values}"
    return block


def expanded(blocks: Program, force: Force, own: tuple[int, ...], programs: Sequence[Program]) -> Iterator[str]:
    """Its moves with numbers alone: after each those of the last macro in force, whose moves call the ones before."""
    values = dict(zip(PARAMETERS, own, strict=False))
    for block in blocks:
        if isinstance(block, Move):
            ends = (f"{axis}{values[to] if isinstance(to, str) else to}." for axis, to in block.ends)
            yield f"{block.code} {' '.join(ends)}"
            if force:
                yield from repeated(force[-1], force[:-1], force[-1].arguments, programs)
        elif isinstance(block, str):
            force = force[:-1]
        elif block.code == "G66":
            force = (*force, block)
        else:
            yield from repeated(block, force, own if block.code == "M98" else block.arguments, programs)


def repeated(call: Call, force: Force, own: tuple[int, ...], programs: Sequence[Program]) -> Iterator[str]:
    for _ in range(call.times):
        yield from expanded(programs[call.number - 2], force, own, programs)


numbers = st.integers(-9, 9)
arguments = st.tuples(*[numbers] * len(PARAMETERS))


def moves(ends: st.SearchStrategy[int | str]) -> st.SearchStrategy[Move]:
    axes = st.lists(st.sampled_from("XYZ"), min_size=1, max_size=3, unique=True)
    pairs = axes.flatmap(lambda axes: st.tuples(*[st.tuples(st.just(axis), ends) for axis in axes]))
    return st.builds(Move, st.sampled_from(["G00", "G01"]), pairs)


def calls(codes: Sequence[str], programs: Sequence[int]) -> st.SearchStrategy[Call]:
    return st.builds(Call, st.sampled_from(codes), st.sampled_from(programs), st.integers(1, 2), arguments)


macro_moves = moves(numbers | st.sampled_from(sorted(PARAMETERS)))
last = st.lists(macro_moves, min_size=1, max_size=2)
first = st.lists(macro_moves | calls(["G65"], [4]), min_size=1, max_size=3)
main = st.lists(moves(numbers) | calls(["G65", "G66"], [2, 3, 4]) | st.just(END), min_size=1, max_size=8)
bare = st.lists(moves(numbers), min_size=1, max_size=2)


@given(main, first, first, last, bare, st.integers(0, 8))
def test_the_path_is_that_of_the_program_written_out(
    main: list[Block], second: list[Block], third: list[Block], fourth: list[Block], plain: list[Block], at: int
) -> None:
    """Up to four macros in force; G65 and M98 beside them."""
    programs = [second, third, fourth, plain]
    main.insert(min(at, len(main)), Call("M98", 5, 1, ()))
    while sum(isinstance(block, Call) and block.code == "G66" for block in main) > 4:
        main.pop(next(i for i, block in enumerate(main) if isinstance(block, Call) and block.code == "G66"))
    lines = ["O1 G21 G90 G94 F100", *map(written, main), "M30"]
    for number, blocks in enumerate(programs, 2):
        lines += [f"O{number}", *map(written, blocks), "M99"]
    path = read_program("\n".join(lines).encode(), "fanuc-mill").run()
    plain_lines = ["G21 G90 G94 F100", *expanded(main, (), (), programs)]
    reference = read_program("\n".join(plain_lines).encode(), "fanuc-mill").run()
    assert path.motion.tolist() == reference.motion.tolist()
    np.testing.assert_array_equal(path.end_mm, reference.end_mm)
    assert path.findings == ()
