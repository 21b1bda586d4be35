"""`trueloop series add`: inspection files into the store as parts of series."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines

if TYPE_CHECKING:
    from trueloop.jobs.series.added import Added

Files = Annotated[
    list[Path], typer.Argument(metavar="FILE…", help="What a gauge or a measuring machine wrote of finished parts.")
]
NONE = "none"


@dataclass(frozen=True, kw_only=True)
class Said:
    """What the files do not say."""

    part_type: Annotated[
        str | None, typer.Option("--type", "-t", help="Name of the part type.  [default: what the file says]")
    ] = None
    serial: Annotated[str | None, typer.Option("--serial", help="Serial number, of a file of one part without.")] = None
    unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--unit", help="Unit of its lengths.  [default: what it says]")
    ] = None
    mapping: Annotated[
        Path | None, typer.Option("--mapping", "-m", help="TOML file that says what columns and names mean.")
    ] = None
    take_nominal: Annotated[
        bool, typer.Option("--take-nominal", help="Do not flag parts whose values are exactly nominal as left out.")
    ] = False
    cut_with: Annotated[
        list[str] | None,
        typer.Option(
            "--cut-with",
            metavar="ID",
            help="An accepted proposal that was in force when the parts were cut, several times; `none`: no proposal "
            "was.  [default: all that were accepted before]",
        ),
    ] = None


@guarded
def add(files: Files, said: Said, db: Db = None, as_json: AsJson = False) -> None:
    """Take inspections of finished parts into the store, each file whole or not at all."""
    from trueloop.formats.inspections.measured_file import Stated
    from trueloop.jobs.series.added import Adding, add_files
    from trueloop.jobs.store.opened import opened

    cut_with = None if said.cut_with is None else tuple(one for one in said.cut_with if one != NONE)
    adding = Adding(
        *(said.part_type or "", said.serial or "", Stated(said.unit, said.mapping), said.take_nominal, cut_with)
    )
    with busy(f"reading {', '.join(map(str, files))}"):
        added = add_files(opened(db), files, adding)
    if as_json:
        print_json({"files": [_as_dict(one) for one in added]})
    else:
        for one in added:
            _print(one)


def _print(one: "Added") -> None:
    lines = [f"{one.path}: {one.part_type}, {len(one.new)} parts kept, {one.sizes} sizes"]
    if one.known:
        lines.append(f"  {len(one.known)} parts are in the store already: {', '.join(one.known)}")
    if one.cut_with:
        lines.append(f"  cut with the proposals {', '.join(one.cut_with)}")
    print_lines([*lines, *one.findings])


def _as_dict(one: "Added") -> dict[str, object]:
    findings = [{"code": f.code, "severity": f.severity, "message": f.message, "hint": f.hint} for f in one.findings]
    return {
        "file": str(one.path),
        "part_type": one.part_type,
        "new": list(one.new),
        "known": list(one.known),
        "cut_with": list(one.cut_with),
        "sizes": one.sizes,
        "findings": findings,
    }
