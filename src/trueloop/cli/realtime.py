"""`trueloop realtime`: the machine's errors corrected in the servo thread of LinuxCNC."""

import math
import signal
import sys
import threading
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.options import NoStore, chosen
from trueloop.cli.program_file import parameters_of, vector_of
from trueloop.cli.shared_options import argument, option, positive
from trueloop.cli.terminal import AsJson, ExitStatus, Group, busy, print_json, print_lines, wide_console
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.controllers.linuxcnc.realtime.hal_lines import Change
    from trueloop.controllers.linuxcnc.realtime.signals.component import CheckedSignal
    from trueloop.jobs.realtime.image import ImageOptions
    from trueloop.realtime.image import Image
    from trueloop.realtime.judge import RunJudgement
    from trueloop.realtime.largest import Extent
    from trueloop_lab.realtime.demo import Demo

SamplesFile = Annotated[Path, argument("A run, as `trueloop realtime watch` records.", metavar="SAMPLES.csv")]
ModelFile = Annotated[Path, argument("The model that the image was made from.", metavar="MODEL.json")]
ImageFile = Annotated[Path | None, argument("The image: its table, tool and gate.", metavar="[IMAGE]")]


def check(
    samples: SamplesFile,
    model: ModelFile,
    image: ImageFile = None,
    limit_nm: Annotated[float, option("Most that may be left, nm RMS.", min=0.0)] = 2.0,
    slew: Annotated[float, option("Value of `rtec.slew` in the run, mm/s.", min=1e-6)] = 5.0,
    as_json: AsJson = False,
) -> None:
    """Judge a recorded run by the model itself. Exit status 1 when more is left, or a step was beyond the slew."""
    from trueloop.jobs.realtime.watched import check_run

    found = check_run(samples, model, image, slew_mm_per_s=slew)
    if as_json:
        print_json({**_figures(found), "limit_nm": limit_nm, "within": found.within(limit_nm)})
    else:
        for line in judged_lines(found):
            typer.echo(line)
    if not found.within(limit_nm):
        raise typer.Exit(ExitStatus.FINDINGS)


