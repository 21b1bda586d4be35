"""A surface's measured parts and its correction, kept in the job's store."""

from collections.abc import Iterator
from typing import Any

from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts, texts_of
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.store.where import store_of
from trueloop.jobs.surface.job import ReadSurface
from trueloop.jobs.surface.kept_parts import part_facts
from trueloop.loops.surface.correction import RecordedCorrection
from trueloop.loops.surface.stored import enveloped
from trueloop.storage.store import Store


def keep_surface(read: ReadSurface, done: RecordedCorrection, keeping: Keeping) -> KeptFacts | None:
    """Keeps the parts, their inspections, the cuts that these show, the programs and the correction; None: no store.

    A part's serial number is its file's name. Raises STO-OTHER-PART and what keeping refuses.
    """
    store = store_of(read.job.parent, keeping.db, read.store_db)
    if store is None:
        return None
    return keep_facts(store, _facts(store, read, done), supersede=keeping.supersede)


def _facts(store: Store, read: ReadSurface, done: RecordedCorrection) -> Iterator[Any]:
    program, written = read.inputs.program, done.correction.program
    yield from part_facts(store, read.inputs)
    yield from texts_of([None if program is None else program.source, None if written is None else written.source])
    yield enveloped(done)
