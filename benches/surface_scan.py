"""A scan through `trueloop surface`, process start to files: seconds of the processor and memory by number of points.

`python -m benches.surface_scan` takes deviations and model of 10⁵ and 10⁶ scattered points. There is no rival: it shows
that neither time nor memory grows faster than the points.
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from trueloop.formats.cad.step import named_faces

NOMINAL = Path(__file__).parents[1] / "examples" / "surface" / "nominal.step"
RUNS = [(command, count) for command in ("deviations", "model") for count in (100_000, 1_000_000)]


def main() -> None:
    """A line a run."""
    print(
        "\n### A scan through the command line\n\n| command | points | processor | µs a point | memory, most so far |"
    )
    print("|---|---:|---:|---:|---:|")
    for command, count in RUNS:
        cpu_s, most_mb = spent(command, count)
        print(f"| {command} | {count} | {cpu_s:.1f} s | {1e6 * cpu_s / count:.1f} | {most_mb:.0f} MB |", flush=True)


def spent(command: str, count: int) -> tuple[float, float]:
    """Seconds of the processor that the command takes, and the most memory that any did so far."""
    with tempfile.TemporaryDirectory() as folder:
        job, before = scan_job(Path(folder), count), resource.getrusage(resource.RUSAGE_CHILDREN)
        trueloop = Path(sys.executable).with_name("trueloop")
        subprocess.run(
            [trueloop, "surface", command, job, "-o", Path(folder) / "out"], stdout=subprocess.DEVNULL, check=True
        )
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime, used.ru_maxrss / 1e3


def scan_job(folder: Path, count: int) -> Path:
    """A job of so many points on the example's surface: some waves of 10 µm and noise of 4 µm."""
    surface, rng = named_faces(NOMINAL)[0].surface, np.random.default_rng(count)
    u, v = rng.uniform(0.001, 0.999, (2, count))
    error = 0.01 * np.sin(9 * u) * np.cos(7 * v) + rng.normal(0, 0.004, count)
    points = surface.point_mm(u, v) + error[:, None] * surface.normal(u, v)
    np.savetxt(folder / "scan.csv", points, "%.6f", ",", header="x_mm,y_mm,z_mm", comments="")
    job = folder / "job.toml"
    job.write_text(f'name = "scan"\n[surface]\nfile = "{NOMINAL}"\n[gauging]\npoints = ["scan.csv"]\n')
    return job


if __name__ == "__main__":
    main()
