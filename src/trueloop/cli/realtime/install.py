"""`trueloop realtime install`: the component compiled where it shall run."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, print_json, print_lines


@guarded
def install(
    to: Annotated[
        Path | None, typer.Option("--to", help="Folder for rtec.so.  [default: LinuxCNC's folder of modules]")
    ] = None,
    keep_source: Annotated[
        Path | None,
        typer.Option("--keep-source", help="Folder for what was compiled: C, header and object file."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Compile the component for this computer's LinuxCNC and install it.

    Needs LinuxCNC's package for developers, not Rust. Where root's rights are needed, says the command.
    """
    from trueloop.controllers.linuxcnc.realtime.install import install as put_in_place

    done = put_in_place(to, keep_source)
    if as_json:
        print_json(
            {
                "linuxcnc": done.version,
                "module": str(done.module),
                "sources": None if done.sources is None else str(done.sources),
                "command": done.command,
            }
        )
        return
    lines = [f"LinuxCNC {done.version}: rtec.so compiled; nothing in it panics or allocates."]
    if done.sources is not None:
        lines.append(f"Its sources are in {done.sources}.")
    if done.command is None:
        lines.append(f"Installed as {done.module}. `trueloop realtime hal` prints the lines for a configuration.")
    else:
        lines += [f"{done.module.parent} is root's: rtec.so is here. To install it run", f"    {done.command}"]
    print_lines(lines)
