"""Drawings of 100,000 lines beside ezdxf, which opens the file and does no more: seconds of the processor and memory.

`python -m benches.drawing` reads an open chain, which is the profile, and an outline that closes with the axis, each in
a process of its own from its import on. The ratio is ours to ezdxf's.
"""

import math
import subprocess
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import ezdxf.filemanagement

LINES = 100_000
OURS = "import sys; from trueloop.formats.cad.dxf import read_dxf; read_dxf(sys.argv[1])"
EZDXF = "import sys; from ezdxf.filemanagement import readfile; readfile(sys.argv[1])"


def main() -> None:
    """A line a drawing."""
    print(f"\n### A drawing of {LINES} lines\n\n| drawing | ours | ezdxf.readfile alone | time | memory |")
    print("|---|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for name, closed in (("open chain", False), ("outline", True)):
            path = drawn(Path(folder) / "part.dxf", closed=closed)
            (ours_s, ours_mb), (their_s, their_mb) = spent(OURS, path), spent(EZDXF, path)
            ours, theirs = f"{ours_s:.1f} s, {ours_mb:.0f} MB", f"{their_s:.1f} s, {their_mb:.0f} MB"
            print(f"| {name} | {ours} | {theirs} | {ours_s / their_s:.2f} | {ours_mb / their_mb:.2f} |", flush=True)


def drawn(path: Path, *, closed: bool) -> Path:
    """A wave of lines of 10 µm, on to the axis at its ends if it is `closed`."""
    points = [(k * 0.01, 20 + 2 * math.sin(k / 300)) for k in range(LINES - 1 if closed else LINES + 1)]
    points = [(points[0][0], 0.0), *points, (points[-1][0], 0.0)] if closed else points
    document = ezdxf.filemanagement.new("R12")
    for start, end in pairwise(points):
        document.modelspace().add_line(start, end)
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
