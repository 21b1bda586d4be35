"""Milling cutters whose edge is a torus: ball end, bull nose, flat end; where they touch a surface, and how deep.

The tool's tip (x, y, z of the program) lies on its axis at the lowest point. A ball-end cutter is the torus without a
ring, a flat one that without a corner.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.geometry.surface import Feet, Surface, closest
from trueloop.nc.program.program import Program, Word
from trueloop.nc.program.tool_path import ToolPath

VECTOR: Final = "IJK"
ROTARY: Final = "ABC"
DECIMALS: Final = {"vector": 6, "angle": 4}
STILL: Final = 1e-9


@dataclass(frozen=True, eq=False)
class ToolAxes:
    """Values of the words `letters` at the starts and ends of the moves, (n, k): degrees, or the parts of a vector.

    Without letters the axis is `fixed`. `unsaid` (n,): moves before all words were said once. `decimals` of new words.
    """

    letters: str
    start: Array
    end: Array
    fixed: Array
    unsaid: np.ndarray
    decimals: int = 0

    def values(self, move: np.ndarray, share: Array) -> Array:
        """The words' values on the way through moves (m,), at shares 0 to 1 of them."""
        return np.asarray(self.start[move] + share[:, None] * (self.end - self.start)[move])

    def directions(self, move: np.ndarray, share: Array) -> Array:
        """Unit vectors out of the material (m, 3)."""
        values = self.values(move, share)
        if not self.letters:
            return np.tile(self.fixed, (len(move), 1))
        if self.letters == VECTOR:
            return np.asarray(values / np.linalg.norm(values, axis=1, keepdims=True))
        directions = np.tile([0.0, 0.0, 1.0], (len(move), 1))
        for letter, angle in reversed(list(zip(self.letters, np.radians(values).T, strict=True))):
            directions = _turned(directions, ROTARY.index(letter), angle)
        return directions

    def turned_deg(self, move: np.ndarray) -> Array:
        """By how much at most the tool turns on its way through each of the moves."""
        if self.letters != VECTOR:
            return np.asarray(np.sum(np.abs(self.end - self.start)[move], axis=1))
        first, last = (self.directions(move, np.full(len(move), share)) for share in (0.0, 1.0))
        return np.asarray(np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(last - first, axis=1) / 2, 0.0, 1.0))))

    def text(self, move: int, share: float) -> str:
        """The words at a point within a move, with a space before each."""
        values = self.values(np.array([move]), np.array([share]))[0]
        return "".join(
            f" {name}{value:.{self.decimals}f}" for name, value in zip(self.letters, values + 0.0, strict=True)
        )


def tool_axes(program: Program, path: ToolPath, letters: str, fixed: tuple[float, float, float]) -> ToolAxes:
    """The tool's direction along the path. `letters`: the rotary axes from workpiece to tool ("CA"), "IJK", or none.

    Raises SRF-PROGRAM for rotary words that are not named, computed ones, and blocks run again.
    """
    axis = np.asarray(fixed) / np.linalg.norm(fixed)
    words = [word for found in _words(program, ROTARY).values() for word in found if word.letter not in letters]
    straight = bool(letters) or axis[2] == 1.0
    if words and letters != VECTOR and not all(abs(w.value - words[0].value * (not straight)) <= STILL for w in words):
        raise _refused(program, words[0], "turns the tool, and nothing says how", "name the axes in cutter.rotary")
    if not letters:
        none = np.zeros((len(path), 0))
        return ToolAxes("", none, none, axis, np.zeros(len(path), bool))
    return _followed(program, path, _words(program, letters), letters)


def check_tool_axes(program: Program, path: ToolPath, axes: ToolAxes, cutting: np.ndarray) -> None:
    """Refuses cutting moves (m,) whose direction was not said or jumps."""
    if not axes.letters:
        return
    after = cutting[cutting > 0]
    jumped = np.max(np.abs(axes.start[after] - axes.end[after - 1]), axis=1) > STILL
    for wrong, what, hint in (
        (cutting[axes.unsaid[cutting]], "cuts before the tool's direction was said", "say it in a block before"),
        (after[jumped], "is cut after the tool turned where it stood", "turn the tool clear of the part"),
    ):
        if len(wrong):
            block = program.block(int(path.block[wrong[0]]))
            message = f"this block {what}: {len(wrong)} of {len(cutting)} cutting moves"
            raise Code.SRF_PROGRAM.refusal(message, hint=hint, place=program.place(block.start))


def _words(program: Program, letters: str) -> dict[int, list[Word]]:
    """The words of these letters by block; a name or an unknown text, whose letter is empty, is not among them."""
    named = frozenset(letters)
    blocks = ((block.index, block) for block in program.blocks if not block.skipped)
    found = {index: [word for word in block.words if word.letter in named] for index, block in blocks}
    return {index: words for index, words in found.items() if words}


