"""What a page of a run shows. All of it but the title may be missing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.realtime.envelope import Envelope, envelope
from trueloop.realtime.events import Event, events
from trueloop.realtime.samples import Samples
from trueloop.realtime.tally import NONE, Tally, counted
from trueloop.statistics import rms

NS_PER_US = 1e3


@by_content
@dataclass(frozen=True)
class FinishedPart:
    """One part as measured: deviations along the normal, µm, positive where material is left on.

    `along_mm` (n,): arc length along the whole profile from the chuck end. `feature`: the name at each place.
    """

    name: str
    along_mm: Array
    deviation_um: Array
    feature: tuple[str, ...]

    @property
    def rms_um(self) -> float:
        """Returns the root mean square of all places."""
        return rms(self.deviation_um)


@dataclass(frozen=True)
class Timing:
    """How long something takes, ns: half of all periods, 99 % and 99.9 % of them take no longer."""

    name: str
    periods: int
    median_ns: float
    p99_ns: float
    p999_ns: float


def timing_of(name: str, each_ns: Array | Tally) -> Timing:
    """Computes the timing from the time of each period, or from how often each came."""
    tally = each_ns if isinstance(each_ns, Tally) else counted(NONE, each_ns)
    return Timing(name, tally.total, *(tally.quantile(share) for share in (0.5, 0.99, 0.999)))


@dataclass(frozen=True)
class Residual:
    """What a run left, as a model says that knows nothing of the corrector.

    `uncorrected_um`: root mean square of the error that there was to correct. `periods`: how many were judged;
    `left_out` and `why`: those that were not.
    """

    name: str
    periods: int
    rms_nm: float
    worst_nm: float
    uncorrected_um: float
    left_out: int = 0
    why: str = ""


@by_content
@dataclass(frozen=True)
class Trace:
    """A recorded run as a page draws it. `lost`: periods that were not recorded."""

    axes: str
    signals: tuple[str, ...]
    envelope: Envelope
    events: tuple[Event, ...]
    periods: int
    lost: int
    period_s: float


def trace_names(axes: str, signals: Sequence[str]) -> tuple[str, ...]:
    """Columns that a trace draws."""
    drawn = [f"{what}_{axis}_{unit}" for what, unit in DRAWN for axis in axes]
    return (*drawn, *signals, "oldest_age_s")


DRAWN = (("command", "mm"), ("model", "um"), ("table", "um"), ("correction", "um"), ("following_error", "um"))


def trace_of(samples: Samples) -> Trace:
    """Makes the trace of a whole record."""
    drawn = envelope(samples, trace_names(samples.axes, samples.signals))
    found = tuple(events(samples))
    return Trace(samples.axes, samples.signals, drawn, found, len(samples), samples.lost, samples.period_s)


@dataclass(frozen=True)
class RunPage:
    """A page. `verdict`: one sentence on what it shows. `conditions`: names with their values, as plain text.

    `parts`: the finished parts in the order to be shown, the one without the corrector first. `bare_ns`: median of the
    evaluator alone, which the timings are compared with. `notes`: what else a reader must know, a sentence each.
    """

    title: str
    verdict: str = ""
    conditions: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[FinishedPart, ...] = ()
    trace: Trace | None = None
    residuals: tuple[Residual, ...] = ()
    timings: tuple[Timing, ...] = ()
    bare_ns: float | None = None
    notes: tuple[str, ...] = ()


def largest_um(trace: Trace, what: str) -> dict[str, float]:
    """Returns the largest amount of a column by axis, µm, as `correction`: {"X": 42.1}; zero without a record."""
    columns = {axis.upper(): np.concatenate(trace.envelope.of(f"{what}_{axis}_um")) for axis in trace.axes}
    return {axis: float(np.nanmax(np.abs(values), initial=0.0)) for axis, values in columns.items()}
