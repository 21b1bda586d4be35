"""What limits a correction: beyond any of these it is refused, never clamped in silence.

Of a turned part, of a surface, and of a program that a machine model or a field corrects.
"""

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Final

from trueloop.domain.option import Option, choices_of
from trueloop.errors import Code, TrueloopError
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class Limits:
    """What is accepted. Sizes and scatter in mm along the normal, slopes in mm per mm of arc, age in hours.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> strict = trueloop.Options(limits=trueloop.Limits(correction_mm=0.02))
    >>> trueloop.compensate(replace(job.inputs, options=strict))
    Traceback (most recent call last):
    trueloop.errors.TrueloopError
    """

    correction_mm: Annotated[
        float,
        Option(
            "compensation.max_correction_um",
            "A larger correction (on X: of the radius) is refused.",
            above=0,
        ),
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
        raise TrueloopError(
            Code.CMP_SCATTER,
            f"the touches scatter by {scatter_mm * UM_PER_MM:.1f} µm (one standard deviation) about what was fitted; "
            f"the limit is {limits.scatter_mm * UM_PER_MM:.1f} µm{f'; {cause}' if cause else ''}",
            hint="look for a bad touch, a loose probe or chatter: what does not repeat cannot be corrected",
            override=allowed_by("scatter_mm"),
            values={"scatter_um": scatter_mm * UM_PER_MM, "limit_um": limits.scatter_mm * UM_PER_MM},
        )


def check_age(measured_at: datetime, now: datetime, limits: Limits) -> None:
    """Refuses touches that are older than the limit, or from the future. Both times know their zone, or neither."""
    age_hours = (now - measured_at).total_seconds() / 3600
    if age_hours < 0:
        raise TrueloopError(
            Code.CMP_AGE,
            f"the touches were taken {-age_hours:.1f} h from now ({measured_at.isoformat(timespec='minutes')})",
            hint="set the clock, or the time and its zone that the job gives",
            values={"age_h": age_hours},
        )
    if age_hours > limits.age_hours:
        raise TrueloopError(
            Code.CMP_AGE,
            f"the touches were taken {age_hours:.1f} h ago ({measured_at.isoformat(timespec='minutes')}); "
            f"the limit is {limits.age_hours:g} h",
            hint="probe the part again: machine and tool have changed since",
            override=allowed_by("age_hours"),
            values={"age_h": age_hours},
        )
