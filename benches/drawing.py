"""Drawings of 100,000 lines and arcs beside ezdxf, which opens the file and does no more: processor time and memory.

`python -m benches.drawing` reads an open chain, which is the profile, an outline that closes with the axis, one of half
circles with lines between them, and one of 2,000 splines, each in a process of its own from its import on. The ratio is
ours to ezdxf's.
"""

import math
import subprocess
import sys
import tempfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import ezdxf.filemanagement

LINES = 100_000
OURS = "import sys; from trueloop.formats.cad.dxf import read_dxf; read_dxf(sys.argv[1])"
EZDXF = "import sys; from ezdxf.filemanagement import readfile; readfile(sys.argv[1])"


def main() -> None:
    """A line a drawing."""
    print(f"\n### A drawing of {LINES} lines and arcs, or of 2000 splines\n")
    print("| drawing | ours | ezdxf.readfile alone | time | memory |")
    print("|---|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for name, draw in DRAWINGS.items():
            path = drawn(Path(folder) / "part.dxf", draw)
            (ours_s, ours_mb), (their_s, their_mb) = spent(OURS, path), spent(EZDXF, path)
            ours, theirs = f"{ours_s:.1f} s, {ours_mb:.0f} MB", f"{their_s:.1f} s, {their_mb:.0f} MB"
            print(f"| {name} | {ours} | {theirs} | {ours_s / their_s:.2f} | {ours_mb / their_mb:.2f} |", flush=True)


def wave(layout: Any, closed: bool = False) -> None:
    """Lines of 10 µm, on to the axis at the ends if the wave is `closed`."""
    points = [(k * 0.01, 20 + 2 * math.sin(k / 300)) for k in range(LINES - 1 if closed else LINES + 1)]
    points = [(points[0][0], 0.0), *points, (points[-1][0], 0.0)] if closed else points
    for start, end in pairwise(points):
        layout.add_line(start, end)


def knobs(layout: Any) -> None:
    """A half circle and a line, half as often as there are lines."""
    for k in range(LINES // 2):
        layout.add_line((0.1 * k, 10), (0.1 * k + 0.05, 10))
        layout.add_arc((0.1 * k + 0.075, 10), 0.025, 0, 180)


def splines(layout: Any) -> None:
    """A wave of splines of one span each."""
    at = [0.5 * k for k in range(2001)]
    for x0, x1 in pairwise(at):
        (y0, s0), (y1, s1) = ((20 + 2 * math.sin(x / 7), math.cos(x / 7) / 21) for x in (x0, x1))
        layout.add_open_spline([(x0, y0), (x0 + 1 / 6, y0 + s0), (x1 - 1 / 6, y1 - s1), (x1, y1)])


DRAWINGS: dict[str, Callable[[Any], None]] = {
    "open chain": wave,
    "outline": lambda layout: wave(layout, closed=True),
    "arcs": knobs,
    "splines": splines,
}


def drawn(path: Path, draw: Callable[[Any], None]) -> Path:
    """A drawing in mm, of R12 where it has no splines."""
    document = ezdxf.filemanagement.new("R2010" if draw is splines else "R12", units=4)
    draw(document.modelspace())
    document.saveas(path)
    text = path.read_text("utf-8")
    path.write_text(text.replace("$ACADVER\n  1\nAC1009\n", "$ACADVER\n  1\nAC1009\n  9\n$INSUNITS\n 70\n4\n"), "utf-8")
    return path


def spent(program: str, path: Path) -> tuple[float, float]:
    """Seconds of the processor, and the most memory in MB, of a process that runs the program."""
    usage = "import resource as r; u = r.getrusage(r.RUSAGE_SELF); print(u.ru_utime + u.ru_stime, u.ru_maxrss)"
    answer = subprocess.run(
        [sys.executable, "-c", f"{program}; {usage}", path], capture_output=True, text=True, check=True
    )
    seconds, kilobytes = map(float, answer.stdout.split())
    return seconds, kilobytes / 1e3


if __name__ == "__main__":
    main()
