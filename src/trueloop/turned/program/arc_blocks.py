"""New moves as blocks, written as the programmer wrote the arc block they replace."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.geometry.feature import Point
from trueloop.nc.edit.edit import circle_text, coordinate_text, rounded_mm
from trueloop.nc.expand.block import late_codes
from trueloop.nc.program.program import Block, Program, Word
from trueloop.nc.program.tool_path import CoordinateState
from trueloop.turned.compensation.moves import Move, within_quadrants

GEOMETRY = frozenset("XZUWIK")
"""The words of an arc block that new moves replace, beside its radius; feed and comments stay in the first block."""


@dataclass(frozen=True)
class ArcStyle:
    """The style of a program's arcs: with R or with I and K, with `G02` or `G2`."""

    program: Program
    state: CoordinateState
    by_radius: bool
    motion_digits: int

    def motion(self, move: Move) -> str:
        """Returns the G word of a move."""
        code = 1 if move.centre_mm is None else 2 if move.sweep_rad > 0 else 3
        return f"G{code:0{self.motion_digits}d}"

    def allowed(self, moves: Sequence[Move]) -> tuple[Move, ...]:
        """Returns the moves as the control takes them."""
        if self.by_radius and self.program.dialect.radius_within_quadrant:
            return tuple(piece for move in moves for piece in within_quadrants(move))
        return tuple(moves)

    def geometry(self, move: Move, start_mm: Point) -> list[str]:
        """Returns the end, and radius or centre from the (rounded) start: `X2.98 Z-1.46 R1.49`."""
        origin = start_mm if self.state.incremental else (0.0, 0.0)
        words = [self._text("X", move.end_mm[0] - origin[0]), self._text("Z", move.end_mm[1] - origin[1])]
        if move.centre_mm is None:
            return words
        start, centre = (np.array([x, 0.0, z]) for x, z in (start_mm, move.centre_mm))
        circle = circle_text(self.program, self.state, (0, 2), centre, start, by_radius=self.by_radius)
        return [*words, circle]

    def rounded(self, point: Point, start_mm: Point) -> Point:
        """Returns where the control takes the end of a move from `start_mm` to be."""
        origin = start_mm if self.state.incremental else (0.0, 0.0)
        x, z = (
            from_mm + rounded_mm(self.program.dialect, letter, value - from_mm, self.state)
            for letter, value, from_mm in zip("XZ", point, origin, strict=True)
        )
        return x, z

    def _text(self, letter: str, value_mm: float) -> str:
        return coordinate_text(self.program.dialect, letter, value_mm, self.state)


def style_of(program: Program, block: Block, state: CoordinateState) -> ArcStyle:
    """Reads the style off the block that is to be replaced."""
    motion = next((word for word in block.words if is_motion(word)), None)
    digits = len(motion.text) - 1 if motion is not None else 2
    letter = program.dialect.radius_letter
    return ArcStyle(program, state, any(word.letter == letter and _is_value(word) for word in block.words), digits)


def blocks_for(moves: Sequence[Move], start_mm: Point, block: Block, style: ArcStyle) -> list[str]:
    """Returns one text a move, without block numbers. The source block's other words go to the first, in their order.

    M codes that act after the move go to the last. Raises NC-EDIT where it is not known which a code is.
    """
    geometry = GEOMETRY | {style.program.dialect.radius_letter}
    kept = [word for word in block.data if not ((word.letter in geometry and _is_value(word)) or is_motion(word))]
    pieces = style.allowed(moves)
    late = late_codes(kept, block) if len(pieces) > 1 else []
    texts: list[str] = []
    for move in pieces:
        texts.append(" ".join([style.motion(move), *style.geometry(move, start_mm)]))
        start_mm = style.rounded(move.end_mm, start_mm)
    texts[0] = " ".join([texts[0], *(word.text for word in kept if word not in late)])
    texts[-1] = " ".join([texts[-1], *(word.text for word in late)])
    return texts


def is_motion(word: Word) -> bool:
    """Returns whether a word is one of G00 to G03."""
    return word.letter == "G" and word.kind == "number" and word.value in (0.0, 1.0, 2.0, 3.0)


def _is_value(word: Word) -> bool:
    """Of a parameter that is given a value the letter is the parameter's."""
    return word.kind != "assignment"
