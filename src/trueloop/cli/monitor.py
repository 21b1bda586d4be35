"""`trueloop monitor`: control charts with the causes of alarms, certificates of parts, checks of gauges."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.shared_options import Db, Page, argument, option, positive
from trueloop.cli.terminal import (
    AsJson,
    ExitStatus,
    Group,
    busy,
    finding_lines,
    print_files,
    print_json,
    print_lines,
    print_table,
)

if TYPE_CHECKING:
    pass


def certify(
    serial: Annotated[str, argument("The part's serial number.", metavar="SERIAL")],
    page: Page,
    output: Annotated[Path, option("Folder for the certificate.", "--output", "-o")],
    part_type: Annotated[
        str | None, option("The part type, where several have that serial number.", "--type", "-t")
    ] = None,
    u_um: Annotated[
        float | None, option("Standard uncertainty of readings that state none.  [default: unknown]", callback=positive)
    ] = None,
    who: Annotated[str | None, option("Who certifies.  [default: the user's name]")] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Certify a part: values, gauges, verdicts, corrections.

    Exit status 1 unless it conforms.
    """
    from trueloop.jobs.monitor.certificate import certify_part, write_certificate
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.monitor.certificate import HEAD, certificate_rows, in_force_lines

    shown = certify_part(open_store(db), serial, part_type, u_um, who or "")
    files = write_certificate(shown, output, page.language, page.unit)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
    else:
        proven = sum(characteristic.certified for characteristic in shown.characteristics)
        of_all = f"{proven} of {len(shown.characteristics)} characteristics certified"
        print_lines([f"{shown.part_type} {shown.serial}: {shown.outcome}, {of_all}"])
        print_table(HEAD, certificate_rows(shown))
        print_lines(in_force_lines(shown))
    print_files(files)
    if shown.outcome != "conforms":
        raise typer.Exit(ExitStatus.FINDINGS)


BASELINE = "20"
"""As `ChartOptions` has it; a test compares."""


class What(StrEnum):
    """The quantity on a chart."""

    VALUE = "value"
    RESIDUAL = "residual"


def chart(
    page: Page,
    part_type: Annotated[
        str | None, option("The part type.  [default: the only one in the store]", "--type", "-t")
    ] = None,
    characteristic: Annotated[
        list[str] | None,
        option("Of this characteristic alone; several times.  [default: all]", "--characteristic", "-c"),
    ] = None,
    rules: Annotated[str, option("Nelson's tests on single values: numbers 1 to 8, or all.")] = "1",
    baseline: Annotated[
        str, option("Limits from the first N parts, or from these serial numbers.", metavar="N|FIRST..LAST")
    ] = BASELINE,
    each_setting: Annotated[
        bool, option("Begin anew, with a centre of its own, where the tool was set.", "--each-setting")
    ] = False,
    what: Annotated[What, option("Errors as inspected, or residuals: what memory did not expect.")] = What.VALUE,
    output: Annotated[
        Path | None, option("Folder for the page and the values.  [default: none]", "--output", "-o")
    ] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Draw control charts of each characteristic.

    Alarms with their likely causes, capability with intervals.
    """
    from trueloop.jobs.monitor.charts import control_charts
    from trueloop.jobs.store.opened import open_store
    from trueloop.loops.monitor.chart import ChartOptions
    from trueloop.report.markup import write_page
    from trueloop.report.monitor.chart_page import chart_page
    from trueloop.report.monitor.chart_values import alarm_lines, chart_head, chart_rows

    numbers = range(1, 9) if rules == "all" else [int(one) if one.strip().isdigit() else 0 for one in rules.split(",")]
    if not all(1 <= number <= 8 for number in numbers):
        raise typer.BadParameter(f"{rules!r}: name tests by numbers from 1 to 8, as 1,2,5", param_hint="--rules")
    options = ChartOptions(tuple(sorted(set(numbers))), _baseline(baseline, each_setting), each_setting, what.value)
    with busy("charting the series"):
        shown = control_charts(open_store(db), part_type, characteristic or (), options)
        files = write_page(shown, "monitor", chart_page, output, page.language, page.unit)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
        return
    of = "errors as inspected" if shown.what == "value" else "residuals after correction"
    print_lines([f"{shown.part_type}: {len(shown.characteristics)} characteristics, {of}"])
    print_table(chart_head(shown), chart_rows(shown))
    for shape in shown.characteristics:
        print_lines(alarm_lines(shape, shown))
    print_lines(finding_lines(shown.findings))
    print_files(files)


def _baseline(text: str, anew: bool) -> int | tuple[str, str]:
    if ".." in text:
        first, last = text.split("..", 1)
        if anew:
            message = "parts of one segment say no centre of the others: give a number of parts"
            raise typer.BadParameter(message, param_hint="--baseline")
        return first.strip(), last.strip()
    if not text.isdigit() or int(text) < 1:
        raise typer.BadParameter(f"{text!r}: a number of parts, or FIRST..LAST", param_hint="--baseline")
    return int(text)


def gauge(
    page: Page,
    name: Annotated[
        str | None, argument("The device, as inspections name it.  [default: all]", metavar="[NAME]")
    ] = None,
    output: Annotated[
        Path | None, option("Folder for the page and the values.  [default: none]", "--output", "-o")
    ] = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Follow gauges and probes by checks on standard parts.

    Bias, repeatability and drift. Exit status 1 on an alarm.
    """
    from trueloop.jobs.monitor.charts import gauges_of
    from trueloop.jobs.store.opened import open_store
    from trueloop.report.markup import write_page
    from trueloop.report.monitor.gauge import HEAD, gauge_page, gauge_rows, remark_lines

    shown = gauges_of(open_store(db), name)
    files = write_page(shown, "gauges", gauge_page, output, page.language, page.unit)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
    else:
        print_table(HEAD, gauge_rows(shown))
        print_lines(line for shape in shown.gauges for line in remark_lines(shape))
    print_files(files)
    if any(shape.alarm for shape in shown.gauges):
        raise typer.Exit(ExitStatus.FINDINGS)


app = Group("Quality monitor: charts, certificates, drift of gauges.")
app.add_all(chart, certify, gauge)
