"""`trueloop diagnose part` and `series`."""

from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.diagnose.options import Accept, Of, Output, Page
from trueloop.cli.diagnose.printed import print_diagnosis
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy


@guarded
def part(
    serial: Annotated[str, typer.Argument(metavar="SERIAL", help="Serial number of the part.")],
    of: Of,
    page: Page,
    output: Output = None,
    accept: Accept = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Show what is wrong with one part: errors of its features by device, components at its points, likely causes."""
    from trueloop.jobs.diagnose import diagnosed
    from trueloop.jobs.diagnose.written import write_diagnosis
    from trueloop.jobs.store.opened import opened
    from trueloop.report.diagnosis.lines import part_lines
    from trueloop.report.diagnosis.page_part import part_page

    with busy("diagnosing"):
        found = diagnosed.part(opened(db), serial, of.asked(accept))
        files = write_diagnosis(found, "part", part_page, output, page.language, page.unit)
    print_diagnosis(found, part_lines(found), found.findings, files, as_json=as_json)


@guarded
def series(
    of: Of, page: Page, output: Output = None, accept: Accept = None, db: Db = None, as_json: AsJson = False
) -> None:
    """Name what makes the parts of a type wrong: tool, probe, set-up, deflection, chatter, or the machine."""
    from trueloop.jobs.diagnose import diagnosed
    from trueloop.jobs.diagnose.written import write_diagnosis
    from trueloop.jobs.store.opened import opened
    from trueloop.report.diagnosis.lines import series_lines
    from trueloop.report.diagnosis.page_series import series_page

    with busy("diagnosing"):
        found = diagnosed.series(opened(db), of.asked(accept))
        files = write_diagnosis(found, "series", series_page, output, page.language, page.unit)
    print_diagnosis(found, series_lines(found), found.findings, files, as_json=as_json)
