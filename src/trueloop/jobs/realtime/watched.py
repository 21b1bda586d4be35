"""Watching a run: every period into samples.csv, the live page while it goes on, a page of it at the end.

A thread of its own reports to the service twice a second, so that no record waits for the network.
"""

import json
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from datetime import datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import numpy as np

from trueloop.controllers.linuxcnc.cell.client import Service
from trueloop.controllers.linuxcnc.realtime.watch import Watched, attached
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.formats.realtime.image_file import read_image
from trueloop.formats.realtime.samples_csv import Recording, read_samples
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.cell import opened
from trueloop.machine.model.chain import ZERO, Vector
from trueloop.realtime.image import Image
from trueloop.realtime.judge import DrivenRun, RunJudgement, judge
from trueloop.realtime.samples import (
    NONE,
    Envelope,
    Event,
    Samples,
    Tally,
    counted,
    empty,
    events,
    gathered,
    signal_columns,
)
from trueloop.report.realtime.page import run_page
from trueloop.report.realtime.run import RunPage, Trace, live_page, silence, timing_of, told, trace_names

KEPT: Final = 600
"""History that a browser gets first: a minute."""
POLL_S: Final = 1.0
LOCAL: Final = "127.0.0.1"


class LiveServer:
    """Serves from its own threads until it is closed. Raises RTC-CONNECTION where the address is not to be had."""

    def __init__(self, page: str, host: str = LOCAL, port: int = 0) -> None:
        self._kept: deque[str] = deque(maxlen=KEPT)
        self._count, self._end = 0, ""
        self._changed = threading.Condition()
        try:
            self._server = ThreadingHTTPServer((host, port), _handler(self, page.encode()))
        except (OSError, OverflowError) as error:
            raise Code.RTC_CONNECTION.refusal(
                f"the live page cannot be served at {host}:{port}: {error}",
                hint="another program may have that port: leave --port out, and a free one is taken",
            ) from error
        self._server.daemon_threads = True
        self._server.block_on_close = False
        self.host, self.port = host, int(self._server.server_address[1])
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """Returns the address of the page."""
        return f"http://{self.host}:{self.port}/"

    def tell(self, tick: Mapping[str, Any]) -> None:
        """Sends a tick to all browsers, those included that come later."""
        with self._changed:
            self._kept.append(json.dumps(tick, ensure_ascii=False, allow_nan=False))
            self._count += 1
            self._changed.notify_all()

    def close(self, why: str) -> None:
        """Tells every browser why, and ends."""
        with self._changed:
            self._end = why
            self._changed.notify_all()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def __enter__(self) -> "LiveServer":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close("the record has ended")

    def after(self, count: int) -> tuple[int, list[str], str]:
        """Returns the ticks after so many; waits for them a while. The third is why it has ended, or ""."""
        with self._changed:
            if count == self._count and not self._end:
                self._changed.wait(POLL_S)
            new = min(self._count - count, len(self._kept))
            return self._count, list(self._kept)[len(self._kept) - new :], self._end


def _handler(live: LiveServer, page: bytes) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        """One request of a browser."""

        def do_GET(self) -> None:
            """Serves the page, its events, and nothing else."""
            if live.host == LOCAL and not _is_local(self.headers.get("Host", "")):
                self.send_error(403)  # a page from elsewhere whose name leads here
            elif self.path == "/":
                self._send("text/html; charset=utf-8")
                self.wfile.write(page)
            elif self.path == "/events":
                self._send("text/event-stream")
                self._events()
            else:
                self.send_error(404)

        def _send(self, kind: str) -> None:
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Cache-Control", "no-store")
            self.end_headers()

        def _events(self) -> None:
            seen, end = 0, ""
            try:
                while not end:
                    seen, new, end = live.after(seen)
                    said = f"data: [{','.join(new)}]\n\n" if new else ": waiting\n\n"
                    self.wfile.write((said + (f"event: end\ndata: {end}\n\n" if end else "")).encode())
                    self.wfile.flush()
            except OSError:  # the browser has gone
                return

        def log_message(self, format: str, *args: object) -> None:
            """Requests are not news."""

    return Handler


def _is_local(host: str) -> bool:
    return host.rpartition(":")[0] in (LOCAL, "localhost")


EVERY_S: Final = 0.5
MOST: Final = 100
"""Stretches that wait: what is older the service does not miss."""


