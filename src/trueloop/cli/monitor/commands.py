"""`trueloop monitor`: control charts with the causes of alarms, certificates of parts, checks of gauges."""

import typer

from trueloop.cli.monitor.certify import certify
from trueloop.cli.monitor.chart import chart
from trueloop.cli.monitor.gauge import gauge

app = typer.Typer(
    help="Quality monitor: control charts, certificates of parts, drift of gauges.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(chart)
app.command()(certify)
app.command()(gauge)
