"""`trueloop realtime hal`: the lines of HAL that put the corrector into a configuration."""

from dataclasses import replace
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
    watch: Annotated[
        bool, typer.Option("--watch", help="Also the lines of a sampler, for `trueloop realtime watch`.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the lines to change and to add so that the corrector stands between motion and the drives, and why.

    Nothing is edited. A configuration that the corrector cannot be put into is refused, by what stands in the way.
    """
    from trueloop.controllers.linuxcnc.realtime.configuration import read_configuration
    from trueloop.controllers.linuxcnc.realtime.hal_lines import by_file, wiring
    from trueloop.controllers.linuxcnc.realtime.watch_lines import watching
    from trueloop.formats.realtime.image_file import read_image

    read = read_image(image) if image is not None else None
    named = str(image.resolve()) if image is not None else "IMAGE.rtec"
    configuration = read_configuration(ini)
    made = wiring(configuration, read, named)
    if watch:
        signals = len(read.bank.signals) if read and read.bank else 0
        made = replace(made, changes=(*made.changes, *watching(configuration, made, signals)))
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
