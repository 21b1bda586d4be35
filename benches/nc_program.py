"""NC programs read, run and displaced, beside what a user would pick: pygcode, gcodeparser, the Rust crate `gcode`, and
LinuxCNC's `rs274 -g`, which reads and runs at once. The commands as a user waits for them, start to end: `nc path`
beside rs274, `nc diff` of a program with itself beside the nearest ends of what rs274 prints, in a k-d tree.

Every row says what it loses of the program, counted in the same run. rs274 prints what it does, to a pipe here: that is
in its time. The programs: milling in 500,000 blocks, made here, and 3D_Chips, which Debian's linuxcnc-uspace installs.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from benches.nc_rivals import by_trueloop, loss, rivals
from benches.ratio import Contender, Samples, compare, process, verdict
from trueloop.domain.option import MapOptions
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.nc.field import similarity_field
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

BLOCKS = 500_000
CHIPS = Path("/usr/share/linuxcnc/ncfiles/3D_Chips.ngc")
TRUELOOP = Path(sys.executable).with_name("trueloop")
RS274, PARSE, RUN, WRITE = "rs274 -g", "trueloop, parse", "trueloop, parse and run", "trueloop, displaced and written"
PATH, DIFF, NEAREST_ENDS = "trueloop nc path", "trueloop nc diff", "rs274 -g twice, nearest ends"
PARSE_AIM_MB_S = 400.0
ROUNDS = 3
DIALECT = "linuxcnc"
EVERYWHERE = MapOptions(limit_mm=np.inf, slope=np.inf)
FIELD = similarity_field(shift_mm=(0.01, -0.02, 0.0), rotation_rad=1e-5, axis="Z", scale=1.0, about_mm=(0.0, 0.0, 0.0))


def main() -> None:
    """Compare on both programs."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "milled.ngc"
        made.write_text(milling_program(BLOCKS))
        for program in (made, Path(shutil.copy(CHIPS, folder))):
            size_mb = program.stat().st_size / 1e6
            title = f"{program.name}: {size_mb:.1f} MB"
            with rivals(program) as others:
                samples = compare(title, [*contenders(program), *others], ROUNDS, "what it loses")
            verdict(samples, RUN, to=RS274, at_most=1 / 50)
            verdict(samples, WRITE, to=RS274, at_most=1 / 20)
            tell_speed(samples, size_mb)
        verdict(compare_path(made), PATH, to=RS274, at_most=1)
        verdict(compare_diff(made), DIFF, to=NEAREST_ENDS, at_most=2)


def compare_path(program: Path) -> Samples:
    """`nc path` and rs274, both writing what they make to a pipe."""
    ours = Contender(PATH, process(TRUELOOP, "nc", "path", program, "--dialect", DIALECT), "1e-9 mm, every move's line")
    return compare("nc path", [ours, Contender(RS274, process("rs274", "-g", program), "1e-4 mm")], ROUNDS, "prints")


def compare_diff(program: Path) -> Samples:
    """A program with itself: `nc diff` looks between the ends of moves too, and says where."""
    command = process(TRUELOOP, "nc", "diff", program, program, "--dialect", DIALECT)
    contenders = [
        Contender(DIFF, command, "everywhere along the cuts"),
        Contender(NEAREST_ENDS, lambda: nearest_ends_mm(ends_mm(program), ends_mm(program)), "ends of moves"),
    ]
    return compare("nc diff of a program with itself", contenders, ROUNDS, "compares")


def nearest_ends_mm(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """The largest distance from an end in one to the nearest in the other, both ways."""
    trees = cKDTree(one), cKDTree(other)
    return max(float(np.max(tree.query(ends)[0])) for tree, ends in zip(trees, (other, one), strict=True))


def milling_program(blocks: int) -> str:
    """Passes along X over a gently bent surface: a numbered block with X, Y, Z a point, millimetres."""
    k = np.arange(blocks)
    x, y = 0.05 * (k % 2000), 0.3 * (k // 2000)
    z = 4 * np.sin(x / 14) * np.cos(y / 17)
    cuts = (f"N{n} G1 X{a:.4f} Y{b:.4f} Z{c:.4f}" for n, a, b, c in zip(k, x, y, z, strict=True))
    return "\n".join(["G21 G90 G17 G94 F1000", *cuts, "M2", ""])


def contenders(program: Path) -> list[Contender]:
    """Ours first; each reads the file anew."""
    return [
        Contender(PARSE, lambda: read_program(program.read_bytes(), DIALECT), loss(by_trueloop, program.read_text())),
        Contender(RUN, lambda: read_program(program.read_bytes(), DIALECT).run(), apart(program)),
        Contender(WRITE, displaced(program), off(program)),
        Contender(RS274, process("rs274", "-g", program), "ends printed to 4 decimals"),
    ]


def apart(program: Path) -> str:
    """How far our ends are from those that rs274 prints."""
    theirs_mm = ends_mm(program)
    apart_mm = np.abs(theirs_mm - path(program).end_mm).max()
    return f"{len(theirs_mm):,} ends, {apart_mm:.1g} mm from what rs274 prints"


def ends_mm(program: Path) -> NDArray[np.float64]:
    """Ends of straight moves as rs274 prints them, (n, 3)."""
    canonical = subprocess.run(["rs274", "-g", program], capture_output=True, text=True, check=True).stdout
    return np.array(re.findall(r"STRAIGHT_(?:FEED|TRAVERSE)\((\S+), (\S+), (\S+),", canonical), float)


def off(program: Path) -> str:
    """How far the ends of cuts that are written are from the displaced ones."""
    displaced(program)()
    before, after = path(program), path(written(program))
    cuts = before.motion != Motion.RAPID
    wanted_mm = before.end_mm + FIELD.displacement_mm(before.end_mm)
    return f"ends of cuts {np.abs(after.end_mm - wanted_mm)[cuts].max():.1g} mm from the displaced ones, as written"


def path(program: Path) -> ToolPath:
    """Its tool path."""
    return read_program(program.read_bytes(), DIALECT).run()


def written(program: Path) -> Path:
    """Where the displaced program goes."""
    return program.with_suffix(".out.ngc")


def displaced(program: Path) -> Callable[[], object]:
    """`nc map` with a shift and a turn, the record included."""
    return lambda: map_program(program, written(program), FIELD, EVERYWHERE, dialect=DIALECT)


def tell_speed(samples: Samples, size_mb: float) -> None:
    """How fast parsing was at its best, beside the aim."""
    speed = size_mb / min(samples.seconds[PARSE])
    within = "within" if speed >= PARSE_AIM_MB_S else "MISSES"
    print(f"\n{PARSE}: {speed:.0f} MB/s at best: {within} the aim of {PARSE_AIM_MB_S:g} MB/s")


if __name__ == "__main__":
    main()
