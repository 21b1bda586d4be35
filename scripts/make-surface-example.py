"""Makes examples/surface anew: a nominal surface, the program that cut it, ten simulated parts; for the virtual mill a
program of low ridges.
"""

from pathlib import Path

import numpy as np

from tests.support.surfaces import points_to_csv
from trueloop.formats.cad.step import write_surface
from trueloop.geometry.surface import Surface, fit_grid
from trueloop.nc.program.dialect import dialect_named
from trueloop_lab.simulator.machine import published_process
from trueloop_lab.simulator.zigzag import ZigzagOptions, program_text, zigzag

FOLDER = Path(__file__).parents[1] / "examples" / "surface"
BALL_RADIUS_MM, CUTTER_RADIUS_MM, FINE_RADIUS_MM, PARTS = 2.0, 3.0, 8.0, 10


def nominal() -> Surface:
    """A gentle wave over a square of 50 mm, as rough in the middle as at its edges."""
    x, y = np.meshgrid(np.linspace(0, 50, 11), np.linspace(0, 50, 11), indexing="ij")
    return fit_grid(np.stack([x, y, 4 * np.sin(x / 14) * np.cos(y / 17)], axis=2)).surface


def main() -> None:
    """Writes the files."""
    surface = nominal()
    write_surface(surface, FOLDER / "nominal.step")
    programs = {
        "finish.ngc": ZigzagOptions(CUTTER_RADIUS_MM, scallop_mm=0.02, chord_mm=0.005),
        "fine.ngc": ZigzagOptions(FINE_RADIUS_MM, scallop_mm=0.003, chord_mm=0.005),
    }
    for name, options in programs.items():
        text = program_text(zigzag(surface, options), dialect_named("linuxcnc"), options)
        (FOLDER / name).write_text(text)
    rng = np.random.default_rng(2017)
    process, at = published_process(rng, pattern_mm=0.010), np.linspace(0.01, 0.99, 25)
    u, v = np.repeat(at, 25), np.tile(at, 25)
    point, normal = surface.point_mm(u, v), surface.normal(u, v)
    for k in range(1, PARTS + 1):
        noise = rng.normal(0.0, process.noise_mm, (len(at), len(at)))
        error = (process.pattern.grid_mm(at, at) + process.variation(rng).grid_mm(at, at) + noise).ravel()
        centres = point + (BALL_RADIUS_MM + error)[:, None] * normal
        (FOLDER / "parts" / f"S{k:02d}.csv").write_bytes(points_to_csv(centres, (25, 25)))


if __name__ == "__main__":
    main()
