"""What a job's drawing asks for: characteristics with their limits, held against the profile."""

from collections.abc import Sequence

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.job import CharacteristicTable, Job
from trueloop.formats.jobs.profile_of_job import MM_PER
from trueloop.formats.toml_tables import Located
from trueloop.geometry.profile import Profile
from trueloop.tolerances.text import limits_of
from trueloop.turned.characteristics.nominal import checked, with_nominal


def characteristics_of(job: Located[Job], profile: Profile) -> tuple[Characteristic, ...]:
    """Those of `[[part.characteristic]]`, in their order. Raises TOL errors with the line that they stand in."""
    mm_per_unit, found = MM_PER[job.model.part.unit], list[Characteristic]()
    for k, table in enumerate(job.model.part.characteristic):
        with job.at("part", "characteristic", k):
            one = _characteristic(table, profile, mm_per_unit)
            _refuse_twice(one, found)
            found.append(one)
    return tuple(found)


def _characteristic(table: CharacteristicTable, profile: Profile, mm_per_unit: float) -> Characteristic:
    quantity = Quantity(table.quantity)
    scale = 1.0 if quantity is Quantity.ANGLE else mm_per_unit

    def inside(number: float | None) -> float | None:
        return None if number is None else number * scale

    bare = Characteristic(table.name, quantity, table.feature, 0.0, other=table.other, at_z_mm=table.at_z_mm)
    asked = with_nominal(bare, inside(table.nominal), profile)
    lower, upper = inside(table.lower_limit), inside(table.upper_limit)
    if table.tolerance is not None:
        lower, upper = limits_of(table.tolerance, asked.nominal, quantity, mm_per_unit)
    return checked(asked, lower, upper, table.tolerance or "", profile)


def _refuse_twice(one: Characteristic, others: Sequence[Characteristic]) -> None:
    """Raises TOL-TWICE for a name, or a size of one place, that is there already."""
    for other in others:
        if one.name == other.name:
            raise _twice(one, f"characteristic {one.name!r} is there twice")
        if place_of(one) == place_of(other):
            raise _twice(
                one, f"characteristic {one.name!r} is the {one.quantity} of {one.feature!r} that {other.name!r} is"
            )


def _twice(one: Characteristic, message: str) -> TrueloopError:
    hint = "a name, and a size at one place, stand once: with the limits that count"
    return TrueloopError(Code.TOL_TWICE, message, hint=hint, values={"characteristic": one.name})


def place_of(one: Characteristic) -> tuple[object, ...]:
    """What is measured where: two characteristics that agree in it are the same."""
    return one.quantity, frozenset((one.feature, one.other)), one.at_z_mm
