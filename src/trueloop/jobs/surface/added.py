"""A surface's job with a store: parts added one by one and judged, corrections made by all parts in it."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from trueloop.domain.inspection import Inspection
from trueloop.errors import Finding, in_file
from trueloop.jobs.store.where import Choice, store_of
from trueloop.loops.surface.surface import HERE, Work, model_of

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.jobs.surface.job import ReadSurface
    from trueloop.storage.store import Store


@dataclass(frozen=True)
class Together:
    """A job with the parts of its store, which is None where there is none; notes of parts that do not count."""

    read: "ReadSurface"
    store: "Store | None"
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Added:
    """What was kept, how many parts there are by now, and what was noticed of the new ones."""

    kept: "KeptFacts"
    parts: int
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]


def with_store(read: "ReadSurface", db: Choice, *, keep_outliers: bool = False) -> Together:
    """Returns the job with the parts of the store requested, else of the one beside it; unchanged where there is none.

    `keep_outliers`: parts that are outlying beyond doubt count for the pattern too. Raises STO and SRF errors.
    """
    store = store_of(read.job.parent, db, read.store_db)
    if store is None:
        return Together(read, None, ())
    from trueloop.jobs.surface.kept_parts import with_kept_parts  # slow to import, and most jobs have no store

    with in_file(read.job):
        together, notes = with_kept_parts(store, read)
    return Together(replace(together, inputs=replace(together.inputs, leave_out=not keep_outliers)), store, notes)


def add_parts(store: "Store", together: Together, work: Work = HERE) -> Added:
    """Keeps the job's own parts and judges those that are new, each given the parts before it. Raises STO, SRF errors.

    Nothing is kept of parts that are refused: their points are compared with the surface first.
    """
    from trueloop.jobs.surface.kept_parts import keep_parts
    from trueloop.loops.surface.over_parts import as_findings, notice_in_order

    inputs = together.read.inputs
    with in_file(together.read.job):
        parts = model_of(inputs.surface, inputs.parts, inputs.options, trim=inputs.trim, work=work)
        kept = keep_parts(store, together.read)
    new = [one.value.part.serial for one in kept.new if isinstance(one.value, Inspection)]
    counted = [part for part in parts if part.deviations.name not in inputs.options.exclude]
    noticed = notice_in_order(counted, new)
    findings = tuple(finding for one in noticed for finding in as_findings(one))
    return Added(kept, len(parts), findings, together.notes)