def _followed(program: Program, path: ToolPath, words: dict[int, list[Word]], letters: str) -> ToolAxes:
    """Words stay in force until the next of their letter; before the first the tool stands straight up."""
    if np.any(np.diff(path.block) < 0):
        raise Code.SRF_PROGRAM.refusal(
            f"blocks with {letters} words are run again or out of order: {len(path)} moves",
            hint="write the pass without loops and subprograms",
            place=Place(program.file),
        )
    up = [0.0, 0.0, 1.0] if letters == VECTOR else [0.0] * len(letters)
    held, said, waiting = dict(zip(letters, up, strict=True)), set[str](), sorted(words, reverse=True)
    start, end, unsaid = np.empty((len(path), len(letters))), np.empty((len(path), len(letters))), []
    for move, block in enumerate(path.block.tolist()):
        while waiting and waiting[-1] < block:
            held |= _said(program, words[waiting.pop()])
        start[move] = list(held.values())
        if waiting and waiting[-1] == block:
            found = _said(program, words[waiting.pop()])
            held |= found
            said |= found.keys()
        end[move] = list(held.values())
        unsaid.append(len(said) < len(letters))
    return ToolAxes(
        letters=letters,
        start=start,
        end=end,
        fixed=np.array([0.0, 0.0, 1.0]),
        unsaid=np.array(unsaid, bool),
        decimals=_decimals(words, letters),
    )


def _decimals(words: dict[int, list[Word]], letters: str) -> int:
    """No fewer than the program's own words have."""
    own = (len(word.text.partition(".")[2].strip()) for found in words.values() for word in found)
    return max(DECIMALS["vector" if letters == VECTOR else "angle"], *own, 0)


def _said(program: Program, words: list[Word]) -> dict[str, float]:
    for word in words:
        if word.kind != "number":
            raise _refused(program, word, "is computed", "write it as a number")
    return {word.letter: word.value for word in words}


def _refused(program: Program, word: Word, what: str, hint: str) -> TrueloopError:
    return Code.SRF_PROGRAM.refusal(f"{word.text} {what}", hint=hint, place=program.place(word.start))


def _turned(vectors: Array, axis: int, angle: Array) -> Array:
    """Vectors turned right-handed about a coordinate axis."""
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turned = vectors.copy()
    turned[:, a] = np.cos(angle) * vectors[:, a] - np.sin(angle) * vectors[:, b]
    turned[:, b] = np.sin(angle) * vectors[:, a] + np.cos(angle) * vectors[:, b]
    return turned


ROUNDS: Final = 40
STILL_MM: Final = 1e-10


@dataclass(frozen=True)
class Cutter:
    """`radius_mm` of the tool, `corner_mm` of its edge: equal for a ball end, zero for a flat end."""

    radius_mm: float
    corner_mm: float

    def __post_init__(self) -> None:
        if not 0 <= self.corner_mm <= self.radius_mm or not self.radius_mm > 0:
            raise Code.SRF_CUTTER.refusal(
                f"a cutter of radius {self.radius_mm} mm with corners of {self.corner_mm} mm",
                hint="the corner radius is between 0 (flat end) and the tool's radius (ball end)",
                values={"radius_mm": self.radius_mm, "corner_mm": self.corner_mm},
            )

    @property
    def ring_mm(self) -> float:
        """Radius of the circle on which the corner's centre runs."""
        return self.radius_mm - self.corner_mm


@dataclass(frozen=True, eq=False)
class Contacts:
    """Where the cutter comes nearest to a surface: feet, and the gap there (negative: into the material), in mm."""

    feet: Feet
    gap_mm: Array


def contacts(
    surface: Surface, cutter: Cutter, tips_mm: Array, axes: Array, near: tuple[Array, Array] | None = None
) -> Contacts:
    """Contacts of a cutter with its tip at (n, 3) and its axis along unit vectors (n, 3), out of the material.

    The point of the corner's circle nearest to the surface is where the surface's normal leans away from the axis:
    q = tip + r a − (R − r) h with h the normal's part across the axis, found by iterating foot and lean. Where the
    normal is the axis, the whole circle is equally near, and the centre is taken.
    """
    centres = tips_mm + cutter.corner_mm * axes
    if cutter.ring_mm == 0:
        feet = closest(surface, centres, near)
        return Contacts(feet, feet.distance_mm - cutter.corner_mm)
    points = centres
    for _ in range(ROUNDS):
        feet = closest(surface, points, near)
        near = (feet.u, feet.v)
        across = feet.normal - np.sum(feet.normal * axes, axis=1, keepdims=True) * axes
        length = np.linalg.norm(across, axis=1, keepdims=True)
        moved = centres - cutter.ring_mm * np.asarray(np.where(length > 1e-9, across / np.maximum(length, 1e-300), 0.0))
        step = float(np.max(np.abs(moved - points), initial=0.0))
        points = moved
        if step < STILL_MM:
            break
    feet = closest(surface, points, near)
    return Contacts(feet, feet.distance_mm - cutter.corner_mm)


def edge_centres_mm(cutter: Cutter, tips_mm: Array, axes: Array, count: int) -> Iterator[Array]:
    """The corner's centre at so many places around the edge, (n, 3) each; none for a ball end, which has no ring."""
    if cutter.ring_mm == 0:
        return
    aside = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    first = np.cross(axes, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axes, first)
    for angle in np.linspace(0.0, 2 * np.pi, count, endpoint=False):
        yield tips_mm + cutter.corner_mm * axes + cutter.ring_mm * (np.cos(angle) * first + np.sin(angle) * second)
