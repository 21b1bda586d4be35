"""Threading cycles of Fanuc and Haas lathes (G76): every pass is that of the definition, found slowly.

A pass is as deep as the area of its triangle asks for, which is sought by halving; where it is pulled out is sought by
halving too. Words, their order and their sense: HUST H6D-T manual, pages 3-59 and 3-60 (the cycle is Fanuc's), and
Haas's page on G76.
"""

import math
import re
from dataclasses import dataclass, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.unit.nc.test_turning_cycles import Row, rows
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

HALVINGS = 100


@dataclass(frozen=True)
class Thread:
    """Lengths in mm, radii; the last pass ends at `root` and `z`, and begins at a radius that is greater by `taper`."""

    start: tuple[float, float]
    root: float
    z: float
    height: float
    first: float
    least: float = 0.0
    allowance: float = 0.0
    finishes: int = 1
    pull_out: int = 0
    angle: int = 0
    taper: float = 0.0
    lead: float = 1.5

    def block(self) -> str:
        """As a Fanuc program has it."""
        return (
            f"G76 P{self.finishes:02d}{self.pull_out:02d}{self.angle:02d}"
            f" Q{round(1000 * self.least)} R{self.allowance}\n"
            f"G76 X{2 * self.root} Z{self.z} R{self.taper} P{round(1000 * self.height)} Q{round(1000 * self.first)}"
            f" F{self.lead}"
        )


def halved(holds: float, fails: float, condition: object) -> float:
    """The last value between the two for which the condition, a function of it, holds."""
    for _ in range(HALVINGS):
        middle = (holds + fails) / 2
        holds, fails = (middle, fails) if condition(middle) else (holds, middle)  # type: ignore[operator]
    return holds


def depths(thread: Thread) -> list[float]:
    """Each pass takes as much area as the first one, but each after it goes at least `least` deeper; then the
    finishing passes."""
    roughed, found = thread.height - thread.allowance, [0.0]
    while found[-1] < roughed - 1e-9:
        area = len(found) * thread.first**2
        equal = halved(0.0, 2 * thread.height + thread.first, lambda depth, area=area: depth**2 <= area)
        step = thread.least if len(found) > 1 else 0.0
        found.append(min(roughed, max(equal, found[-1] + step)))
    passes = found[1:] if thread.allowance else found[1:-1]
    return [*passes, *[thread.height] * thread.finishes]


def moves(thread: Thread) -> list[Row]:
    """Of all passes."""
    (x, z), ahead = thread.start, 1 if thread.z > thread.start[1] else -1
    out = 1 if x > thread.root else -1
    steps: list[Row] = []
    for depth in depths(thread):
        above = out * (thread.height - depth)
        begin = (thread.root + thread.taper + above, z + ahead * depth * math.tan(math.radians(thread.angle / 2)))
        end = (thread.root + above, thread.z)
        length = thread.pull_out / 10 * thread.lead

        def at(share: float, begin: tuple[float, float] = begin, end: tuple[float, float] = end) -> tuple[float, float]:
            return begin[0] + share * (end[0] - begin[0]), begin[1] + share * (end[1] - begin[1])

        left = at(halved(0.0, 1.0, lambda share, at=at, length=length: abs(thread.z - at(share)[1]) >= length))
        rise = halved(0.0, length, lambda rise, left=left: out * (x - left[0]) >= rise)
        pulled = (left[0] + out * rise, left[1] + ahead * rise)
        steps += [("rapid", x, begin[1]), ("rapid", *begin), ("thread", *left), ("thread", *pulled)]
        steps += [("rapid", x, pulled[1]), ("rapid", x, z)]
    return steps


def run(thread: Thread, words: str = "", unit: str = "G21", dialect: str = "fanuc-lathe") -> ToolPath:
    x, z = thread.start
    return read_program(f"{unit}\nG00 X{2 * x} Z{z}\n{words or thread.block()}\n".encode(), dialect).run()


def made(path: ToolPath, thread: Thread, unit_mm: float = 1.0) -> list[Row]:
    """The moves that lead anywhere, in the program's unit."""
    return that_lead_anywhere([(kind, x / unit_mm, z / unit_mm) for kind, x, z in rows(path)], thread.start)


def assert_same(found: list[Row], expected: list[Row]) -> None:
    assert [row[0] for row in found] == [row[0] for row in expected]
    for one, other in zip(found, expected, strict=True):
        assert one[1:] == pytest.approx(other[1:], abs=2e-9)


