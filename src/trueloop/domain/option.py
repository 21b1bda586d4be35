"""Options of a user, stated once: at the field of the frozen dataclass that the code computes with; and the limits of a
correction, beyond any of which it is refused, never clamped in silence.

    correction_mm: Annotated[float, Option("compensation.max_correction_um", "A larger …", above=0)] = 0.150

Keys of job files, their defaults and bounds, options of commands, the JSON schema and the tables of the documentation
are read from there. The limits hold for turned parts, surfaces, and programs that a machine model or a field corrects.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, time, timedelta
from typing import Annotated, Any, Final, Literal, NamedTuple, TypeAlias, get_args, get_type_hints

from trueloop.errors import Code
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording


class Unit(NamedTuple):
    """A unit that the end of a key names: `inside` takes its numbers to mm, rad and shares, `outside` back."""

    name: str
    inside: Callable[[float], float] = float
    outside: Callable[[float], float] = float


def _um(name: str) -> Unit:
    return Unit(name, lambda given: given / UM_PER_MM, lambda value: value * UM_PER_MM)


UNITS: Final = {
    "_mm_per_min": Unit("mm/min"),
    "_um_per_mm": _um("µm/mm"),
    "_um": _um("µm"),
    "_mm": Unit("mm"),
    "_in": Unit("inch"),
    "_deg": Unit("°", math.radians, lambda angle: round(math.degrees(angle), 9)),
    "_percent": Unit("%", lambda given: given / 100, lambda share: share * 100),
    "_hours": Unit("h"),
}
"""By the end of a key, the longest first where one ends with another."""


def unit_of(key: str) -> Unit:
    """Returns the unit that a key ends with; one without a name where it names none."""
    return next((unit for end, unit in UNITS.items() if key.endswith(end)), Unit(""))


@dataclass(frozen=True)
class Option:
    """How a field is set: the table and key of a job file, whose end names the unit there, what it means, and the
    numbers accepted, in that unit: over `above` or from `least`, below `below` or up to `most`.
    """

    key: str
    meaning: str
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    unit: str = ""
    """In words, of a key whose end names none."""


@dataclass(frozen=True)
class Choice:
    """An option with the type of its values and its default, in the unit of its key."""

    option: Option
    kind: Any
    default: Any


def choices_of(options: Any) -> dict[str, Choice]:
    """Returns a dataclass's options by field, of its type or an instance's defaults; `...`: has to be given."""
    found = {}
    kind = options if isinstance(options, type) else type(options)
    for name, hint in get_type_hints(kind, include_extras=True).items():
        taken, *notes = get_args(hint) or (hint,)
        for option in notes:
            if isinstance(option, Option):
                found[name] = Choice(option, taken, outside(option.key, getattr(options, name, ...)))
    return found


def inside(key: str, number: Any) -> Any:
    """Converts a value as given under a key to the one that the code computes with."""
    return unit_of(key).inside(number) if isinstance(number, float) else number


def outside(key: str, value: Any) -> Any:
    """Converts a value that the code computes with to the one given under a key."""
    return unit_of(key).outside(value) if isinstance(value, float) else value


Language: TypeAlias = Literal["en", "de"]
LengthUnit: TypeAlias = Literal["mm", "inch"]
MemoryUse: TypeAlias = Literal["on", "bands", "frozen", "off"]


@dataclass(frozen=True)
class PageOptions:
    """Language of the page, and the unit of its lengths; None: that of the program."""

    language: Annotated[
        Language, Option("report.language", '`"en"` or `"de"`: the language of the page, with its decimal sign.')
    ] = "en"
    unit: Annotated[
        LengthUnit | None,
        Option(
            "report.unit",
            '`"mm"` (errors in µm) or `"inch"` (errors in µin): the unit of the page; left out, the program\'s.',
        ),
    ] = None


@dataclass(frozen=True)
class Limits:
    """Limits of what is accepted. Sizes and scatter in mm along the normal, slopes in mm per mm of arc, age in hours.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> strict = trueloop.Options(limits=trueloop.Limits(correction_mm=0.02))
    >>> trueloop.compensate(replace(job.inputs, options=strict))
    Traceback (most recent call last):
    trueloop.errors.TrueloopError
    """

    correction_mm: Annotated[
        float,
        Option("compensation.max_correction_um", "A larger correction (on X: of the radius) is refused.", above=0),
    ] = 0.150
    slope: Annotated[
        float,
        Option("compensation.max_slope_um_per_mm", "A correction that is steeper along the part is refused.", above=0),
    ] = 0.040
    scatter_mm: Annotated[
        float,
        Option(
            "compensation.max_scatter_um",
            "Measurements that scatter more about what is fitted (one standard deviation) are refused, with the name "
            "of the worst one: what does not repeat cannot be corrected.",
            above=0,
        ),
    ] = 0.010
    age_hours: Annotated[
        float, Option("compensation.max_age_hours", "Measurements older than this are refused.", above=0)
    ] = 24.0


LIMITS: Final = choices_of(Limits)
"""By field: key, unit, default and meaning of every limit, for files and commands."""

OF_SURFACES: Final = Limits(age_hours=7 * 24.0)
"""A surface is measured on a measuring machine, the parts of a series over days."""


def allowed_by(field: str) -> str:
    """Returns what a user sets to have more accepted."""
    return f"{LIMITS[field].option.key} in the job"


def check_scatter(scatter_mm: float, limits: Limits, cause: str = "") -> None:
    """Refuses touches that scatter about what was fitted by more than the limit: then little of the error repeats.

    cause: what is known of where the scatter comes from, a clause for the message.
    """
    if scatter_mm > limits.scatter_mm:
        raise Code.CMP_SCATTER.refusal(
            wording(
                "the touches scatter by {scatter} (one standard deviation) about what was fitted; the limit is "
                "{limit}{cause}",
                scatter=Um(scatter_mm),
                limit=Um(limits.scatter_mm),
                cause=f"; {cause}" if cause else "",
            ),
            hint=wording("look for a bad touch, a loose probe or chatter: what does not repeat cannot be corrected"),
            override=allowed_by("scatter_mm"),
            values={"scatter_um": scatter_mm * UM_PER_MM, "limit_um": limits.scatter_mm * UM_PER_MM},
        )


def in_utc(at: datetime) -> datetime:
    """Returns a time without a zone as one of UTC; others as they are."""
    return at if at.tzinfo else at.replace(tzinfo=UTC)


def latest_time(measured_at: datetime) -> datetime:
    """Returns the time of a measurement in UTC, the end of its day where only the day is known (midnight)."""
    whole_day = measured_at.time() == time.min
    return (measured_at + (timedelta(days=1) if whole_day else timedelta())).astimezone(UTC)


def check_age(measured_at: datetime, now: datetime, limits: Limits) -> None:
    """Refuses touches that are older than the limit, or from the future. Of a day without a time its end counts."""
    age_hours = (now - measured_at).total_seconds() / 3600
    if age_hours < 0:
        ahead = f"{-60.0 * age_hours:.1f} min" if age_hours > -2.0 else f"{-age_hours:.1f} h"
        raise Code.CMP_AGE.refusal(
            f"the touches are dated {ahead} in the future ({measured_at.isoformat(timespec='minutes')})",
            hint="set the clock, or the time and its zone that the job gives",
            values={"age_h": age_hours},
        )
    least_hours = (now.astimezone(UTC) - latest_time(measured_at)).total_seconds() / 3600
    if least_hours > limits.age_hours:
        raise Code.CMP_AGE.refusal(
            f"the touches were taken {age_hours:.1f} h ago ({measured_at.isoformat(timespec='minutes')}); "
            f"the limit is {limits.age_hours:g} h",
            hint="probe the part again: machine and tool have changed since",
            override=allowed_by("age_hours"),
            values={"age_h": age_hours},
        )


@dataclass(frozen=True)
class MapOptions:
    """How a field is applied.

    tolerance_mm: how far the written path may leave the displaced one, rounding to the control's resolution not
    counted. limit_mm: largest displacement along an axis. slope: largest change of the displacement in a cut over its
    length, mm/mm. skipped_blocks: displace the blocks that start with a slash as well. unit: what is in force at the
    program's start, where it does not state it. decimals: how many are written at least, beside those that the control
    resolves and those that the program has.

    >>> trueloop.MapOptions(limit_mm=0.05).tolerance_mm
    0.0005
    """

    tolerance_mm: Annotated[
        float, Option("tolerance_um", "How far a block may leave the displaced path.", least=0.001)
    ] = 0.0005
    limit_mm: float = Limits.correction_mm
    slope: float = Limits.slope
    skipped_blocks: bool = False
    unit: Literal["mm", "inch"] | None = None
    decimals: int = 0


USUAL: Final = MapOptions()
MAP_OPTIONS: Final = choices_of(MapOptions)
"""By field: unit, default and meaning, for commands."""
