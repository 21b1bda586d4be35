"""`trueloop nc translate`: a program written in another dialect."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.program_file import ProgramFile, Reading
from trueloop.cli.terminal import AsJson, busy, print_json


@guarded
def translate_program_file(
    file: ProgramFile,
    to: Annotated[str, typer.Option("--to", metavar="D", help="The dialect to write: linuxcnc, fanuc-lathe …")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="The program to be written.")],
    reading: Reading,
    decimals: Annotated[
        int | None,
        typer.Option(min=0, max=9, help="Decimals of coordinates.  [default: the control's or the source's]"),
    ] = None,
    accept_losses: Annotated[
        bool, typer.Option("--accept-losses", help="Write it though the machine will move otherwise.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write a program in another dialect, by its tool path, and print what is lost.

    Nothing is written when a loss would change how the machine moves, unless --accept-losses is given.
    """
    from trueloop.errors import Code, Severity, TrueloopError
    from trueloop.formats.outputs import write_all
    from trueloop.nc.translate.translate import translate

    with busy(f"translating {file}"):
        program = reading.program(file)
        made = translate(program, to, reading.parameters, skipped_blocks=reading.skipped_blocks, decimals=decimals)
    errors = [loss for loss in made.losses if loss.severity is Severity.ERROR]
    refused = bool(errors) and not accept_losses
    if not as_json:
        for loss in made.losses:
            typer.echo(str(loss), err=True)
    if refused:
        raise TrueloopError(
            Code.NC_LOST,
            f"{len(errors)} losses would change how the machine moves; nothing was written",
            hint=errors[0].hint,
            place=errors[0].place,
            override="--accept-losses",
        )
    write_all(out.parent, [(out.name, made.source)], inputs=(file,))
    if as_json:
        print_json({name: value for name, value in asdict(made).items() if name != "source"} | {"file": str(out)})
        return
    typer.echo(
        f"written: {out}, {to}, {made.blocks} blocks of {made.moves} moves, {made.decimals} decimals, positions "
        f"rounded by {made.rounded_mm:.6f} mm at most; {len(made.losses)} losses, {len(errors)} of them errors"
    )
