"""What corrections in force took off the errors of a part, as recorded."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trueloop.diagnosis.causes.seen_part import SeenBy
from trueloop.diagnosis.features.feature_error import ErrorKind
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.correction import Correction
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity, Ran
from trueloop.domain.part import Part
from trueloop.factory.book import read_book
from trueloop.jobs.diagnose.records import Records
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.series import identity_of, sizes_of
from trueloop.loops.turned import correction as turned
from trueloop.storage.store import Store

KINDS = {
    Quantity.DIAMETER: (ErrorKind.RADIUS, 0.5),
    Quantity.RADIUS: (ErrorKind.RADIUS, 1.0),
    Quantity.LENGTH: (ErrorKind.LENGTH, 1.0),
}
"""Which error of a feature a size is, and how much of the size it is."""


@dataclass(frozen=True)
class Corrections:
    """By part: what accepted proposals took off each series of sizes; and corrections of programs by their id."""

    by_proposals: Mapping[Identity, Mapping[Identity, float]]
    by_program: Mapping[str, Correction[Any]]

    @classmethod
    def read(cls, store: Store, records: Records) -> "Corrections":
        """All of a part type."""
        sized = any(any(sizes_of(one.value)) for one in records.inspections)
        parts = read_book(store, records.part_type, SeriesOptions()).parts if sized else ()
        return cls({one.inspection.part.identity: one.correction_mm for one in parts}, records.corrections)

    def of(self, part: Part, cut: Cut | None, seen: Mapping[SeenBy, Inspection]) -> dict[tuple[str, str], float]:
        """What was taken off, by feature and kind of error; 0 and missing are the same."""
        taken: dict[tuple[str, str], float] = {}
        for name, kind, size_mm in (*self._proposed(part, seen), *self._programmed(cut)):
            taken[(name, str(kind))] = taken.get((name, str(kind)), 0.0) + size_mm
        return taken

    def _proposed(self, part: Part, seen: Mapping[SeenBy, Inspection]) -> Iterator[tuple[str, ErrorKind, float]]:
        """Of readings: a diameter's correction is twice that of the radius."""
        by_series = self.by_proposals.get(part.identity, {})
        done: set[Identity] = set()
        for one in seen.values():
            for asked, _ in sizes_of(one):
                series = identity_of(one.part.part_type, asked)
                if series in by_series and series not in done and asked.quantity in KINDS:
                    done.add(series)
                    kind, share = KINDS[asked.quantity]
                    yield _feature(asked), kind, share * by_series[series]

    def _programmed(self, cut: Cut | None) -> Iterator[tuple[str, ErrorKind, float]]:
        """Of a corrected program or its tool offset: what the touches of each feature say it takes off."""
        correction = None if cut is None else self.by_program.get(cut.correction)
        payload = None if correction is None else correction.payload
        if cut is None or not isinstance(payload, turned.Correction):
            return
        given = payload.programs_sha256.get(Ran.AS_PROGRAMMED) == cut.program_sha256
        if given and not cut.offset_entered and not payload.runs_as_given:
            return
        taken_mm = payload.prediction.before_mm - payload.commanded_mm - payload.prediction.after_mm
        for k, feature in enumerate(payload.profile.features):
            rows = payload.touches.of_feature(k)
            if len(rows):
                before_mm = payload.in_force_mm(k, payload.touches.arc_length_mm[rows])
                yield feature.name, ErrorKind.RADIUS, float(np.mean(taken_mm[rows] - before_mm))


def _feature(asked: Characteristic) -> str:
    return asked.feature or asked.name
