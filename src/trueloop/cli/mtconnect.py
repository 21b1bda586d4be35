"""`trueloop mtconnect`: reports LinuxCNC's state to agents, and reads what agents hold."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from trueloop.cli.shared_options import argument, option
from trueloop.cli.terminal import AsJson, Group, print_json, print_table

if TYPE_CHECKING:
    from trueloop.controllers.mtconnect.agent import ItemObservation
    from trueloop.controllers.mtconnect.items import Machine

app = Group("MTConnect: an adapter beside LinuxCNC, and a reader of agents.")


@dataclass(frozen=True, kw_only=True)
class Of:
    """The items reported, by machine."""

    device: Annotated[str, option("The machine's name in the device model.")] = "linuxcnc"
    axes: Annotated[str, option("Letters of its axes.")] = "XZ"
    temperature: Annotated[
        list[str] | None, option("A HAL pin that holds a temperature, °C; repeatable.", metavar="NAME=PIN")
    ] = None
    correction: Annotated[
        list[str] | None, option("A HAL pin that holds a correction, mm; repeatable.", metavar="AXIS=PIN")
    ] = None
    part_count: Annotated[str, option("A HAL pin that counts parts.", metavar="PIN")] = ""

    def machine(self) -> "Machine":
        """Returns the machine of the options. Raises MTC-NAME."""
        from trueloop.controllers.mtconnect.items import Machine

        temperatures, corrections = (_pairs(given or ()) for given in (self.temperature, self.correction))
        return Machine(self.device, self.axes, temperatures, corrections, self.part_count)


def _pairs(texts: Sequence[str]) -> dict[str, str]:
    pairs = [one.partition("=") for one in texts]
    for (name, _, pin), text in zip(pairs, texts, strict=True):
        if not name or not pin:
            raise typer.BadParameter(f"{text!r} is not NAME=PIN")
    return {name: pin for name, _, pin in pairs}


@app.command()
def devices(
    of: Of, output: Annotated[Path | None, option("The file.  [default: it is printed]", "--output", "-o")] = None
) -> None:
    """Write Devices.xml, with which an agent is started.

    Options as for `serve`.
    """
    from trueloop.controllers.mtconnect.items import devices_xml
    from trueloop.formats.outputs import write_all

    content = devices_xml(of.machine())
    if output is None:
        typer.echo(content.decode(), nl=False)
        return
    (written,) = write_all(output.parent, [(output.name, content)])
    typer.echo(f"written: {written}", err=True)


@app.command()
def serve(
    of: Of,
    host: Annotated[str, option("Address to listen at.")] = "127.0.0.1",
    port: Annotated[int, option("0: any that is free.", min=0, max=65535)] = 7878,
    silent_s: Annotated[
        float, option("LinuxCNC's status older than this is UNAVAILABLE.", "--silent", metavar="S", min=0.5)
    ] = 2.0,
    temperature_age_s: Annotated[
        float, option("And temperatures older than this.", "--temperature-age", metavar="S", min=0.5)
    ] = 60.0,
    part_file: Annotated[Path | None, option("A file whose first line names the part in the machine.")] = None,
    python: Annotated[Path, option("The Python that has LinuxCNC's modules.")] = Path("/usr/bin/python3"),
) -> None:
    """Send LinuxCNC's state to agents, until Ctrl-C.

    SHDR over TCP; SIGTERM ends it as well.
    """
    import ipaddress

    from trueloop.controllers.mtconnect.agent import Limits
    from trueloop.controllers.mtconnect.run import Source, listening, run

    source = Source(of.machine(), Limits(silent_s, temperature_age_s), python, part_file)
    socket = listening(host, port)
    at = socket.getsockname()
    if not ipaddress.ip_address(at[0]).is_loopback:
        typer.echo("note: SHDR knows no password: whoever reaches this port reads it", err=True)
    typer.echo(f"adapter of {of.device} at {at[0]}:{at[1]}", err=True)
    run(source, socket, lambda text: typer.echo(f"mtconnect: {text}", err=True))


@app.command()
def read(
    url: Annotated[str, argument("The agent's address, such as http://10.0.0.7:5000/lathe.", metavar="URL")],
    seconds: Annotated[float, option("Duration; 0: the current values.", metavar="N", min=0)] = 0.0,
    kind: Annotated[
        list[str] | None, option("Only items of it, TEMPERATURE, PROGRAM …; repeatable.", "--type", metavar="TYPE")
    ] = None,
    out: Annotated[Path | None, option("Observations to a CSV file, a new one.", "--out", "-o")] = None,
    log: Annotated[Path | None, option("Temperatures to a log as `machine` commands read them, a new file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Read an agent: its current values, then each new one.

    Gaps are reported.
    """
    from trueloop.controllers.mtconnect.agent import for_seconds
    from trueloop.controllers.mtconnect.agent import read as observations

    wanted = {one.upper() for one in kind or ()}
    seen = observations(url, for_seconds(seconds), lambda text: typer.echo(f"note: {text}", err=True))
    found = [observation for observation in seen if not wanted or observation.item.type.upper() in wanted]
    for file in _keep(url, found, out, log):
        typer.echo(f"written: {file}", err=True)
    if as_json or (out is None and log is None):
        _show(found, as_json=as_json)


COLUMNS: Final = ("item", "name", "type", "units", "time", "sequence", "value")


def _keep(url: str, observations: "Sequence[ItemObservation]", out: Path | None, log: Path | None) -> list[Path]:
    """Writes the files that options name; refuses to overwrite one."""
    from trueloop.controllers.mtconnect.agent import temperature_log
    from trueloop.formats.outputs import write_all

    files = [(out, _csv(observations))] if out else []
    files += [(log, temperature_log(url, observations))] if log else []
    written: list[Path] = []
    for path, text in files:
        written += write_all(path.parent, [(path.name, text.encode())], [path] if path.exists() else [])
    return written


def _show(observations: "Sequence[ItemObservation]", *, as_json: bool) -> None:
    """Prints a machine's state on stdout."""
    rows = [_row(observation) for observation in observations]
    if as_json:
        print_json({"observations": [dict(zip(COLUMNS, row, strict=True)) for row in rows]})
    else:
        print_table(COLUMNS, [[str(cell) for cell in row] for row in rows])


def _csv(observations: "Sequence[ItemObservation]") -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_row(observation) for observation in observations)
    return text.getvalue()


def _row(observation: "ItemObservation") -> tuple[str | int, ...]:
    return (
        observation.item.id,
        observation.item.name,
        observation.item.type,
        observation.item.units,
        observation.stamp,
        observation.sequence,
        observation.value,
    )