class ToldService:
    """Takes what the live page is told. What the service does not take is dropped, and said once until it takes again.

    `record` names the record, `axes` and `signals` what it is of; `tell` is told where the service is not reached.
    """

    def __init__(
        self, service: Service, record: str, axes: str, signals: tuple[str, ...], tell: Callable[[str], None]
    ) -> None:
        self._service, self._tell = service, tell
        self._head: dict[str, Any] = {"record": record, "axes": axes, "signals": list(signals)}
        self._waiting: deque[Mapping[str, Any]] = deque(maxlen=MOST)
        self._stop = threading.Event()
        self._said = ""
        self._thread = threading.Thread(target=self._work, daemon=True)

    def take(self, tick: Mapping[str, Any]) -> None:
        """Queues one stretch as `report.realtime.live.told` gives it; silence is none."""
        if "from" in tick:
            values = {name: tick[name] for name in ("low", "high", "alarm", "said")}
            self._waiting.append({"from_s": tick["from"], "to_s": tick["to"], **values})

    def send(self) -> None:
        """Sends what waits, at once."""
        stretches = [self._waiting.popleft() for _ in range(len(self._waiting))]
        if not stretches:
            return
        try:
            self._service.trace({**self._head, "stretches": stretches})
            self._said = ""
        except TrueloopError as error:
            if error.message != self._said:
                self._tell(f"the service does not show it: {error.message}")
            self._said = error.message

    def __enter__(self) -> "ToldService":
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._stop.set()
        self._thread.join()
        self._service.close()

    def _work(self) -> None:
        while not self._stop.wait(EVERY_S):
            self.send()
        self.send()


WAIT_S: Final = 0.2
SILENT_S: Final = 1.0
MOST_EVENTS: Final = 10_000
ROWS: Final = 3_600_000
"""Rows of a file: an hour at 1 kHz."""


@dataclass(frozen=True)
class Order:
    """Options of a watch: its source and output. `seconds` None: until it is stopped. `keep` None: all files of the
    record.

    `cell`: the settings of the machine's cell, whose service shows it too; None: no service.
    """

    folder: Path
    image: Path | None = None
    seconds: float | None = None
    host: str = LOCAL
    port: int = 0
    rows: int = ROWS
    keep: int | None = None
    cell: Path | None = None


@dataclass
class RunData:
    """The data of a run for its page, in bounded room."""

    drawn: Envelope
    happened: list[Event] = field(default_factory=list)
    fault: Event | None = None
    periods: int = 0
    lost: int = 0
    write: Tally = NONE
    thread: Tally = NONE
    last_s: float | None = None

    def take(self, samples: Samples) -> None:
        """Appends periods."""
        new = events(samples, self.happened[-1] if self.happened else None)
        self.happened = (self.happened + new)[-MOST_EVENTS:]
        self.fault = next((event for event in reversed(new) if event.alarming), self.fault)
        self.periods += len(samples)
        since = self.last_s if self.last_s is not None else float(samples.time_s[0]) - samples.period_s
        self.lost += round((float(samples.time_s[-1]) - since) / samples.period_s) - len(samples)
        self.last_s = float(samples.time_s[-1])
        self.drawn = gathered(self.drawn, samples)
        self.write = counted(self.write, samples.columns["write_ns"])
        self.thread = counted(self.thread, samples.columns["thread_ns"])


@dataclass(frozen=True)
class Result:
    """The result. `ended`: why the record ends."""

    files: tuple[Path, ...]
    page: Path
    periods: int
    lost: int
    faults: int
    ended: str


def watch(order: Order, stopped: Callable[[], bool], tell: Callable[[str], None] = lambda words: None) -> Result:
    """Records until it is stopped, the time is up, or LinuxCNC ends. `tell` gets the live page's address.

    Raises RTC-CONNECTION where there is nothing to record, RTC-IMAGE for a file that is none, OUT-FOLDER where nothing
    can be written, CEL-FILE for settings of a cell that cannot be used. A service that is not reached ends nothing.
    """
    service = None if order.cell is None else opened(order.cell).service
    image = read_image(order.image) if order.image else None
    signals = image.bank.signals if image and image.bank else ()
    began = datetime.now().astimezone()
    with attached([(signal.name, signal.unit) for signal in signals] if image else None) as watched:
        layout = watched.layout
        title = image.identity.machine or "LinuxCNC" if image else "LinuxCNC"
        page = live_page(title, layout.axes, layout.signals)
        told_too = (
            nullcontext()
            if service is None
            else ToldService(service, f"{began:%Y%m%d-%H%M%S}", layout.axes, layout.signals, tell)
        )
        with LiveServer(page, order.host, order.port) as live, told_too as shown:
            recording = Recording(order.folder, layout.axes, layout.signals, order.rows, order.keep)
            tell(f"live page: {live.address}")
            seen = RunData(empty(trace_names(layout.axes, layout.signals), layout.period_s))
            try:
                takers = [live.tell, *([] if shown is None else [shown.take])]
                ended = _record(watched, recording, takers, seen, order.seconds, stopped)
            finally:
                recording.close()
    if not seen.periods:
        raise Code.RTC_CONNECTION.refusal(
            "0 periods came: the servo thread stands, or another program reads the sampler",
            hint="one reader a stream: end other halsampler or watch commands",
        )
    content = run_page(_page(seen, watched, title, began, image))
    (written,) = write_all(order.folder, [("report.html", content.encode())])
    faults = sum(event.alarming for event in seen.happened)
    kept = tuple(file for file in recording.files if file.exists())
    return Result(files=kept, page=written, periods=seen.periods, lost=seen.lost, faults=faults, ended=ended)


