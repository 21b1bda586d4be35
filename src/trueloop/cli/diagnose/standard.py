"""`trueloop diagnose standard`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.store_options import Supersede, kept_as_dict, print_findings
from trueloop.cli.terminal import AsJson, print_json


@guarded
def standard(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Calibrated sizes, each with its uncertainty.")],
    serial: Annotated[str, typer.Option("--serial", help="Serial number of the standard part.")],
    part_type: Annotated[str, typer.Option("--type", "-t", help="Part type whose series it is probed among.")],
    by: Annotated[str, typer.Option("--by", help="Who calibrated it.")] = "",
    unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--unit", help="Unit of its lengths.  [default: what it says]")
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option("--mapping", help="TOML file that says what columns and names mean.")
    ] = None,
    supersede: Supersede = False,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Keep a calibrated part: its inspections then show the probe and the machine, never a cut."""
    from trueloop.formats.inspections.measured_file import Stated
    from trueloop.jobs.diagnose.standard import keep_standard, standard_of
    from trueloop.jobs.store.opened import opened

    named = standard_of(part_type, serial)
    kept = keep_standard(opened(db), file, named, Stated(unit, mapping), by, supersede=supersede)
    print_findings(kept.findings)
    if as_json:
        print_json(kept_as_dict(kept))
    else:
        typer.echo(kept.words)
