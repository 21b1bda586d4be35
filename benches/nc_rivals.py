"""Other readers of NC programs, and what each of them loses of a program: counted, not quoted.

What is lost is counted against the text itself, taken apart by one regular expression; ours stands the same test.
"""

import math
import re
import subprocess
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from gcodeparser import parse_gcode_lines
from pygcode import Line
from pygcode.exceptions import GCodeWordStrError

from benches.ratio import Contender
from trueloop.nc.program.program import read_program

ROOT = Path(__file__).parent.parent
JUDGED_LINES = 20_000
"""So many lines of a program are compared with what a reader made of them."""

WORD = re.compile(r"([A-Z])\s*([+-]?(?:\d+\.?\d*|\.\d+)|\[[^\]]*\]|#<\w+>)", re.IGNORECASE)
NO_WORDS = re.compile(r"\([^)]*\)|;.*|#\S+\s*=.*")


@dataclass
class Read:
    """A line as a reader has it: values by letter, NaN for a formula, and the line as the reader would write it."""

    values: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    written: str = ""

    def add(self, letter: str, value: object) -> None:
        """One word more; a value that is no number is NaN."""
        number = value if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
        self.values[letter.upper()].append(float(number))


Reader = Callable[[str], list[Read]]


def as_it_stands(text: Iterable[str]) -> list[Read]:
    """What the lines say: letters and their decimal numbers."""
    lines = [Read(written=line) for line in text]
    for line in lines:
        for letter, value in WORD.findall(NO_WORDS.sub("", line.written)):
            line.add(letter, float(value) if value[0] not in "[#" else None)
    return lines


def by_trueloop(text: str) -> list[Read]:
    """Ours, through its public interface."""
    program = read_program(text.encode("latin-1"), "linuxcnc")
    lines = []
    for block in program.blocks:
        line = Read(written=program.source[block.start : block.end].decode("latin-1"))
        for word in block.words:
            if word.kind in {"number", "expression"}:
                line.add(word.letter, word.value)
        lines.append(line)
    return lines


def by_pygcode(text: str) -> list[Read]:
    """Line by line."""
    return [_pygcode_words(_pygcode_line(line)) for line in text.splitlines()]


def _pygcode_line(line: str) -> Line | None:
    try:
        return Line(line)
    except GCodeWordStrError:
        return None


def _pygcode_words(line: Line | None) -> Read:
    read = Read(written="" if line is None else str(line))
    for word in [] if line is None else line.block.words:
        read.add(word.letter, float(word.value))
    return read


def by_gcodeparser(text: str) -> list[Read]:
    """A line may have several commands; one without any is passed over."""
    lines = [Read() for _ in text.splitlines()]
    for found in parse_gcode_lines(text):
        line = lines[found.line_index]
        line.written = f"{line.written} {found.gcode_str}".strip()
        line.add(*found.command)
        for letter, value in found.params.items():
            line.add(letter, value)
    return lines


GCODE_CRATE = ROOT / "target/release/examples/gcode_crate"


def by_gcode_crate(text: str) -> list[Read]:
    """The Rust crate `gcode`: no block at all where anything in the program is wrong to it."""
    told = subprocess.run([GCODE_CRATE], input=text, stdout=subprocess.PIPE, text=True, check=True).stdout
    lines = [Read() for _ in text.splitlines()]
    for block in told.splitlines():
        index, words, written = block.split("\t")
        lines[int(index)].written = written
        for word in words.split():
            lines[int(index)].add(word[0], float(word[1:]))
    return lines


@contextmanager
def gcode_crate(program: Path) -> Iterator[Callable[[], object]]:
    """What has the crate parse the program once more, in a process of its own that has read it already."""
    with subprocess.Popen(
        [GCODE_CRATE, program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    ) as process:
        question, answer = process.stdin, process.stdout
        assert question is not None and answer is not None

        def parse() -> None:
            question.write("again\n")
            if not answer.readline():
                raise SystemExit("gcode_crate ended early")

        yield parse


def loss(reader: Reader, text: str) -> str:
    """Of the first lines: words that are gone and the largest error of a value, as read and as written back."""
    kept = "".join(text.splitlines(keepends=True)[:JUDGED_LINES])
    wanted, found = as_it_stands(kept.splitlines()), reader(kept)
    written_back = as_it_stands(line.written for line in found)
    return f"read: {_loss(wanted, found)}; written back: {_loss(wanted, written_back)}"


def _loss(wanted: list[Read], found: list[Read]) -> str:
    words = [(a.values[letter], b.values[letter]) for a, b in zip(wanted, found, strict=True) for letter in [*a.values]]
    count, gone = sum(len(a) for a, _ in words), sum(max(0, len(a) - len(b)) for a, b in words)
    errors = (abs(p - q) for a, b in words for p, q in zip(a, b, strict=False))
    error = max((error for error in errors if not math.isnan(error)), default=0.0)
    return f"{gone:,} of {count:,} words lost, values off by up to {error:.1g}"


def _parse_with_pygcode(text: str) -> None:
    """Keeping nothing: half a million lines of it would need gigabytes."""
    for line in text.splitlines():
        _pygcode_line(line)


@contextmanager
def rivals(program: Path) -> Iterator[list[Contender]]:
    """The readers of a program, each with what it loses of it."""
    text = program.read_text("latin-1")
    build = ["cargo", "build", "--release", "--quiet", "--locked", "-p", "nc-program", "--example", GCODE_CRATE.name]
    subprocess.run(build, cwd=ROOT, check=True)
    with gcode_crate(program) as parse:
        yield [
            Contender("pygcode, parse", lambda: _parse_with_pygcode(text), loss(by_pygcode, text)),
            Contender("gcodeparser, parse", lambda: list(parse_gcode_lines(text)), loss(by_gcodeparser, text)),
            Contender("Rust crate gcode, parse", parse, loss(by_gcode_crate, text)),
        ]
