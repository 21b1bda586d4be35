"""Page of a drift model: every channel as it moved, and its last part as predicted from what was before."""

from collections.abc import Mapping, Sequence

from trueloop.machine.drift.drift import DriftTest
from trueloop.machine.drift.hold_out import DriftRun
from trueloop.machine.drift.model import DriftModel
from trueloop.report.machine.positioning import POINTS, drift_figure
from trueloop.report.markup import esc, section, table
from trueloop.report.shell import figure_block, html_page
from trueloop.report.style import plain
from trueloop.units import UM_PER_MM

CAPTION = "The whole log as read, and the rows that were held out as predicted from those before them."


def drift_model_page(name: str, test: DriftTest, models: Mapping[str, DriftModel], runs: Sequence[DriftRun]) -> str:
    """What each model takes and leaves, and its channel over time."""
    head = (
        '<header><p class="kicker">trueloop · drift model</p>'
        f"<h1>{esc(name)}</h1><p class='meta'>{len(test.time_s)} rows in "
        f"{(test.time_s[-1] - test.time_s[0]) / 3600:.1f} h, the last {len(runs[0].predicted_um)} held out</p></header>"
    )
    columns = ("channel", "moved (µm RMS)", "left", "left without the past", "inputs and their mean time constants (s)")
    rows = [
        (
            esc(run.channel),
            plain(run.raw_um, 2),
            plain(run.rms_um, 2),
            plain(run.static_rms_um, 2),
            _inputs(models[run.channel]),
        )
        for run in runs
    ]
    figures = [figure_block(f"channel {run.channel}", _figure(test, run), CAPTION) for run in runs]
    body = head + section("left", "Rows held out", table(columns, rows)) + section("plots", "Over time", *figures)
    return html_page(f"{esc(name)} – drift model", body)


def _inputs(model: DriftModel) -> str:
    return ", ".join(f"{esc(name)} {constant:.0f}" for name, constant in model.mean_constant_s.items())


def _figure(test: DriftTest, run: DriftRun) -> dict[str, object]:
    moved = UM_PER_MM * test.displacement_mm[run.channel]
    held = len(run.predicted_um)
    both = moved.copy()
    both[-held:] = run.predicted_um
    channels = {"read": moved, "predicted": both}
    return drift_figure(test.time_s, channels, f"{run.channel} (µm)", max(1, len(moved) // POINTS))
