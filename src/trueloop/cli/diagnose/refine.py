"""`trueloop diagnose refine`."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.diagnose.options import Accept, Element, Page, Types, elements_of
from trueloop.cli.diagnose.printed import print_diagnosis
from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import ModelOption
from trueloop.cli.terminal import AsJson, busy


@guarded
def refine(
    model: ModelOption,
    errors: Annotated[
        str, typer.Option("--errors", metavar="EXX,…|auto", help="Which errors are to be updated; auto: those found.")
    ],
    out: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder of the offered model and the page.")
    ],
    page: Page,
    share: Annotated[float, typer.Option("--share", min=0.05, max=1.0, help="Part of the change that is made.")] = 1.0,
    part_type: Types = None,
    element: Element = None,
    accept: Accept = None,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Refine a machine's model from what it left on parts, judged on parts left out. It is offered, never in force.

    `trueloop machine accept` puts it in force.
    """
    from trueloop.jobs.diagnose.refined import Refining, refined
    from trueloop.jobs.store.opened import opened
    from trueloop.report.diagnosis.lines import machine_lines
    from trueloop.report.texts.texts import Texts

    names = tuple(name.strip() for name in errors.split(",") if name.strip())
    asked = Refining(names, tuple(part_type or ()), tuple(elements_of(element).items()), share)
    with busy("refining"):
        done = refined(opened(db), model, asked, out, Texts(page.language, page.unit), accept or ())
    print_diagnosis(done.shape, machine_lines(done.shape), done.shape.findings, list(done.files), as_json=as_json)
    if done.kept and not as_json:
        typer.echo(done.kept)
