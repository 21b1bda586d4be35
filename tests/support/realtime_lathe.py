"""A lathe whose error is a linear function of where it is commanded: what has to be added follows by one division.

E(q) = S q; where the machine shall stand at q, what is added is c = −S (q + c), so that c = −(1 + S)⁻¹ S q.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trueloop.arrays import Array
from trueloop.controllers.linuxcnc.realtime.hal_lines import Change, by_file
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import Bank, Identity, Image, RealTimeLimits
from trueloop_lab.linuxcnc.realtime.session import Driven

WIDE = ((-500.0, 2000.0), (-1.0, 1.0), (-2000.0, 2000.0))
SLOPES = np.array([[1e-4, 0.0, 5e-5], [0.0, 0.0, 0.0], [-1e-5, 0.0, 2e-4]])
"""35 µm in X and 17 µm in Z where the virtual lathe is homed."""
RECORD = (
    *(f"joint.{joint}.{pin}" for joint in (0, 1) for pin in ("pos-cmd", "motor-offset", "f-error")),
    *(f"rtec.{pin}-{axis}" for axis in (0, 2) for pin in ("out", "corr", "fb", "cmd")),
    *("rtec.phase", "rtec.fault-code", "rtec.enable", "rtec.generation", "motion.is-all-homed"),
)
SLEW_MM = 0.005
"""What the correction may change by in a period of 1 ms."""


@dataclass(frozen=True)
class LinearLathe:
    """A machine of this slope, and its image."""

    slopes: Array
    travel_mm: tuple[tuple[float, float], tuple[float, float], tuple[float, float]] = WIDE

    @property
    def image(self) -> bytes:
        """A model alone, without signals."""
        limits = RealTimeLimits(self.travel_mm)
        return image_to_bytes(Image(Identity("linear lathe", "4711"), limits, Bank((), (), self.slopes.T[None])))

    def added_mm(self, commanded: Array) -> Array:
        """What has to be added at commands (n, 2), X and Z: (n, 2)."""
        q = np.column_stack([commanded[:, 0], np.zeros(len(commanded)), commanded[:, 1]])
        c = -np.linalg.solve(np.eye(3) + self.slopes, self.slopes @ q.T).T
        return np.asarray(c[:, [0, 2]], dtype=np.float64)


LATHE = LinearLathe(SLOPES)


def commanded(driven: Driven) -> Array:
    """X and Z in machine coordinates, (n, 2)."""
    return np.column_stack([driven["joint.0.pos-cmd"], driven["joint.1.pos-cmd"]])


def stood(driven: Driven) -> Array:
    """Where the drives were sent in machine coordinates, (n, 2)."""
    return np.column_stack([driven[f"rtec.out-{axis}"] - driven[f"joint.{joint}.motor-offset"] for joint, axis in AXES])


def added(driven: Driven) -> Array:
    """What was added, (n, 2)."""
    return np.column_stack([driven["rtec.corr-0"], driven["rtec.corr-2"]])


AXES = ((0, 0), (1, 2))
"""Joint and axis."""


def applied(changes: tuple[Change, ...], texts: Mapping[str, str]) -> dict[str, str]:
    """Files by name as a person would have them who made the changes by hand."""
    files = dict(texts)
    for file, found in by_file(changes).items():
        lines = files.get(Path(file).name, "").splitlines()
        for change in reversed(found):
            at = change.place.line or 0
            new = change.text.splitlines()
            if change.where == "replace":
                assert lines[at - 1] == change.old
                lines[at - 1 : at] = new
            else:
                at += {"before": -1, "after": 0, "new": 0}[change.where]
                lines[at:at] = new
        files[Path(file).name] = "\n".join(lines) + "\n"
    return files
