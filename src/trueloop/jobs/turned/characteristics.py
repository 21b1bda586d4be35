"""Reads the characteristics of a job's drawing, with their limits, and checks them against the profile."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import Code, TrueloopError
from trueloop.formats.jobs.job import Job
from trueloop.formats.jobs.part_tables import CharacteristicTable
from trueloop.formats.jobs.profile_of_job import MM_PER
from trueloop.formats.toml_tables import Located
from trueloop.geometry.profile import Profile
from trueloop.tolerances import iso2768
from trueloop.tolerances.text import limits_of, unread
from trueloop.turned.characteristics.measurand import (
    SAME,
    checked,
    edge_of,
    feature_index,
    place_of,
    usual,
    with_nominal,
)
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.sizes import axial_mm
from trueloop.wording import all_of, wording


def characteristics_of(job: Located[Job], profile: Profile) -> tuple[Characteristic, ...]:
    """Returns those of `[[part.characteristic]]`, then those by `part.general_tolerance`. Raises TOL errors."""
    part, found = job.model.part, list[Characteristic]()
    for k, table in enumerate(part.characteristic):
        with job.at("part", "characteristic", k):
            one = _characteristic(table, profile, MM_PER[part.unit])
            # Raises TOL-TWICE for a name, or a size of one place, that is there already
            for other in found:
                if one.name == other.name:
                    raise _twice(one, f"characteristic {one.name!r} is there twice")
                if place_of(one, profile) == place_of(other, profile):
                    raise _twice(
                        one,
                        f"characteristic {one.name!r} is the {one.quantity} of {one.feature!r} that {other.name!r} is",
                    )
            found.append(one)
    if part.general_tolerance is not None:
        with job.at("part", "general_tolerance"):
            found += _general(part.general_tolerance, profile, {characteristic.feature for characteristic in found})
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
        edge = edge_of(profile, feature_index(profile, asked))
        lower, upper = limits_of(table.tolerance, asked.nominal, quantity, edge, mm_per_unit)
    return checked(asked, lower, upper, table.tolerance or "", profile)


def _general(tolerance: str, profile: Profile, toleranced: Collection[str]) -> Iterator[Characteristic]:
    """By the general tolerance, of features that have no characteristic; sizes below its tables have none."""
    for index, feature in enumerate(profile.features):
        bare = usual(feature)
        if feature.name in toleranced or bare is None:
            continue
        asked = with_nominal(bare, None, profile)
        if asked.nominal < iso2768.LEAST_MM:
            continue
        found = iso2768.deviation(tolerance, asked.quantity, asked.nominal, edge_of(profile, index))
        if found is None:
            raise unread(tolerance)
        yield checked(asked, asked.nominal - found, asked.nominal + found, tolerance, profile)


def _twice(characteristic: Characteristic, message: str) -> TrueloopError:
    hint = "a name, and a size at one place, stand once: with the limits that count"
    return Code.TOL_TWICE.refusal(message, hint=hint, values={"characteristic": characteristic.name})


def tolerance_name(size: Characteristic) -> str:
    """Returns the name of a size's tolerance on the sheet; "" where the drawing has limits. Diameters share one."""
    if size.lower_limit is not None or size.upper_limit is not None:
        return ""
    return size.feature if size.quantity is Quantity.DIAMETER else size.name


def toleranced(
    tolerances: Mapping[str, str], planned: Sequence[Characteristic], profile: Profile, mm_per_unit: float
) -> tuple[Characteristic, ...]:
    """Returns the characteristics of sizes of the sheet whose tolerances, as a drawing has them, are stated by name.

    Numbers of the texts are in units of `mm_per_unit`. Raises TOL errors; MSR-FEATURE for a name that no size has.
    """
    sizes = {name: characteristic for characteristic in reversed(planned) if (name := tolerance_name(characteristic))}
    found = []
    for name, text in tolerances.items():
        if name not in sizes:
            raise Code.MSR_FEATURE.refusal(
                f"the sheet has no size {name!r} without limits",
                hint=f"its sizes without limits are: {', '.join(reversed(sizes))}",
                values={"feature": name},
            )
        size = sizes[name]
        size = replace(size, name=name, at_z_mm=None if size.quantity is Quantity.DIAMETER else size.at_z_mm)
        edge = edge_of(profile, feature_index(profile, size))
        lower, upper = limits_of(text, size.nominal, size.quantity, edge, mm_per_unit)
        found.append(checked(size, lower, upper, text if mm_per_unit == 1.0 else "", profile))
    return tuple(found)


def joined(
    characteristics: Sequence[Characteristic],
    of_file: Sequence[Characteristic],
    profile: Profile,
    names: Mapping[str, str],
    matched: Sequence[MatchedReading] = (),
) -> tuple[tuple[Characteristic, ...], tuple[str, ...]]:
    """Joins the job's characteristics with those of an inspection file that the job does not have; and notes.

    `names`: the profile's name of a feature, by that in the file. `matched`: the readings of the file with their
    features, of which the characteristics of their names are, whatever the file names. The job speaks for the drawing:
    where both have a size at one place, its limits count, and a note states it if the file has others. What is of no
    feature of the profile, or has no limits, or is not a size of a turned part, is not judged, and noted.
    """
    found, notes, of_none = list(characteristics), list[str](), list[str]()
    of = {reading.reading.characteristic: reading for reading in matched}
    for theirs in of_file:
        one = replace(theirs, feature=names.get(theirs.feature, theirs.feature))
        one = _of_feature(one, of[one.name], profile) if one.name in of else one
        if not one.feature:
            of_none.append(one.name)
            continue
        # The job's may hold along the whole feature
        places = [place_of(each, profile) for each in (one, replace(one, at_z_mm=None))]
        ours = next(
            (each for each in characteristics if each.name == one.name or place_of(each, profile) in places), None
        )
        if ours is not None:
            notes += _other_limits(ours, one)
            continue
        try:
            with_nominal(one, one.nominal, profile)
            found.append(checked(one, one.lower_limit, one.upper_limit, one.tolerance, profile))
        except TrueloopError as refused:
            notes.append(wording("{words}: not judged.", words=refused.message))
    if of_none:
        notes.append(wording("{names}: of no feature of the part, not judged.", names=all_of(of_none)))
    return tuple(found), tuple(notes)


def _of_feature(characteristic: Characteristic, of: MatchedReading, profile: Profile) -> Characteristic:
    """Returns the characteristic of the feature that its reading is of, where it was read."""
    other = "" if of.other_index is None else profile.names[of.other_index]
    at_z_mm = axial_mm(of.reading) if characteristic.at_z_mm is None else characteristic.at_z_mm
    return replace(characteristic, feature=profile.names[of.feature_index], other=other, at_z_mm=at_z_mm)


def _other_limits(ours: Characteristic, theirs: Characteristic) -> Iterator[str]:
    if not _same(ours.lower_limit, theirs.lower_limit) or not _same(ours.upper_limit, theirs.upper_limit):
        yield wording("{name}: the limits of the inspection file are others than those of the job, which count.",
                      name=ours.name)  # fmt: skip


def _same(value: float | None, other: float | None) -> bool:
    return value is other or (value is not None and other is not None and abs(value - other) < SAME)
