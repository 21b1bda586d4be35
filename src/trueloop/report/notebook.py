"""Figures of the report in a notebook."""

from typing import TYPE_CHECKING

from trueloop.errors import Code
from trueloop.extras import install_command
from trueloop.report.style import Figure

if TYPE_CHECKING:
    from plotly.graph_objects import Figure as PlotlyFigure


def shown(figure: Figure) -> "PlotlyFigure":
    """A figure as Plotly's own object, which a notebook shows where it is the last value of a cell.

    Raises OUT-FIGURE where Plotly, the extra `notebook`, is not installed.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> figure = trueloop.before_and_after(trueloop.compensate(job.inputs))
    >>> trueloop.shown(figure).layout.width
    980
    """
    try:
        from plotly.graph_objects import Figure as PlotlyFigure
    except ImportError as missing:
        raise Code.OUT_FIGURE.refusal(
            f"figures are shown by Plotly, which cannot be loaded: {str(missing)!r}", hint=install_command("notebook")
        ) from None
    return PlotlyFigure(figure)
