"""`trueloop diagnose machine`."""

from trueloop.cli.db.options import Db
from trueloop.cli.diagnose.options import Accept, Element, Output, Page, Types, elements_of
from trueloop.cli.diagnose.printed import print_diagnosis
from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import ModelOption
from trueloop.cli.terminal import AsJson, busy


@guarded
def machine(
    model: ModelOption,
    page: Page,
    part_type: Types = None,
    element: Element = None,
    output: Output = None,
    accept: Accept = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Name the axis errors that the machine's model has wrong, as sets, and what would divide each set."""
    from trueloop.jobs.diagnose import machines
    from trueloop.jobs.diagnose.written import write_diagnosis
    from trueloop.jobs.store.opened import opened
    from trueloop.report.diagnosis.lines import machine_lines
    from trueloop.report.diagnosis.page_machine import machine_page

    with busy("diagnosing"):
        found = machines.machine(opened(db), model, part_type or (), elements_of(element), accept or ())
        files = write_diagnosis(found, "machine", machine_page, output, page.language, page.unit)
    print_diagnosis(found, machine_lines(found), found.findings, files, as_json=as_json)
