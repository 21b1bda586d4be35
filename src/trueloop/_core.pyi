"""The Rust core, as Python sees it. Checked against the built module by a test."""

from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

# curve-fit: constrained splines

class CurveFitError(ValueError):
    """A fit was refused: arguments are the kind, a message and where points are missing (from, to) or None."""

def fit_spline(
    points: NDArray[np.float64],
    values: NDArray[np.float64],
    weights: NDArray[np.float64] | None,
    interior_knots: NDArray[np.float64],
    length: float,
    degree: int,
    ends: tuple[float | None, float | None, float | None, float | None],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Least-squares spline with end conditions: (coefficients, covariance band, sensitivity, residuals, leverages)."""

def spline_basis(
    points: NDArray[np.float64],
    interior_knots: NDArray[np.float64],
    length: float,
    degree: int,
    lower: float,
    upper: float,
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Basis functions that differ from zero at each point: (index of the first, values, slopes)."""

# nc-program: NC programs

def nc_dialects() -> list[
    tuple[str, float, float, str, str, str, str, bool, list[list[float]], str, list[tuple[int, str]]]
]:
    """Each dialect: name, resolution in inch and in mm, opening and closing of a comment, opening bracket of
    expressions, address of a radius, whether a tapered thread's lead counts along it, and by the numbers 0 to 9 of tip
    orientations where the tip of a nose of radius 1 lies from its centre, (x, z).
    """

@final
class NcProgram:
    """A program as read. Raises ValueError (no such dialect), OverflowError (2 GiB or more)."""

    def __new__(cls, source: bytes, dialect: str) -> NcProgram: ...
    @property
    def block_count(self) -> int: ...
    def source(self) -> bytes: ...
    def new_lines(self, block: int, texts: list[bytes]) -> bytes:
        """Blocks after one, each on its line: N0420 is followed by N0421, N0422 …; without numbers where they do not
        fit before the next number, another block has one of them, or the program has none.
        """

    def moved(self, word: int, by: float, step: float, comma: bool) -> tuple[int, int, str, float] | None:
        """A word that sets so much more, in program units and steps of that size: start, end and text of its value, and
        by how much it is changed as written; None where that rounds to nothing. A ValueError has message and hint.
        """

    def inserted(self, block: int, word: str) -> tuple[int, str]:
        """The byte at which a word that a block has not is written into it, and its text with the space beside it."""

    def block(self, index: int) -> tuple[int, int, int, int, bool, bool]:
        """Start, end, first word, one past the last word, optional, tape mark."""

    def word(self, index: int) -> tuple[str, int, int, int, str, float, int, bool | None]:
        """Letter, start, end, start of the value, kind, value, block, whether it says to be an increment."""

    def meaning(self, index: int) -> str | None:
        """What a code does (`Dwell`, `MEnd`); None where the word is no code that the dialect knows."""

    def block_at(self, offset: int) -> int: ...
    def findings(self) -> list[tuple[str, str, str, str, int, str]]:
        """Severity, code, message, hint, byte offset."""

    def parameters_used(self) -> list[tuple[str, int]]: ...
    def offset_statements(self) -> list[tuple[int, str, float, int, int, int]]:
        """Tool, axis, value, start and end of the value, word."""

    def run(
        self,
        parameters: list[tuple[str, float]],
        optional_blocks: bool,
        position: tuple[float, float, float],
        block_limit: int,
        inch: bool | None = None,
        diameter: bool | None = None,
        plane: int | None = None,
        tools: list[
            tuple[int | None, float, int | None, float | None, tuple[float, float, float] | None, int | None]
        ] = ...,
        trace: bool = ...,
        work_offsets: list[tuple[int, tuple[float, float, float]]] = ...,
        roughing: bool = ...,
        placed: bool = ...,
        roughed_contours: bool = ...,
    ) -> tuple[
        dict[str, NDArray[Any]],
        dict[str, NDArray[Any]],
        list[tuple[str, str, str, str, int, str]],
        tuple[int, bool] | None,
    ]:
        """Columns of the moves, columns of the modal states, findings; the block that states the unit before any
        length, and whether it is the inch.
        """

@final
class NcSession:
    """A run in parts, of a program of which no part jumps."""

    def __new__(
        cls,
        dialect: str,
        parameters: list[tuple[str, float]],
        optional_blocks: bool,
        work_offsets: list[tuple[int, tuple[float, float, float]]],
        inch: bool | None,
        rotary: str,
    ) -> NcSession: ...
    def run(
        self, part: NcProgram, until: int
    ) -> tuple[
        dict[str, NDArray[Any]],
        dict[str, NDArray[Any]],
        list[tuple[str, str, str, str, int, str]],
        tuple[int, bool] | None,
    ]:
        """Runs the blocks of the next part before `until`, as `NcProgram.run` does; what is after them is looked at."""

def nc_part(part: NcProgram) -> tuple[bool, str]:
    """Whether a block of a part may send the run elsewhere, and the letters of the rotary axes that it names."""

# nc-map: a field applied to a program

def nc_survey(
    source: bytes, dialect: str
) -> tuple[
    int,
    bool,
    tuple[bool, bool, bool],
    list[tuple[str, int]],
    tuple[int | None, int | None, int | None, int | None],
    bool,
    int,
    str,
]:
    """Of whole lines: the number of blocks, whether one may send its run elsewhere (a loop, a call, a contour by
    number), which of X, Y and Z are named, the block in which each letter is first met, and those that first set an
    offset by G10, first set the position register, first go to a place of the machine, and first make a spline or a
    tangent arc; whether decimal commas are written; how many decimals coordinates have; the letters of rotary axes.
    """

def nc_mentions(text: bytes, word: bytes) -> bool:
    """Whether a word of ASCII letters stands in a text, in capitals or not."""

def nc_writes_comma(program: NcProgram) -> bool:
    """Whether a program of Klartext writes decimal commas."""

def nc_written_decimals(program: NcProgram) -> int:
    """How many decimals the coordinates of a program have, nine at most."""

def nc_number(value: float, step: float, dialect: str, comma: bool) -> tuple[str, float]:
    """A number of program units as one that is new, in steps of that size, and the value that it then has. Raises
    ValueError, with message and hint, beyond what a control could go to.
    """

def nc_restyled(old: bytes, value: float, step: float, dialect: str, comma: bool) -> str:
    """The same in the style of an old one: its sign habit, leading zeros, and at least as many decimals."""

def nc_circle(
    axes: tuple[int, int],
    centre_mm: Sequence[float],
    start_mm: Sequence[float],
    by_radius: bool,
    unit_mm: float,
    step: float,
    dialect: str,
    comma: bool,
    end_mm: Sequence[float] | None = None,
) -> str:
    """The words of an arc's circle in the plane of two axes: its radius, or its centre from the start.

    With an end the centre is moved along the chord to be as far from both ends.
    """

def nc_rows(
    columns: Sequence[tuple[NDArray[np.float64], int] | tuple[NDArray[np.uint32], Sequence[str]]], first: int, last: int
) -> str:
    """Rows of a table from `first` to before `last`, a line each, cells parted by commas.

    A column is numbers with the decimals that they are rounded to, trailing zeros left out, NaN an empty cell; or
    indices into names. Arrays are contiguous.
    """

def nc_said(
    program: NcProgram,
    block: NDArray[np.int32],
    word: NDArray[np.int32],
    incremental: NDArray[np.bool_],
    renamed: NDArray[np.uint32],
    plane: NDArray[np.uint8],
) -> NDArray[np.bool_]:
    """Whether X, Y, Z stand where the program said, after each move (n, 3): from its block (n,), the words that set its
    end (n, 3), whether its coordinates are increments (n,), how often each axis was renamed (n, 3), and its plane (n,).
    """

@final
class NcField:
    """A displacement for every position, mm."""

    @staticmethod
    def affine(matrix: Sequence[Sequence[float]], shift: Sequence[float]) -> NcField:
        """Takes p to matrix·p + shift."""

    @staticmethod
    def grid(x: Sequence[float], y: Sequence[float], z: Sequence[float], displacement: NDArray[np.float64]) -> NcField:
        """Linear between nodes; displacements (n, 3) with z fastest. Raises ValueError where they do not fit."""

    @staticmethod
    def function(
        function: Callable[..., NDArray[np.float64]], knows_travel: bool | None = None, follows: str = ""
    ) -> NcField:
        """Positions (n, 3) to displacements (n, 3). With `knows_travel` given the function gets work offsets (n,),
        tools (n,), the way of travel (n, 3), tool offsets (n, 3) and places of A, B, C (n, 3) too; True: it differs by
        that way. `follows` are the rotary axes with whose places it differs.
        """

    def displacements(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """At (n, 3) positions. Raises ValueError with the index of a point outside."""

@final
class NcMapper:
    """A field on its way through a program. Raises ValueError with the name of a parameter that is none."""

    def __new__(
        cls,
        field: NcField,
        dialect: str,
        parameters: list[tuple[str, float]],
        optional_blocks: bool,
        whole: bool,
        named: tuple[bool, bool, bool],
        comma: bool,
        tolerance_mm: float,
        size_mm: float,
        slope: float,
        tools: list[tuple[int | None, float, int | None, float | None, tuple[float, float, float] | None, int | None]],
        work_offsets: list[tuple[int, tuple[float, float, float]]],
        inch: bool | None,
        rotary: str,
        decimals: int,
    ) -> NcMapper: ...
    @property
    def failed_at(self) -> tuple[int, int]:
        """Line and column at which the field's own function failed."""

    def push(self, bytes: bytes) -> tuple[bytes, tuple[str, str, str, int, int] | None]:
        """What the next bytes give; code, message, hint, line, column of what it is refused for."""

    def finish(self) -> tuple[bytes, tuple[str, str, str, int, int] | None]: ...
    def gather(self) -> None:
        """Has all refusals gathered instead of ending at the first; nothing is written then."""

    def obstacles(self) -> list[tuple[tuple[str, str, str, int, int], BaseException | None]]:
        """Those gathered: code, message, hint, line, column, and what the field's own function raised."""

    def summary(self) -> tuple[int, int, int, int, tuple[float, float, float], int, int, int, tuple[int, bool] | None]:
        """Blocks, moves, edits, blocks added, largest displacement, blocks not run, line of the first, line at which a
        roughed contour turns back; the line that states the unit before any length, and whether it is the inch.
        """

# envelope: the surface that a swept nose leaves

@final
class NoseSweep:
    """A nose swept along a polyline of its centre (n, 2), x a radius, mm.

    Its radius error over contact angle is a cubic a piece (m, 4), pieces `step` rad wide from `first` on, constant
    beyond; no pieces: round. Raises ValueError for a nose that is not convex and for points that are no finite numbers.
    """

    def __new__(
        cls, nodes: NDArray[np.float64], radius: float, first: float, step: float, pieces: NDArray[np.float64]
    ) -> NoseSweep: ...
    def entries(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64], known: NDArray[np.float64], reach: float
    ) -> NDArray[np.float64]:
        """Where rays out of the material first meet the swept region, (q,): −reach to `known`, (q,) (nothing lower)."""

@final
class CutterSweep:
    """A cutter's end swept along a polyline of the middle of its ring, (n, 3), mm.

    It is all within `corner` of a disc of radius `ring` across the axis, a ball without a ring. `axes`: unit vectors
    out of the material, (1, 3), or (n, 3) where it turns. ValueError for what is none, or no finite number.
    """

    def __new__(
        cls, nodes: NDArray[np.float64], ring: float, corner: float, axes: NDArray[np.float64]
    ) -> CutterSweep: ...
    def entries(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64], known: NDArray[np.float64], reach: float
    ) -> NDArray[np.float64]:
        """Where rays out of the material first meet the swept region, (q,): −reach to `known`, (q,) (nothing lower)."""

