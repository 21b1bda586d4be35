"""The files of a measured day, as gauges and sensors of a shop would give them, from readings of the virtual lathe."""

from collections.abc import Iterable, Mapping
from typing import Final

from trueloop.arrays import Array
from trueloop_lab.simulator.lathe import Reading

HEADER: Final = "time_s,X_mm,Z_mm,travel_X,travel_Z,{along},{reading},{u},tool_x_mm,tool_z_mm,tool_y_mm,absolute,run"
VIRTUAL_WAYS: Final = {1: "+", -1: "-", 0: ""}


def lengths_csv(readings: Iterable[Reading]) -> str:
    """Displacements along directions; angles are left out."""
    along = "along_x,along_y,along_z"
    rows = [
        _row(reading, f"{reading.along[0]:.9f},0,{reading.along[1]:.9f}") for reading in readings if not reading.angle
    ]
    return "\n".join([HEADER.format(along=along, reading="reading_um", u="u_um"), *rows, ""])


def angles_csv(readings: Iterable[Reading]) -> str:
    """Rotations about Y; displacements are left out."""
    rows = [_row(reading, "B") for reading in readings if reading.angle]
    return "\n".join([HEADER.format(along="along", reading="reading_urad", u="u_urad"), *rows, ""])


def signals_csv(time_s: Array, signals_degc: Mapping[str, Array]) -> str:
    """Temperatures over time, as sensors of a hundredth of a kelvin give them."""
    header = ",".join(["time_s", *(f"{name}_degC" for name in signals_degc)])
    rows = zip(time_s.tolist(), *(values.tolist() for values in signals_degc.values()), strict=True)
    return "\n".join([header, *(f"{t:.3f}," + ",".join(f"{v:.2f}" for v in values) for t, *values in rows), ""])


def _row(reading: Reading, along: str) -> str:
    (x, z), (way_x, way_z), (tool_x, tool_z) = reading.at_mm, reading.way, reading.tool_mm
    ways = f"{VIRTUAL_WAYS[way_x]},{VIRTUAL_WAYS[way_z]}"
    absolute = "slope" if reading.slope_known else "no"
    value, tool = f"{reading.value:.3f},{reading.u:g}", f"{tool_x:g},{tool_z:g},0"
    return f"{reading.time_s:.3f},{x:.6f},{z:.6f},{ways},{along},{value},{tool},{absolute},{reading.run}"