def that_lead_anywhere(steps: list[Row], start: tuple[float, float]) -> list[Row]:
    before = [start, *(row[1:] for row in steps)]
    return [row for row, at in zip(steps, before, strict=False) if math.dist(row[1:], at) > 1e-9]


QUARTERS = st.integers(1, 12).map(lambda count: count / 4)
THREADS = st.builds(
    lambda inside, backwards, clear, height, share, **words: Thread(
        start=(20.0, 4.0),
        root=20 + (1 if inside else -1) * (height + clear),
        z=4 + (1 if backwards else -1) * 30.0,
        height=height,
        first=round(height * share, 3),
        **words,
    ),
    inside=st.booleans(),
    backwards=st.booleans(),
    clear=QUARTERS,
    height=QUARTERS,
    share=st.sampled_from([0.2, 0.35, 0.5, 1.0]),
    least=st.sampled_from([0.0, 0.05, 0.2]),
    allowance=st.sampled_from([0.0, 0.1, 0.2]),
    finishes=st.integers(1, 3),
    pull_out=st.integers(0, 30),
    angle=st.sampled_from([0, 29, 55, 60]),
    taper=st.sampled_from([0.0, -0.5, 0.25]),
    lead=st.sampled_from([1.0, 1.5]),
)


@given(THREADS)
def test_every_pass_is_that_of_the_definition(thread: Thread) -> None:
    assert_same(made(run(thread), thread), that_lead_anywhere(moves(thread), thread.start))


@given(THREADS)
def test_it_ends_at_the_depth_programmed_and_is_never_deeper(thread: Thread) -> None:
    """Along the whole thread, whatever its taper: no cut is nearer to the axis (outside) than the last one."""
    thread = replace(thread, pull_out=0)
    path = run(thread)
    out = 1 if thread.start[0] > thread.root else -1
    cuts = path.end_mm[path.motion == Motion.THREAD]
    begins = path.start_mm[path.motion == Motion.THREAD]
    assert cuts[-1].tolist() == pytest.approx([thread.root, 0, thread.z], abs=1e-9)
    assert begins[-1, 0] == pytest.approx(thread.root + thread.taper, abs=1e-9)
    assert (out * (path.end_mm[:, 0] - min(0, out * thread.taper) * out - thread.root) >= -1e-9).all()
    assert (out * (cuts[:, 0] - thread.root) >= -1e-9).all()
    assert (path.feed[path.motion == Motion.THREAD] == thread.lead).all()


@given(THREADS)
def test_outside_and_inside_mirror_each_other_about_where_the_tool_stands(thread: Thread) -> None:
    x = thread.start[0]
    mirrored = replace(thread, root=2 * x - thread.root, taper=-thread.taper)
    found = [(kind, 2 * x - radius, z) for kind, radius, z in made(run(mirrored), mirrored)]
    assert_same(found, made(run(thread), thread))


@given(THREADS)
def test_code_systems_increments_and_inches_say_the_same(thread: Thread) -> None:
    """U, of code system A alone, is on the diameter. In inches the lengths without a point count 0.0001 in."""
    x, z = thread.start
    plain = made(run(thread), thread)
    ends = (f"X{2 * thread.root} Z{thread.z}", f"U{2 * (thread.root - x)} W{thread.z - z}")
    assert_same(made(run(thread, thread.block().replace(*ends)), thread), plain)
    assert_same(made(run(thread, dialect="fanuc-lathe-b"), thread), plain)
    inches = re.sub(r"([QP])(\d+)(?= [QRF])", lambda found: f"{found[1]}{int(found[2]) * 10}", thread.block())
    inches = re.sub(r"G76 P\d+", thread.block().split(" Q")[0], inches, count=1)
    assert_same(made(run(thread, inches, unit="G20"), thread, unit_mm=25.4), plain)


@given(THREADS, st.integers(1, 4))
def test_one_block_has_the_same_depths_and_p_says_how_they_grow(thread: Thread, method: int) -> None:
    """Haas: K height, D first depth, I taper, A angle; P1, P2 a constant area, P3, P4 a constant depth."""
    thread = replace(thread, least=0.0, allowance=0.0, finishes=1, pull_out=0, angle=60 if method % 2 else 0)
    if method >= 3:
        thread = replace(thread, least=thread.first)
    words = f"I{thread.taper} K{thread.height} D{thread.first} A60 P{method} F{thread.lead}"
    path = run(thread, f"G76 X{2 * thread.root} Z{thread.z} {words}", dialect="haas-lathe")
    assert_same(made(path, thread), that_lead_anywhere(moves(thread), thread.start))
    (said,) = path.findings
    assert ("both flanks" in said.message) == (method % 2 == 0)
