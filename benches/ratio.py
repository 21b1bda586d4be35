"""Rivals and ours side by side: timed in turn in one run, told as ratios of medians per round.

Absolute times do not hold from machine to machine, and a machine's speed changes while it works: every round times each
contender for a while, one after the other, and a ratio compares times of the same round.
"""

import csv
import multiprocessing
import os
import resource
import statistics
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

KEPT = Path(__file__).with_name("kept.csv")
"""The ratios of each version's last run with KEEP=1; docs/performance.md is made from them."""
SLOWER = 1.5
"""A ratio to a rival that fell by more since the version before is named: ours became slower beside it."""
SAMPLE_S = 0.2
"""A shorter call is repeated within a sample, whoever's it is: it is timed with warm caches and memory, not with what
the contender before left of them."""


@dataclass(frozen=True)
class Contender:
    """What is timed. `note` stands in the table's last column: its accuracy, say."""

    name: str
    run: Callable[[], object]
    note: str = ""


@dataclass(frozen=True)
class Samples:
    """Seconds per call of every contender, one value a round."""

    seconds: dict[str, list[float]]

    def median_s(self, name: str) -> float:
        """The median time of one call."""
        return statistics.median(self.seconds[name])

    def ratio(self, name: str, to: str) -> float:
        """How many times as long `name` takes as `to`: the median of the rounds' ratios."""
        return statistics.median(a / b for a, b in zip(self.seconds[name], self.seconds[to], strict=True))


def compare(title: str, contenders: Sequence[Contender], rounds: int = 11, note_heading: str = "") -> Samples:
    """Time the contenders, ours first, and print a table in Markdown with ratios to ours."""
    repeats = [_repeats(contender.run) for contender in contenders]
    seconds: dict[str, list[float]] = {contender.name: [] for contender in contenders}
    for _ in range(rounds):
        for contender, count in zip(contenders, repeats, strict=True):
            seconds[contender.name].append(_seconds_per_call(contender.run, count))
    samples = Samples(seconds)
    _print_table(title, contenders, samples, note_heading)
    ratios = {contender.name: samples.ratio(contender.name, contenders[0].name) for contender in contenders[1:]}
    print_slower(title, ratios)
    if os.environ.get("KEEP"):
        keep(title, contenders[0].name, ratios)
    return samples


@dataclass(frozen=True)
class KeptRatio:
    """How many times as long as ours a rival took: at which version, in which table."""

    version: str
    title: str
    ours: str
    rival: str
    ratio: float


def kept() -> list[KeptRatio]:
    """Return the kept ratios, the oldest version first."""
    if not KEPT.is_file():
        return []
    with KEPT.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    return [KeptRatio(version, title, ours, rival, float(ratio)) for version, title, ours, rival, ratio in rows]


def keep(title: str, ours: str, ratios: dict[str, float]) -> None:
    """Keep the ratios of a table as those of this version, in place of an earlier run's."""
    now = version("trueloop")
    others = [one for one in kept() if (one.version, one.title) != (now, title)]
    rows = [*others, *(KeptRatio(now, title, ours, rival, ratio) for rival, ratio in ratios.items())]
    with KEPT.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("version", "title", "ours", "rival", "ratio"))
        writer.writerows((one.version, one.title, one.ours, one.rival, f"{one.ratio:.3g}") for one in rows)


def print_slower(title: str, ratios: dict[str, float]) -> None:
    """Name the rivals beside which ours became slower since the version before."""
    before = {one.rival: one for one in kept() if one.title == title and one.version != version("trueloop")}
    for rival, ratio in ratios.items():
        if rival in before and ratio * SLOWER < before[rival].ratio:
            was = before[rival]
            print(f"\nSLOWER beside {rival}: {ratio:.3g} ×, {was.ratio:.3g} × at version {was.version}")


def compare_once(samples: Samples, ours: str, contenders: Sequence[Contender], box_s: float = 300.0) -> None:
    """Time each of the contenders once, in a process of its own that is ended after `box_s`: they take minutes."""
    print(f"\n| once, {box_s:g} s at most | | × {ours} | memory, most so far |\n|---|---:|---:|---:|")
    for contender in contenders:
        seconds, what = _once(contender.run, box_s)
        most_mb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
        ratio = f"{'' if not what else '>'}{seconds / samples.median_s(ours):.3g}"
        print(f"| {contender.name} | {what or _readable(seconds)} | {ratio} | {most_mb:.0f} MB |", flush=True)


def _once(run: Callable[[], object], box_s: float) -> tuple[float, str]:
    """Seconds, and how it ended if not by itself."""
    process, start = multiprocessing.get_context("fork").Process(target=run), time.perf_counter()
    process.start()
    process.join(box_s)
    taken_s, ended = time.perf_counter() - start, process.exitcode is not None
    if not ended:
        process.kill()
        process.join()
    return taken_s, "" if process.exitcode == 0 else f"ended with {process.exitcode}" if ended else "not done"


def verdict(samples: Samples, name: str, to: str, at_most: float) -> None:
    """Say whether a ratio stands within its aim."""
    ratio = samples.ratio(name, to)
    print(f"\n{name} takes {ratio:.2g} × {to}: {'within' if ratio <= at_most else 'MISSES'} the aim of {at_most:g} ×")


def process(*command: str | Path) -> Callable[[], object]:
    """A whole process as a contender; one that fails ends the benchmark with what it said."""

    def run() -> None:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stderr}")

    return run


def _repeats(run: Callable[[], object]) -> int:
    run()  # warms caches up and compiles what compiles on first use
    once_s = _seconds_per_call(run, 1)
    return max(1, round(SAMPLE_S / max(once_s, 1e-9)))


def _seconds_per_call(run: Callable[[], object], count: int) -> float:
    start = time.perf_counter()
    for _ in range(count):
        run()
    return (time.perf_counter() - start) / count


def _print_table(title: str, contenders: Sequence[Contender], samples: Samples, note_heading: str) -> None:
    print(f"\n### {title}\n\n| | median | quartiles | × ours | {note_heading} |\n|---|---:|---:|---:|---|")
    for contender in contenders:
        low, _, high = statistics.quantiles(samples.seconds[contender.name], n=4)
        cells = [
            contender.name,
            _readable(samples.median_s(contender.name)),
            f"{_readable(low)} – {_readable(high)}",
            f"{samples.ratio(contender.name, contenders[0].name):.3g}",
            contender.note,
        ]
        print(f"| {' | '.join(cells)} |")


def _readable(seconds: float) -> str:
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * factor >= 1:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"
