"""Checks of gauges and probes from the store, and their files."""

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path

from trueloop.domain.inspection import Inspection
from trueloop.domain.page_options import Language, LengthUnit
from trueloop.domain.standard_part import StandardPart
from trueloop.errors import Code, TrueloopError
from trueloop.formats.outputs import write_all
from trueloop.loops.monitor.gauge import GaugeSeries, gauges
from trueloop.report.monitor.gauge import GaugesShape, gauge_page, gauges_shape
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store, find


def gauges_of(store: Store, device: str | None) -> GaugesShape:
    """Returns the checks of a device, or of all. Raises MON-NONE where there is none."""
    return gauges_shape(_checked(store, device))


def _checked(store: Store, device: str | None) -> tuple[GaugeSeries, ...]:
    standards = [one.value for one in find(store, StandardPart)]
    types = dict.fromkeys(one.part.part_type.name for one in standards)
    inspections = [one.value for name in types for one in find(store, Inspection, part_type=name)]
    return gauges(standards, inspections, device)


def failed_checks(store: Store) -> Mapping[str, tuple[tuple[datetime, str], ...]]:
    """Returns by device when it was checked, and what failed then in words; "" where nothing did."""
    try:
        checked = _checked(store, None)
    except TrueloopError as refused:
        if refused.code is not Code.MON_NONE:
            raise
        return {}
    said: dict[str, dict[datetime, str]] = {}
    for one in checked:
        for k, check in enumerate(one.checks):
            if check.at is not None:
                own = said.setdefault(one.device, {})
                own[check.at] = own.get(check.at) or one.failing(k)
    return {device: tuple(sorted(own.items())) for device, own in said.items()}


def write_gauges(shown: GaugesShape, folder: Path | None, language: Language, unit: LengthUnit) -> list[str]:
    """Writes gauges.json and gauges.html to a folder, both or none; nothing without one. Raises OUT errors."""
    if folder is None:
        return []
    contents = [
        ("gauges.json", (shown.model_dump_json(indent=1) + "\n").encode()),
        ("gauges.html", gauge_page(shown, Texts(language, unit)).encode()),
    ]
    return [str(file) for file in write_all(folder, contents)]
