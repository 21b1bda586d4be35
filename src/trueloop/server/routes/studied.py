"""What is worked out of the store when it is asked for, and never kept: control charts, and what makes parts wrong."""

from typing import Annotated, Literal

from fastapi import Query

from trueloop.domain.page_options import Language
from trueloop.jobs.diagnose import diagnosed
from trueloop.jobs.diagnose.asked import Asked
from trueloop.jobs.monitor.charts import charts_of
from trueloop.loops.monitor.options import BASELINE, ChartOptions
from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.monitor.chart_shapes import ChartsShape
from trueloop.report.texts.said import said
from trueloop.report.texts.texts import Texts
from trueloop.server.guarded import Here, router

routes = router()
Rule = Annotated[int, Query(ge=1, le=8)]


@routes.get("/charts/{part_type:path}")
def show_charts(
    part_type: str,
    here: Here,
    characteristic: Annotated[list[str] | None, Query()] = None,
    rules: Annotated[list[Rule] | None, Query()] = None,
    baseline: Annotated[int, Query(ge=1, le=100_000)] = BASELINE,
    each_setting: bool = False,
    what: Literal["value", "residual"] = "value",
    language: Language = "en",
) -> ChartsShape:
    """Control charts of a part type's characteristics: alarms with what may explain them, capability."""
    options = ChartOptions(tuple(sorted(set(rules or (1,)))), baseline, each_setting, what)
    return said(charts_of(here.store, part_type, characteristic or (), options), Texts(language))


@routes.get("/diagnosis/series/{part_type:path}")
def diagnose_series(part_type: str, here: Here, language: Language = "en") -> SeriesDiagnosisShape:
    """What makes the parts of a type wrong: causes with probabilities, evidence, remedy, and what would decide."""
    return said(diagnosed.series(here.store, Asked(part_type)), Texts(language))


@routes.get("/diagnosis/part/{serial:path}")
def diagnose_part(
    serial: str, here: Here, part_type: str | None = None, language: Language = "en"
) -> PartDiagnosisShape:
    """What is wrong with one part."""
    return said(diagnosed.part(here.store, serial, Asked(part_type)), Texts(language))
