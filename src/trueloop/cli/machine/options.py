"""What the commands of `trueloop machine` take, and reading it."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.program_file import parameters_of, vector_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from trueloop.arrays import Array
    from trueloop.machine.model.chain import Vector
    from trueloop.machine.model.model import MachineModel

MachineFile = Annotated[Path, typer.Argument(metavar="MACHINE.toml", help="Structure, travels and error terms.")]
ReadingFiles = Annotated[list[Path], typer.Argument(metavar="READINGS.csv", help="Laser, straight edge, ball bar …")]
ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.json", help="As `trueloop machine fit` wrote it.")]
ModelOption = Annotated[Path, typer.Option("--model", "-m", metavar="MODEL.json", help="The machine's model.")]
Temperatures = Annotated[
    list[str] | None,
    typer.Option(
        "--temperatures",
        "-t",
        metavar="T1=V",
        help="Value of a signal of the model, or LOG.csv, its past until now; may be repeated.",
    ),
]
HistoryFile = Annotated[
    Path | None,
    typer.Option("--history", metavar="LOG.csv", help="Log of temperatures and speeds on the clock of the readings."),
]
Extrapolate = Annotated[
    list[str] | None,
    typer.Option("--extrapolate", metavar="NAME", help="Axis or signal that may leave the range of the data."),
]


def signals_of(
    model: "MachineModel", given: "Sequence[str] | None", until_s: float = math.inf
) -> "dict[str, Array | float]":
    """Values by name, and logs as they stand at their last row until then, lags among them. Raises MCH-HISTORY."""
    from trueloop.jobs.machine import machine_model

    values = parameters_of([text for text in given or () if "=" in text], "--temperatures")
    return machine_model.signals_of(model, logs_of(given), values, until_s)


def logs_of(given: "Sequence[str] | None") -> list[Path]:
    """What of the values given are files: without an equals sign."""
    return [Path(text) for text in given or () if "=" not in text]


def positions_of(model: "MachineModel", given: "Sequence[str] | None") -> dict[str, float]:
    """`["Y=12", "A=30"]` as mm and rad. Raises MCH-AXIS for an axis that the machine does not have."""
    from trueloop.machine.model.chain import AxisKind

    chain = model.machine.chain
    rotary = {axis.name for axis in chain.axes if axis.kind is not AxisKind.LINEAR}
    values = parameters_of(given, "--at")
    return {chain.axis(name).name: math.radians(v) if name in rotary else v for name, v in values.items()}


def numbered(texts: "Sequence[str]", option: str) -> "dict[int, Vector]":
    """`["1=10,20,30"]` as {1: (10, 20, 30)}; `*` is −1: any other."""
    found = {}
    for text in texts:
        number, _, vector = (part.strip() for part in text.partition("="))
        if not number.isdigit() and number != "*":
            raise typer.BadParameter(f"{text!r} is no number=X,Y,Z", param_hint=option)
        found[-1 if number == "*" else int(number)] = vector_of(vector, option)
    return found
