"""The two part types: job, programs, and where the lathe's probe and the measuring machine touch them."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

from trueloop.controllers.probing.linuxcnc import program as probing_program
from trueloop.controllers.probing.settings import settings_of
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.jobs.measure.probing import read_probing
from trueloop.jobs.turned.job import read_part
from trueloop.probing.probe_plan import ProbePlan
from trueloop_lab.loops.linuxcnc import contour_program

NOSE_MM: Final = 0.8
ALLOWANCE_MM: Final = 0.2
FEED_MM_PER_REV: Final = 0.15
SPINDLE_RPM: Final = 2000.0
CLEAR_MM: Final = 3.0
PAST_AXIS: Final = b"G1 X-0.8 (a little past the axis)\n"

DOME: Final = """\
start = [36.0, -40.0]
feature = [
    { name = "collar", to = [36.0, -30.0] },
    { name = "face", to = [24.0, -30.0] },
    { name = "journal", to = [24.0, -12.0] },
    { name = "dome", to = [0.0, 0.0], centre = [0.0, -12.0] },
]"""
KNOB: Final = """\
start = [36.0, -34.0]
feature = [
    { name = "collar", to = [36.0, -26.0] },
    { name = "face", to = [28.0, -26.0] },
    { name = "journal", to = [28.0, -16.0] },
    { name = "shoulder", to = [20.0, -16.0] },
    { name = "neck", to = [20.0, -10.0] },
    { name = "knob", to = [0.0, 0.0], centre = [0.0, -10.0] },
]"""
JOB: Final = """\
# {name}, for the virtual lathe of `make demo-factory`.

[part]
name = "{name}"
unit = "mm"
x_is = "diameter"
{profile}
characteristic = [
    {{ name = "Diameter 1", quantity = "diameter", feature = "collar", tolerance = "±0.02" }},
    {{ name = "Diameter 2", quantity = "diameter", feature = "journal", tolerance = "±0.015" }},
]

[tool]
nose_radius_mm = 0.8
number = 1

[programs]
dialect = "linuxcnc"
finish = "finish.ngc"
semifinish = "semifinish.ngc"
semifinish_allowance_mm = {allowance}

[gauging]
points = {{ {points} }}
z_reference = "3" # on the face
probe = "probe.toml"
touches = "touches.txt"

[compensation]
by = "contour" # nobody is there at night to set an offset
"""
PROBE: Final = """\
[stylus]
ball_radius_mm = 1.5
stem_radius_mm = 0.75
stem_length_mm = 50.0
stem_angle_deg = 45.0

[approach]
stand_off_mm = 0.3
overtravel_mm = 0.4
margin_mm = 0.2

[program]
x_is = "radius"
probe_feed_mm_per_min = 60.0

[probe]
on = '''
M50 P0
(the part is cleaned before it is touched)
M66 P1 L3 Q120'''

[calibration] # from `trueloop probe calibrate`
effective_radius_mm = 1.4946
cosine_um = -0.5
lobes = 3
scatter_um = 0.3
from_deg = -45.0
to_deg = 135.0
"""


@dataclass(frozen=True)
class PartKind:
    """A part type as the lathe makes it. `points`: how often the lathe's probe touches each feature."""

    name: str
    profile_toml: str
    points: str

    @cached_property
    def job(self) -> str:
        """The job of its orders."""
        return JOB.format(name=self.name, profile=self.profile_toml, points=self.points, allowance=ALLOWANCE_MM)

    @cached_property
    def profile(self) -> Profile:
        """Its nominal shape."""
        with _folder(self.job) as job:
            return read_part(job).profile

    @cached_property
    def plan(self) -> ProbePlan:
        """Where the lathe's probe touches it."""
        with _folder(self.job) as job:
            return read_probing(job).plan

    @cached_property
    def programs(self) -> dict[str, bytes]:
        """By the kind of the step."""
        with _folder(self.job) as job:
            read = read_probing(job)
        settings = settings_of(self.name, read.probe.program, read.probe.probe)
        left_on_mm = {"semifinish": ALLOWANCE_MM, "finish": 0.0}
        cuts = {kind: self._contour(left_mm) for kind, left_mm in left_on_mm.items()}
        return cuts | {"probe": probing_program(read.plan, settings).encode()}

    def _contour(self, left_mm: float) -> bytes:
        path = nose_centre_path(self.profile, NOSE_MM + left_mm)
        contour, _, rest = contour_program(path.features, FEED_MM_PER_REV, SPINDLE_RPM, CLEAR_MM).rpartition(b"G0 Z")
        return contour + PAST_AXIS + b"G0 Z" + rest


@contextmanager
def _folder(job_toml: str) -> Iterator[Path]:
    """The job as a file, with its probe beside it."""
    with tempfile.TemporaryDirectory() as name:
        job = Path(name, "job.toml")
        job.write_text(job_toml, encoding="utf-8")
        job.with_name("probe.toml").write_text(PROBE, encoding="utf-8")
        yield job


DOMES: Final = PartKind("DOME-24", DOME, "collar = 2, face = 1, journal = 2, dome = 8")
DOMES_BY_FEW: Final = PartKind("DOME-24", DOME, "collar = 2, face = 1, journal = 2, dome = 3")
"""Once the tool's memory knows the edge."""
KNOBS: Final = PartKind("KNOB-20", KNOB, "collar = 2, face = 1, journal = 2, neck = 1, knob = 8")
