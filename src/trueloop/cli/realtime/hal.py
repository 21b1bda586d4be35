"""`trueloop realtime hal`: the lines of HAL that put the corrector into a configuration."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, print_json, print_lines

if TYPE_CHECKING:
    from trueloop.controllers.linuxcnc.realtime.hal_lines import Change


@guarded
def hal(
    ini: Annotated[Path, typer.Argument(metavar="INI", help="The INI file that LinuxCNC is started with.")],
    image: Annotated[
        Path | None, typer.Option("--image", help="The image: its signals and its machine's serial go into the lines.")
    ] = None,
    serial: Annotated[
        str | None, typer.Option(help="Refuse an image for a machine with another serial number.")
    ] = None,
    job: Annotated[
        Path | None,
        typer.Option(
            "--job", metavar="JOB.toml", help="Refuse an image for another machine, program or tool than the job's."
        ),
    ] = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Also the lines of a sampler, for `trueloop realtime watch`.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the lines to change and to add so that the corrector stands between motion and the drives, and why.

    Nothing is edited. A configuration that the corrector cannot be put into is refused, by what stands in the way. An
    image of another machine is refused by its travel, axes and serial number; with --job by model, program, tool too.
    """
    from trueloop.controllers.linuxcnc.realtime.hal_lines import by_file
    from trueloop.jobs.realtime.wired import Wanted, wired

    if image is None and (serial is not None or job is not None):
        raise typer.BadParameter("an image is compared with it: give --image too", param_hint="--serial, --job")
    made = wired(ini, Wanted(image, serial, job, watch))
    if as_json:
        changes = [
            {"file": c.place.file, "line": c.place.line, "where": c.where, "old": c.old, "text": c.text, "why": c.why}
            for c in made.changes
        ]
        print_json({"changes": changes, "remarks": list(made.remarks)})
        return
    for file, found in by_file(made.changes).items():
        new = found[0].where == "new"
        print_lines([f"{file}{': new' if new else ''}", *(line for change in found for line in _shown(change)), ""])
    print_lines(f"- {remark}" for remark in made.remarks)


def _shown(change: "Change") -> list[str]:
    """A change as a person makes it."""
    at = {"replace": "replace", "before": "insert before", "after": "insert after"}
    if change.where == "new":
        return [f"  {change.text}    # {change.why}"]
    head = f"  line {change.place.line}, {at[change.where]} ({change.why}):"
    return [
        head,
        *([f"    - {change.old.strip()}"] if change.old else []),
        *(f"    + {line}" for line in change.text.splitlines()),
    ]
