"""The CSV of a tool path, cell by cell with Python's own formatting: what the quick one must equal."""

from collections.abc import Iterator

import numpy as np

from trueloop.nc.program.tool_path import INVERSE_TIME, PER_MINUTE, PER_REVOLUTION, Motion, ToolPath

_FEED_UNITS = {INVERSE_TIME: "1/min", PER_MINUTE: "mm/min", PER_REVOLUTION: "mm/rev"}


def csv_lines(path: ToolPath) -> Iterator[str]:
    """One line a move, in the order of `CSV_HEADER`; lengths to 1e-9 mm, angles to 1e-12 rad."""
    for index in range(len(path)):
        arc = path.motion[index] == Motion.ARC
        yield ",".join(
            [
                str(path.line[index]),
                str(path.column[index]),
                Motion(path.motion[index]).name.lower(),
                *(_decimal(value, 9) for value in path.end_mm[index]),
                *(_decimal(value, 9) for value in path.start_mm[index]),
                *(_decimal(value, 9) if arc else "" for value in path.centre_mm[index]),
                _decimal(path.sweep_rad[index], 12) if arc else "",
                "" if path.motion[index] == Motion.RAPID else _decimal(path.feed[index], 9),
                _FEED_UNITS[int(path.feed_mode[index])],
                str(path.tool[index]),
            ]
        )


def _decimal(value: float, decimals: int) -> str:
    if np.isnan(value):
        return ""
    return f"{value:.{decimals}f}".rstrip("0").rstrip(".") if round(value, decimals) else "0"
