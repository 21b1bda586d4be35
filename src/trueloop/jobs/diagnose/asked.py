"""What a diagnosis of parts is asked of, and where it reads it from."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from trueloop.diagnosis.features.feature_error import FeaturePlace
from trueloop.geometry.profile import Profile
from trueloop.jobs.diagnose.both import given_model
from trueloop.jobs.diagnose.records import Records, read_records
from trueloop.jobs.diagnose.seen_series import Sources
from trueloop.jobs.turned.job import read_job
from trueloop.loops.diagnosis.points_of import places_of
from trueloop.storage.store import Store


@dataclass(frozen=True)
class Asked:
    """What is asked for: of which part type, with the profile of which job, by which model; `accept` are codes."""

    part_type: str | None = None
    job: Path | None = None
    model: Path | None = None
    accept: tuple[str, ...] = ()


def sources_of(store: Store, asked: Asked, part_type: str | None) -> Sources:
    """Collects the records of a part type, where its features lie, and the model. Raises DIA-NONE."""
    records = read_records(store, part_type)
    model = None if asked.model is None else given_model(asked.model)
    return Sources(store, records, _places(records, asked.job), model, asked.accept)


def _places(records: Records, job: Path | None) -> Mapping[str, FeaturePlace]:
    profile: Profile | None = None if job is None else read_job(job).inputs.profile
    seen = [kept.value for kept in records.inspections if records.seen_by(kept.value) is not None]
    places, tools = places_of(seen, profile), records.tools
    return {name: replace(place, tool=tools[0]) for name, place in places.items()} if len(tools) == 1 else places
