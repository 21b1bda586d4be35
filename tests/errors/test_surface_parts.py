"""Every way in which parts of a surface in a store are refused or noticed."""

from collections.abc import Callable

from tests.support.surface_parts import job, part
from tests.support.surfaces import wavy_surface
from trueloop.errors import Code
from trueloop.jobs.store.codec import store_codec
from trueloop.jobs.surface.kept_parts import keep_parts, with_kept_parts
from trueloop.loops.surface.over_parts import NoticedPart, as_findings
from trueloop.memory.noticing import Alarm, What
from trueloop.storage.store import open_store


def _of_another_surface() -> object:
    store = open_store("sqlite://", create=True, codec=store_codec())
    keep_parts(store, job([part(1)]))
    return with_kept_parts(store, job([part(2)], surface=wavy_surface(height_mm=4.01)))


def _drifting() -> object:
    says = "the pattern of 7 parts changes by 0.80 µm RMS from part to part: the cutter wears, or the machine warms up"
    return as_findings(NoticedPart("S07", (Alarm(What.DRIFT, 2.4e-4, says),)))


PRODUCERS: dict[Code, Callable[[], object]] = {Code.SRF_STORED: _of_another_surface, Code.SRF_DRIFT: _drifting}
