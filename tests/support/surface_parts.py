"""Jobs of a surface whose parts are made here: a pattern that repeats, what parts differ by, and noise."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from tests.support.surfaces import wavy_surface
from trueloop.arrays import Array
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.geometry.surface import Surface
from trueloop.jobs.surface.job import ReadSurface
from trueloop.loops.surface.correction import SurfaceInputs
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.options import SurfaceOptions

SIDE: Final = 11
NOMINAL: Final = wavy_surface()
AT: Final = np.linspace(0.04, 0.96, SIDE)
U, V = (along.ravel() for along in np.meshgrid(AT, AT, indexing="ij"))


def pattern_um(u: Array, v: Array) -> Array:
    return 10 * np.sin(5 * u) * np.cos(4 * v)


def part(
    number: int, *, more_um: Array | float = 0.0, surface: Surface = NOMINAL, ball_radius_mm: float = 0.0
) -> MeasuredPoints:
    """A part with the pattern, a share of a shape of its own (1 µm), and noise (0.5 µm); `more_um` at its points."""
    random = np.random.default_rng(number)
    own = random.normal(0, 1.0, 3) @ np.stack([np.ones_like(U), np.cos(3 * U), np.cos(3 * V)])
    error_mm = (pattern_um(U, V) + own + more_um + random.normal(0, 0.5, len(U))) / 1000
    (u0, u1), (v0, v1) = surface.domain
    u, v = u0 + (u1 - u0) * U, v0 + (v1 - v0) * V
    points = surface.point_mm(u, v) + (error_mm + ball_radius_mm)[:, None] * surface.normal(u, v)
    return MeasuredPoints(points, ball_radius_mm, (SIDE, SIDE), f"S{number:02d}")


def job(
    parts: Sequence[MeasuredPoints],
    *,
    surface: Surface = NOMINAL,
    program_sha256: str = "a" * 64,
    options: SurfaceOptions = SurfaceOptions(),  # noqa: B008 - frozen
    name: str = "Wave",
) -> ReadSurface:
    hashes = [hashlib.sha256(one.points_mm.tobytes()).hexdigest() for one in parts]
    inspections = tuple(
        Inspection(
            Part(PartType(name), one.name),
            "CMM points",
            digest,
            int(np.isfinite(one.points_mm).all(axis=1).sum()),
            frame="device" if options.best_fit else "part",
            ball_radius_mm=one.ball_radius_mm,
        )
        for one, digest in zip(parts, hashes, strict=True)
    )
    named = {f"{one.name}.csv": digest for one, digest in zip(parts, hashes, strict=True)}
    inputs = SurfaceInputs(
        name, surface, tuple(parts), options, None, None, named, inspections=inspections, program_sha256=program_sha256
    )
    return ReadSurface(inputs, Path("job.toml"), Path("nominal.csv"), (), Path("out"), "none")
