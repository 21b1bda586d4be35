"""The ways in which files that people hand over are read, in a process apart: `READINGS`, by name."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from trueloop.domain.codec import Codec
from trueloop.domain.values import CODEC as STORED
from trueloop.factory.views import by_hand, uploads
from trueloop.jobs.factory.by_hand import part_by_hand, tried_by_hand
from trueloop.jobs.factory.hand_job import AskedPart, AskedReadings, HandJob
from trueloop.jobs.factory.uploads import (
    HandedFile,
    ReadingOptions,
    UploadedInspection,
    inspected,
    order_read,
    program_read,
    toml_read,
    upload_view,
)

READINGS: Final[Mapping[str, Callable[[HandedFile], Any]]] = {
    one.__name__: one
    for one in (upload_view, program_read, inspected, order_read, toml_read, part_by_hand, tried_by_hand)
}
CODEC: Final[Codec] = STORED.with_more(
    *(HandedFile, ReadingOptions, UploadedInspection, uploads.UploadView, uploads.ProgramRead, uploads.MeasurementRead),
    *(uploads.InspectionRead, uploads.ValueRead, uploads.DrawingRead, uploads.Remarked),
    *(HandJob, AskedPart, AskedReadings, by_hand.PartByHand, by_hand.SizeToMeasure, by_hand.Unstated),
    *(by_hand.MadeBefore, by_hand.Picture),
)
"""Questions to a process that reads files, and its answers."""
