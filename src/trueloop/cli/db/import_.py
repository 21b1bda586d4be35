"""`trueloop db import`: inspections, records and exports into the store."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines

if TYPE_CHECKING:
    from trueloop.jobs.db.imported import Imported

Files = Annotated[
    list[Path],
    typer.Argument(metavar="FILE…", help="Inspection files, a job's touches, record.json, or exports of a store."),
]


@dataclass(frozen=True, kw_only=True)
class Meant:
    """What inspection files do not say themselves."""

    job: Annotated[
        Path | None, typer.Option("--job", "-j", help="The job whose part was measured.  [default: what the file says]")
    ] = None
    serial: Annotated[
        str, typer.Option("--serial", help="Serial number of the part.  [default: the file's, the job's, the label's]")
    ] = ""
    unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--unit", help="Unit of its lengths.  [default: what it says]")
    ] = None
    mapping: Annotated[
        Path | None, typer.Option("--mapping", "-m", help="TOML file that says what columns, variables and names mean.")
    ] = None
    ignore_labels: Annotated[
        bool, typer.Option("--ignore-labels", help="Take a label in a file's name for no statement about the part.")
    ] = False


@guarded
def import_(files: Files, meant: Meant, db: Db = None, as_json: AsJson = False) -> None:
    """Keep files in the store, each whole or not at all. What is there already is found and not kept twice."""
    from trueloop.formats.inspections.measured_file import Stated
    from trueloop.jobs.db.imported import import_files
    from trueloop.jobs.db.inspected import Inspected
    from trueloop.jobs.store.opened import opened

    store = opened(db)
    of = Inspected(meant.job, meant.serial, Stated(meant.unit, meant.mapping), heed_labels=not meant.ignore_labels)
    done: list[Imported] = []
    with busy(f"importing {files[0]}") as progress:
        for one in import_files(store, files, of, progress):
            done.append(one)
            if not as_json:
                print_lines([one.words])
    if as_json:
        print_json({"files": [one.as_dict for one in done]})
