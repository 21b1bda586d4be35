"""Checks of gauges as lines for a terminal."""

from collections.abc import Iterator

from trueloop.report.monitor.gauge_shapes import GaugeShape, GaugesShape
from trueloop.report.style import plain, signed

HEAD = (
    *("device", "standard", "characteristic", "checks"),
    *("bias ± U µm", "repeatability µm", "drift µm/day", "E_n", "alarm"),
)


def gauge_rows(shown: GaugesShape) -> Iterator[tuple[str, ...]]:
    """Cells of a table, one row a series."""
    for one in shown.gauges:
        last, drift = one.checks[-1].e_n, one.drift_um_per_day
        yield (
            one.device,
            one.standard,
            one.characteristic,
            str(len(one.checks)),
            signed(one.bias_um, 2) + ("" if one.expanded_u_um is None else f" ± {plain(one.expanded_u_um, 2)}"),
            "" if one.repeatability_um is None else plain(one.repeatability_um, 2),
            "" if drift is None else f"{signed(drift, 3)} ± {plain(one.drift_half_width_um or 0.0, 3)}",
            "" if last is None else plain(last, 2),
            "yes" if one.alarm else "",
        )


def remark_lines(one: GaugeShape) -> Iterator[str]:
    """What failed, and what to do."""
    name = f"{one.device}, {one.standard}, {one.characteristic}"
    yield from (f"{name}: {text}" for text in one.remarks)
    yield from (check.fails for check in one.checks if check.fails)
