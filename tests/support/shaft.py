"""A turned shaft and its job, for inspections of it."""

import math
from pathlib import Path
from typing import Final

from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile

SHAFT: Final[Profile] = checked_profile(
    [
        Line("collar", (20.0, -60.0), (20.0, -40.0)),
        Line("shoulder", (20.0, -40.0), (15.0, -40.0)),
        Line("journal", (15.0, -40.0), (15.0, -22.5)),
        Line("cone", (15.0, -22.5), (10.0, -15.0)),
        Line("tip", (10.0, -15.0), (10.0, -2.0)),
        Arc("round", (10.0, -2.0), (8.0, 0.0), (8.0, -2.0), math.pi / 2),
        Line("end", (8.0, 0.0), (0.0, 0.0)),
    ]
)


def write_job(folder: Path) -> Path:
    """The job of the shaft; its program and its touches do not exist yet."""
    features = "".join(
        f'[[part.feature]]\nname = "{one.name}"\nto = [{one.end_mm[0]}, {one.end_mm[1]}]\n'
        + ("radius = 2.0\n" if isinstance(one, Arc) else "")
        for one in SHAFT.features
    )
    job = folder / "job.toml"
    job.write_text(
        f'[part]\nname = "shaft"\nstart = [20.0, -60.0]\n{features}[tool]\nnose_radius_mm = 0.4\n'
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "finish.nc"\n[gauging]\ntouches = "touches.csv"\n',
        encoding="utf-8",
    )
    return job
