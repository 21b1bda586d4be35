"""Reads the streams of HAL's `sampler` that are wired to the corrector; run by LinuxCNC's own Python, which has `hal`.

Prints one line of JSON, {"error": …} or what the streams hold, then rows as doubles: the pins of all streams in order,
joined by the count of periods at the head of each. It ends when its stdin is closed, or with LinuxCNC.
"""

import array
import ctypes
import json
import os
import select
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

import hal

PERIODS = "rtec.periods"
MOST_STREAMS = 8
POLL_S = 0.1


def main() -> None:
    """Attaches to the streams, describes them in one line, passes their rows on."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started this, and who then closes stdin
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(0))
    component = hal.component(f"trueloop-watch-{os.getpid()}")
    component.ready()
    try:
        streams, head = attach(component)
        say(head)
        if streams:
            pass_on(streams)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    finally:
        component.exit()


def say(head: "dict[str, object]") -> None:
    """Writes one line of JSON."""
    sys.stdout.buffer.write(json.dumps(head).encode() + b"\n")
    sys.stdout.buffer.flush()


def attach(component: Any) -> "tuple[list[Any], dict[str, object]]":
    """Attaches to the streams whose first pin is the count of periods; returns them and what their pins are on."""
    pins = shown("pin")
    if not hal.component_exists("rtec"):
        others = sorted({words[0] for words in pins} - {component.getprefix()})
        return [], {"error": "no rtec", "found": others}
    thread = next((words for words in shown("thread") if "rtec.write" in words), None)
    if thread is None:
        return [], {"error": "no thread", "found": []}
    names, signals = linked(pins)
    beside: dict[str, list[str]] = {}
    for pin, on in signals.items():
        beside.setdefault(on, []).append(pin)
    streams, columns = [], []
    seen: set[str] = set()
    for k in range(MOST_STREAMS):
        mine = [name for name in names if name.startswith(f"sampler.{k}.pin.")]
        mine.sort(key=lambda name: int(name.rsplit(".", 1)[1]))
        wired = [
            [one for one in beside.get(signals.get(name, ""), []) if not one.startswith("sampler.")] for name in mine
        ]
        new = {one for beside_one in wired for one in beside_one} - seen
        if wired and PERIODS in wired[0] and new:  # else it is there for another reader, and a record has only one
            seen |= new
            streams.append(hal.stream(component, hal.sampler_base + k))
            columns.append(wired)
    return streams, {
        "columns": columns,
        "period_ns": int(thread[0]),
        "clocks_per_ns": clocks_per_ns(),
        "signals": int(hal.get_value("rtec.signals")),
        "mm_per_unit": float(hal.get_value("rtec.mm-per-unit")),
        "samplers": sum(name.endswith(".sample-num") for name in names),
    }


def shown(what: str) -> "list[list[str]]":
    """Returns what `halcmd show` lists, a list of words a line."""
    done = subprocess.run(
        ["halcmd", "-s", "show", what], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False
    )
    return [line.split() for line in done.stdout.decode().splitlines() if line.strip()]


def linked(pins: "list[list[str]]") -> "tuple[list[str], dict[str, str]]":
    """Returns all names of pins, and the signal of each that has one: "owner type direction value name <== signal"."""
    names: list[str] = []
    signals: dict[str, str] = {}
    for words in pins:
        arrow = next((k for k, word in enumerate(words) if word in ("<==", "==>", "<=>")), None)
        names.append(words[4] if len(words) > 4 else "")
        if arrow is not None:
            signals[words[arrow - 1]] = words[arrow + 1]
    return names, signals


def clocks_per_ns() -> float:
    """Times are counts of the processor's clock; where a LinuxCNC has none, they are nanoseconds."""
    try:
        library = ctypes.CDLL("liblinuxcnchal.so.0")
        clocks, now = library.rtapi_get_clocks, library.rtapi_get_time
    except (OSError, AttributeError):
        return 1.0
    clocks.restype = now.restype = ctypes.c_longlong
    from_ns, from_clocks = now(), clocks()
    time.sleep(0.1)
    return float((clocks() - from_clocks) / (now() - from_ns))


def pass_on(streams: "list[Any]") -> None:
    """Rows to stdout, from the newest on that is there now."""
    waiting: list[deque[Any]] = [deque() for _ in streams]
    for stream in streams:
        for _ in range(stream.depth):
            stream.read()
    while hal.component_exists("rtec"):
        for stream, rows in zip(streams, waiting, strict=True):
            while stream.readable:
                rows.append(stream.read())
        out = array.array("d")
        for row in joined(waiting):
            out.extend(map(float, row))
        if out:
            sys.stdout.buffer.write(out.tobytes())
            sys.stdout.buffer.flush()
        if select.select([sys.stdin], [], [], POLL_S)[0]:
            return


def joined(waiting: "list[Any]") -> "Iterator[list[float]]":
    """Yields rows of which every stream has its part; parts whose fellows found no room are left out."""
    while all(waiting):
        first = [rows[0][0] for rows in waiting]
        newest = max(first, key=lambda count: (count - first[0] + 2**31) % 2**32)
        if all(count == newest for count in first):
            yield [value for rows in waiting for value in rows.popleft()]
            continue
        for rows, count in zip(waiting, first, strict=True):
            if count != newest:
                rows.popleft()


if __name__ == "__main__":
    main()