def _record(
    watched: Watched,
    recording: Recording,
    takers: Sequence[Callable[[Mapping[str, Any]], None]],
    run: RunData,
    seconds: float | None,
    stopped: Callable[[], bool],
) -> str:
    """Runs until something ends it, and returns the reason. `takers` get the data as it goes on."""
    began = heard = time.monotonic()
    while True:
        samples = watched.periods(WAIT_S)
        now = time.monotonic()
        if samples is None:
            return "LinuxCNC ended"
        if len(samples):
            heard = now
            recording.add(samples)
            run.take(samples)
            _tell(takers, told(samples, run.happened[-1], run.fault, run.periods, run.lost))
        elif now - heard > SILENT_S:
            _tell(takers, silence(now - heard))
        if stopped():
            return "stopped"
        if seconds is not None and now - began >= seconds:
            return "time is up"


def _tell(takers: Sequence[Callable[[Mapping[str, Any]], None]], tick: Mapping[str, Any]) -> None:
    for take in takers:
        take(tick)


def _page(run: RunData, watched: Watched, title: str, began: datetime, image: Image | None) -> RunPage:
    layout = watched.layout
    trace = Trace(
        axes=layout.axes,
        signals=layout.signals,
        envelope=run.drawn,
        events=tuple(run.happened),
        periods=run.periods,
        lost=run.lost,
        period_s=layout.period_s,
    )
    conditions = {
        "began": began.isoformat(sep=" ", timespec="seconds"),
        "length": f"{run.periods * layout.period_s:.3f} s",
        "servo period": f"{1e3 * layout.period_s:g} ms",
        "clock of the times": f"{layout.clocks_per_ns:.6f} counts a ns",
    }
    if image:
        conditions |= {
            "machine": " ".join(filter(None, (image.identity.machine, image.identity.serial))),
            "program of the table": image.identity.program or "no table",
        }
    timings = (timing_of("rtec.write", run.write), timing_of("whole servo thread", run.thread))
    return RunPage(title, verdict=_verdict(run), conditions=conditions, trace=trace, timings=timings)


def _verdict(run: RunData) -> str:
    bad = sum(event.alarming for event in run.happened)
    recorded = f"{run.periods} periods recorded, {run.lost} lost"
    if not bad:
        return f"{recorded}; no fault, no bad signal."
    assert run.fault is not None
    return f"{recorded}; {bad} faults or bad signals, the last at {run.fault.time_s:.3f} s: {run.fault.in_words()}."


FOLLOWS = (2, 3)
"""Phases in which the correction is in force, or on its way."""

OWN_PROGRAM = 1


def check_run(
    samples: FilePath, model: FilePath, image: FilePath | None = None, *, slew_mm_per_s: float = 5.0
) -> RunJudgement:
    """Judges a run by the model, with the `image` by its table too. Raises RTC-SAMPLES, RTC-IMAGE, MCH-FILE."""
    recorded, known = read_samples(samples), read_model(model, offered=True)
    held = read_image(image) if image is not None else None
    bank = held.bank if held else None
    names = [(s.name, s.unit) for s in bank.signals] if bank else [(n, known.units.get(n, "")) for n in known.needs()]
    blocks, gate = (held.blocks, held.limits.gate_mm) if held else ((), 0.1)
    run = driven_run(recorded, names, bank.tool_mm if bank else ZERO, str(samples))
    return judge(run, known, blocks, slew_mm_per_s=slew_mm_per_s, gate_mm=gate)


def driven_run(samples: Samples, signals: Sequence[tuple[str, str]], tool_mm: Vector, file: str) -> DrivenRun:
    """Prepares a run to be judged. `signals`: name and unit of each; `tool_mm` while no tool offset is in force."""
    columns = signal_columns(signals)
    missing = [column for column in columns if column not in samples.signals]
    in_force = np.isin(samples.count("phase"), FOLLOWS)
    if missing:
        why = f"{len(missing)} of {len(columns)} signals of the model are not recorded: {', '.join(missing)}"
        raise _refusal(file, why, "judge it by the model that its image was made from")
    if samples.lost:
        raise _refusal(file, f"{samples.lost} periods were not recorded", "record it again with less beside it")
    if not in_force.any():
        raise _refusal(file, f"the correction is in force in 0 of {len(samples)} periods", "enable the corrector")
    return DrivenRun(
        period_s=samples.period_s,
        command_mm=samples.mm("command"),
        drive_mm=samples.mm("drive"),
        signals={name: samples.columns[column] for (name, _), column in zip(signals, columns, strict=True)},
        line=np.where(samples.count("program") == OWN_PROGRAM, samples.count("line"), 0),
        in_force=in_force,
        tool_mm=np.asarray(tool_mm) - samples.mm("tool"),
    )


def _refusal(file: str, message: str, hint: str) -> TrueloopError:
    return Code.RTC_SAMPLES.refusal(message, hint=hint, place=Place(file))