# surface-fit and spatial: splines over a grid, sums over pairs of points

def fit_surface_grid(
    knots: tuple[NDArray[np.float64], NDArray[np.float64]],
    degrees: tuple[int, int],
    at: tuple[NDArray[np.float64], NDArray[np.float64]],
    values: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Least-squares tensor-product spline on a grid of [0, 1] × [0, 1]: its coefficients. ValueError when refused."""

@final
class ScatteredSplines:
    """Tensor-product splines at n points anywhere on [0, 1] × [0, 1]: products with the design matrix A (n, m).

    It is never formed. `knots` are the inner ones, degrees at most 3. ValueError when refused.
    """

    def __new__(
        cls,
        knots: tuple[NDArray[np.float64], NDArray[np.float64]],
        degrees: tuple[int, int],
        at: tuple[NDArray[np.float64], NDArray[np.float64]],
    ) -> ScatteredSplines: ...
    def normal(self) -> NDArray[np.float64]:
        """AᵀA (m, m)."""

    def sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """AᵀV (m, k) for values (n, k)."""

    def combined(self, factors: NDArray[np.float64]) -> NDArray[np.float64]:
        """A F (n, k) for factors (m, k)."""

    def squares(self, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of every row a of A: a M aᵀ (n,), for a matrix (m, m)."""

def pair_sums(
    points: NDArray[np.float64], values: NDArray[np.float64], exponent: float, nearest: float
) -> tuple[float, float]:
    """Sums over ordered pairs with c = max(d, nearest)^-exponent: of c and of c zᵢzⱼ. ValueError when refused.

    With nearest 0, coincident points have no weight.
    """

def weights_product(
    points: NDArray[np.float64],
    vectors: NDArray[np.float64],
    exponent: float,
    nearest: float,
    digits: float | None = None,
) -> NDArray[np.float64]:
    """The matrix of the weights, zeros on its diagonal, times vectors (n, p): every pair worked off, or those far from
    each other together, to about so many digits. ValueError when refused.
    """

# nurbs: closest points of a B-spline patch

@final
class NurbsPatch:
    """A patch by degrees, clamped knots and control points (n, m, 4): (w x, w y, w z, w). ValueError if it is none."""

    def __new__(
        cls,
        degrees: tuple[int, int],
        knots: tuple[NDArray[np.float64], NDArray[np.float64]],
        control: NDArray[np.float64],
    ) -> NurbsPatch: ...
    def feet(
        self, points: NDArray[np.float64], near: NDArray[np.float64] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Closest points of points (n, 3): parameters (n, 2), places, and derivatives by u and by v, (n, 3) each.

        `near`: parameters (n, 2) to start from, downhill; without them the nearest of the whole patch. ValueError for
        what is no finite number.
        """

# error-eval: machine models

@final
class MachineEvaluator:
    """A compiled machine model: bodies (axis, breaks, powers, rows, arm, carries) and slopes of axes."""

    def __new__(
        cls,
        bodies: list[tuple[int, list[float], int, list[list[float]], list[float], list[float]]],
        slope: list[list[float]],
    ) -> MachineEvaluator: ...
    def error(
        self, positions: NDArray[np.float64], travel: NDArray[np.float64] | None, threads: int
    ) -> NDArray[np.float64]:
        """E (n, 3) at positions (n, 3); travel (n, 3) +1, −1 or 0, or None. On up to `threads` threads."""

# rtec: the real-time corrector

class RealTimeRefusalError(ValueError):
    """Bytes that are no image: arguments are the number, the name and the meaning."""

@final
class RealTimeCore:
    """An image and what a corrector remembers, from one call to the next; mm, s, X of a lathe a radius."""

    def __new__(cls, image: bytes, serial: str | None = None, program: bytes | None = None) -> RealTimeCore:
        """Raises RealTimeRefusalError; `serial` and the content of `program` are compared where they are given."""

    @property
    def signals(self) -> int:
        """Signals that the image needs."""

    def step(self, inputs: dict[str, Any], settings: dict[str, float]) -> dict[str, NDArray[Any]]:
        """One period after the other; the columns of `inputs` and what comes back are named as in rtec.h.

        `position` (n, 3) must be there; one value stands for all n periods. Not given: 1 ms, all that lets the
        correction come in force, zero otherwise. Settings that are not given are the component's. ValueError for names
        not known.
        """

    def wanted(self, places: dict[str, Any]) -> dict[str, NDArray[Any]]:
        """What should be added at places that follow each other: model, table (n, 3), listed, on_path (n).

        Columns as in `step`: position, travel, tool_offset, signal, line (-1: none). The corrector's state stays.
        """

def realtime_library() -> bytes:
    """The corrector as an object file, to be linked into a component by the C interface of `realtime_header`."""

def realtime_header() -> str:
    """rtec.h."""

def realtime_names() -> dict[str, list[tuple[int, str, str]]]:
    """Number, name and meaning, by kind: phases, faults, refusals, waits."""
