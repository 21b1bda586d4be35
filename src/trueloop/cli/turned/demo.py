"""`trueloop demo`: a ready job, corrected."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.store_options import StoreChoice
from trueloop.cli.terminal import AsJson
from trueloop.cli.turned.compensate import PageChoice, run_job
from trueloop.formats.examples import example

Part = Literal["facetst", "modbas2", "piecs11"]
"""The parts of [6811] that come with trueloop."""


@guarded
def demo(
    page: PageChoice,
    part: Annotated[Part, typer.Argument(help="Which part.")] = "modbas2",
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results.  [default: out/PART]")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a ready job: a part that NIST measured in the 1990s, from its touches to a corrected program."""
    run_job(
        example(f"{part}/job.toml"),
        output or Path("out") / part,
        page,
        StoreChoice(no_store=True).keeping(None),
        as_json,
    )