def demo(
    output: Annotated[Path, option("Folder for the results.", "--output", "-o")] = Path("out/realtime"),
    seed: Annotated[int, option("Of all noise.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Turn a part on a virtual lathe that warms up, in LinuxCNC.

    Without the corrector and with it.
    """
    from rich.console import Console

    from trueloop_lab.realtime.demo import demo as run

    with Console(stderr=True).status("starting") as status:
        made = run(output, seed, status.update)
    if as_json:
        print_json(_demo_figures(made))
        return
    for name, part in made.parts.items():
        typer.echo(f"{name + ':':<36} {part.rms_um:6.2f} µm RMS, {part.worst_um:6.2f} µm at the worst place")
    rms, worst = made.ratios
    typer.echo(f"{'with it to without errors:':<36} {rms:6.2f} x RMS, {worst:6.2f} x worst")
    typer.echo("left on the path in the cuts, normal to it, µm RMS:")
    for name, left in made.causes_um.items():
        typer.echo(f"  {name + ':':<56} {left:.3f}")
    for line in judged_lines(made.judged):
        typer.echo(line)
    typer.echo(f"written: {', '.join(str(file) for file in made.files)}")


def judged_lines(found: "RunJudgement") -> tuple[str, ...]:
    """Prints a judge's result as text."""
    return (
        f"{int(found.judged.sum())} periods judged: {found.rms_nm:.4f} nm RMS left, {found.worst_nm:.4f} nm at most, "
        f"of {found.uncorrected_um:.1f} µm RMS",
        f"{found.reversals} reversals: {int(found.limited.sum())} periods limited by the slew, "
        f"{1e3 * found.longest_limited_s:.0f} ms at most in a row, {found.behind_nm:.4f} nm off what it allows",
        f"largest step of the correction {found.step_um:.3f} µm a period, the slew allows {found.most_step_um:.3f} µm",
    )


def _figures(judgement: "RunJudgement") -> dict[str, float]:
    names = ("rms_nm", "worst_nm", "uncorrected_um", "reversals", "longest_limited_s", "behind_nm", "step_um")
    counts = {"judged": int(judgement.judged.sum()), "limited": int(judgement.limited.sum())}
    return counts | {name: getattr(judgement, name) for name in (*names, "most_step_um")}


def _demo_figures(made: "Demo") -> dict[str, object]:
    parts = {name: {"rms_um": part.rms_um, "worst_um": part.worst_um} for name, part in made.parts.items()}
    return {"parts": parts, "ratios": made.ratios, "left_um": made.causes_um, "judged": _figures(made.judged)}


def hal(
    ini: Annotated[Path, argument("The INI file that LinuxCNC is started with.", metavar="INI")],
    image: Annotated[Path | None, option("The image: its signals and its machine's serial go into the lines.")] = None,
    serial: Annotated[str | None, option("Refuse an image for a machine with another serial number.")] = None,
    job: Annotated[
        Path | None, option("Refuse an image for another machine, program or tool than the job's.", metavar="JOB.toml")
    ] = None,
    watch: Annotated[bool, option("Also the lines of a sampler, for `trueloop realtime watch`.", "--watch")] = False,
    as_json: AsJson = False,
) -> None:
    """Print the lines that put the corrector into a configuration.

    Each with its reason: the corrector stands between motion and the drives. Nothing is edited. A configuration that
    the corrector cannot be put into is refused, by what stands in the way. An image of another machine is refused by
    its travel, axes and serial number; with --job by model, program, tool too.
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


@dataclass(frozen=True, kw_only=True)
class OfMachine:
    """Which machine, and where it may be sent."""

    model: Annotated[
        Path | None, option("The machine's model, beside a job or a correction.", "--model", "-m", metavar="MODEL.json")
    ] = None
    serial: Annotated[str | None, option("Refuse a model of a machine with another serial number.")] = None
    tool: Annotated[
        str | None,
        option(
            "Tool point from the last axis' frame while no tool offset is in force, mm.  [default: 0,0,0]",
            metavar="X,Y,Z",
        ),
    ] = None
    travel: Annotated[
        list[str] | None, option("Where a drive may be sent, mm.  [default: the model's travel]", metavar="X=LOW,HIGH")
    ] = None
    standing: Annotated[
        list[str] | None, option("A rotary axis that stands at 0 while the image is in use.", metavar="A")
    ] = None


@dataclass(frozen=True, kw_only=True)
class OfSignals:
    """In which range signals are believed."""

    ranges: Annotated[
        list[str] | None,
        option("Range of a signal.  [default: that of the model's data]", "--range", metavar="T1=LOW,HIGH"),
    ] = None
    steps: Annotated[
        list[str] | None, option("Largest step between two readings.  [default: 2 °C]", "--step", metavar="T1=V")
    ] = None


@dataclass(frozen=True, kw_only=True)
class OfTable:
    """Where the program of a table stands."""

    origin: Annotated[
        str | None,
        option(
            "Machine coordinates of the program's zero, X as a radius, mm: work offset plus tool offset.  "
            "[default: as [machine] of the job states]",
            metavar="X,Z",
        ),
    ] = None
    tip: Annotated[int, option("LinuxCNC's orientation of the tool, where G41 is used.", min=0, max=9)] = 0
    db: Annotated[
        str | None,
        option(
            "Store of a record, and of a job's earlier parts.  "
            "[default: store.db of the job, else trueloop.db beside it]",
            metavar="FILE|URL",
        ),
    ] = None
    no_store: NoStore = False


def image(
    source: Annotated[
        str, argument("MODEL.json, JOB.toml, record.json, or the id of a kept record.", metavar="SOURCE")
    ],
    out: Annotated[Path, option("The image.", "--output", "-o", metavar="FILE.img")],
    of_machine: OfMachine,
    of_signals: OfSignals,
    of_table: OfTable,
    limit_um: Annotated[
        float, option("Largest correction of an axis that may pass.", min=0.001, callback=positive)
    ] = 150.0,
    gate_um: Annotated[
        float, option("Distance from its path at which a row of the table still holds.", min=0.001, callback=positive)
    ] = 100.0,
    as_json: AsJson = False,
) -> None:
    """Write the image that the component in LinuxCNC loads.

    It holds a model, a table by program line, or both. A table takes the place of the corrected program: one of the two
    is run, never both.
    """
    from trueloop.jobs.realtime.image import make_image

    options = _options(of_machine, of_signals, of_table, limit_um / UM_PER_MM, gate_um / UM_PER_MM)
    with busy(f"making an image of {source}"):
        made = make_image(source, options)
        content = made.write(out)
    for note in made.notes:
        typer.echo(f"note: {note}", err=True)
    _image_print(made.image, made.extent, out, content, as_json)


def show(
    file: Annotated[Path, argument("As `trueloop realtime image` wrote it.", metavar="FILE.img")],
    serial: Annotated[str | None, option("Refuse an image for a machine with another serial number.")] = None,
    program: Annotated[
        Path | None, option("Refuse an image whose table is for another program.", metavar="PROGRAM")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print what an image holds, and check it as the component does."""
    from trueloop.errors import Code
    from trueloop.formats.input_file import read_input
    from trueloop.formats.realtime.image_file import read_image
    from trueloop.realtime.largest import extent_of

    own = read_input(program, Code.NC_FILE, hint="name the program that is to be run") if program else None
    read = read_image(file, serial=serial, program=own)
    _image_print(read, extent_of(read), file, file.read_bytes(), as_json)


def _image_print(image: "Image", extent: "Extent", file: Path, content: bytes, as_json: bool) -> None:
    from trueloop.domain.record import sha256_of
    from trueloop.report.realtime.image_summary import image_lines, image_summary

    if as_json:
        known = {"file": str(file), "bytes": len(content), "sha256": sha256_of(content)}
        print_json({**known, **image_summary(image, extent)})
        return
    print_lines([*image_lines(image, extent), f"{file}: {len(content)} bytes, sha256 {sha256_of(content)}"])


def _options(machine: OfMachine, signals: OfSignals, table: OfTable, limit_mm: float, gate_mm: float) -> "ImageOptions":
    from trueloop.jobs.realtime.image import ImageOptions
    from trueloop.realtime.image import SignalLimits

    return ImageOptions(
        model=machine.model,
        serial=machine.serial,
        tool_mm=vector_of(machine.tool, "--tool") if machine.tool else (0.0, 0.0, 0.0),
        travel_mm={axis.upper(): ends for axis, ends in _pairs(machine.travel, "--travel").items()},
        limit_mm=limit_mm,
        gate_mm=gate_mm,
        stated=SignalLimits(_pairs(signals.ranges, "--range"), parameters_of(signals.steps, "--step")),
        standing=tuple(machine.standing or ()),
        origin_mm=_pair(table.origin, "--origin") if table.origin else None,
        tip=table.tip,
        db=chosen(table.db, table.no_store),
    )


def _pairs(texts: list[str] | None, option: str) -> dict[str, tuple[float, float]]:
    """`["T1=15,35"]` as {"T1": (15, 35)}."""
    split = [text.rpartition("=") for text in texts or ()]
    return {name.strip(): _pair(ends, option) for name, _, ends in split}


def _pair(text: str, option: str) -> tuple[float, float]:
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        first = second = math.nan
    if not (math.isfinite(first) and math.isfinite(second)):
        raise typer.BadParameter(f"{text!r} is not two numbers with a comma between them", param_hint=option)
    return first, second


def install(
    to: Annotated[Path | None, option("Folder for rtec.so.  [default: LinuxCNC's folder of modules]")] = None,
    keep_source: Annotated[Path | None, option("Folder for what was compiled: C, header and object file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Compile and install the component for this LinuxCNC.

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


ConfigFile = Annotated[Path, argument("Sources, and which signal is found where in them.", metavar="CONFIG.toml")]


def signals(
    file: ConfigFile,
    check: Annotated[
        bool, option("Read every source once, print values and ages; needs no LinuxCNC.", "--check")
    ] = False,
    wait_s: Annotated[
        float, option("Longest wait of --check for a source, s.", "--wait", metavar="S", min=0.1, max=600)
    ] = 5.0,
    as_json: AsJson = False,
) -> None:
    """Feed the corrector its signals (component rtec-signals).

    Signals, their ages, and the program that runs. LinuxCNC starts it: `loadusr -Wn rtec-signals trueloop realtime
    signals CONFIG.toml` in its HAL file.
    """
    from trueloop.jobs.realtime import wired as job

    if check:
        found = job.check(file, wait_s)
        _print(found, as_json=as_json)
        if any(one.fault for one in found):
            raise typer.Exit(ExitStatus.FINDINGS)
        return
    stop = threading.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())
    job.run(file, stop, lambda text: print(f"rtec-signals: {text}", file=sys.stderr, flush=True))


def _print(signals: "list[CheckedSignal]", *, as_json: bool) -> None:
    if as_json:
        print_json({"signals": [asdict(read) for read in signals]})
        return
    from rich.table import Table

    table = Table("signal", "source", "value", "age, s", "range", "")
    for read in signals:
        value, age = ("-" if number is None else f"{number:.3f}" for number in (read.value, read.age_s))
        table.add_row(read.name, read.source, value, age, f"{read.low:g} … {read.high:g}", read.fault or "good")
    wide_console().print(table)


def watch(
    out: Annotated[
        Path | None, option("Folder of the record.  [default: watch-DATE-TIME]", "--out", "-o", metavar="DIR")
    ] = None,
    image: Annotated[
        Path | None, option("The image that the corrector has loaded: names its signals.", metavar="FILE")
    ] = None,
    seconds: Annotated[float | None, option("Stop after that.", "--for", metavar="SECONDS", min=0.1)] = None,
    host: Annotated[str, option("Address at which the live page is served.")] = "127.0.0.1",
    port: Annotated[int, option("Port of the live page; 0: a free one.", min=0, max=65535)] = 0,
    rows: Annotated[int, option("Rows of one file of the record.", min=1000)] = 3_600_000,
    keep: Annotated[int | None, option("Keep this many files, the last ones.  [default: all]", min=1)] = None,
    cell: Annotated[
        Path | None, option("Settings of the machine's cell: its service shows the trace too.", metavar="CELL.toml")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Record the corrector of the LinuxCNC here, until Ctrl-C.

    Every servo period goes into samples.csv; a live page shows command, correction by cause, signals, state and times;
    at the end a page of the run is written. LinuxCNC needs a sampler on the corrector: see `realtime hal --watch`.
    """
    from trueloop.jobs.realtime.watched import Order
    from trueloop.jobs.realtime.watched import watch as watched

    folder = out or Path(f"watch-{datetime.now():%Y%m%d-%H%M%S}")
    stop: list[int] = []
    before = {signals: signal.signal(signals, lambda number, frame: stop.append(number)) for signals in STOPS}
    try:
        result = watched(
            Order(folder=folder, image=image, seconds=seconds, host=host, port=port, rows=rows, keep=keep, cell=cell),
            lambda: bool(stop),
            lambda words: typer.echo(words, err=True),
        )
    finally:
        for signals, handler in before.items():
            signal.signal(signals, handler)
    if as_json:
        files = [str(file) for file in result.files]
        counts = {"periods": result.periods, "lost": result.lost, "faults": result.faults}
        print_json({"files": files, "page": str(result.page), **counts, "ended": result.ended})
        return
    typer.echo(
        f"{result.ended}: {result.periods} periods recorded, {result.lost} lost, {result.faults} faults or bad signals"
    )
    for file in (*result.files, result.page):
        typer.echo(f"written: {file}")


STOPS = (signal.SIGINT, signal.SIGTERM)


app = Group("LinuxCNC corrects the machine's errors in its servo thread. Image, component, signals, watching.")
app.add_all(image, install, hal, show, signals, watch, check, demo)


@app.callback()
def _real_time() -> None:
    pass
