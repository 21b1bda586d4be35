"""What LinuxCNC would log of NIST's part on a probe: writes examples/loop/touches.txt.

The ball's centre stands off the nominal point by the allowance, the part error of NISTIR 6517's Table 1, and the
ball's effective radius in the direction of the touch, all along the normal. LinuxCNC logs nine
numbers a touch, X as a radius.
"""

from pathlib import Path
from typing import Final

import numpy as np

from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.jobs.measure.probing import read_probing

EXAMPLES: Final = Path(__file__).parents[1] / "examples"
LOG: Final = EXAMPLES / "loop" / "touches.txt"


def log() -> str:
    """A row for every touch of the plan."""
    probing = read_probing(EXAMPLES / "loop" / "modbas2.toml")
    errors = {touch.point: touch.error_mm for touch in read_touches(EXAMPLES / "modbas2" / "touches.csv")}
    calibration = probing.probe.calibration
    assert calibration is not None
    rows = []
    for touch in probing.plan.touches:
        normal = np.array(touch.normal)
        off_mm = probing.plan.approach.allowance_mm + (errors[touch.point] or 0.0)
        x, z = np.array(touch.nominal_mm) + (off_mm + calibration.radius_mm(normal[None])[0]) * normal
        rows.append(f"{x:.6f} 0.000000 {z:.6f}" + " 0.000000" * 6)
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    LOG.write_text(log(), encoding="utf-8")
