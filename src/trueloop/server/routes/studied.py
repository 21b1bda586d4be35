"""Results computed from the store on request: control charts, and the causes of wrong parts.

It is kept in memory until a fact comes, and said in the language and unit of who asks.
"""

from collections.abc import Callable
from typing import Annotated, Literal, TypeVar

from fastapi import Query, Request

from trueloop.jobs.diagnose import seen_series
from trueloop.jobs.diagnose.seen_series import DiagnosisOptions
from trueloop.jobs.monitor.charts import control_charts
from trueloop.loops.monitor.chart import BASELINE, ChartOptions
from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.monitor.chart_values import ChartsShape
from trueloop.report.texts.texts import said
from trueloop.server.etags import Say
from trueloop.server.guarded import Here, Service, router

routes = router()
Rule = Annotated[int, Query(ge=1, le=8)]
T = TypeVar("T")


def worked_out(request: Request, here: Service, asked: object, work_out: Callable[[], T]) -> T:
    """Returns the result for the newest facts, computed now or before."""
    found: T = request.app.state.studies.of(here.store, asked, work_out)
    return found


@routes.get("/charts/{part_type:path}")
def show_charts(
    part_type: str,
    here: Here,
    request: Request,
    say: Say,
    characteristic: Annotated[list[str] | None, Query()] = None,
    rules: Annotated[list[Rule] | None, Query()] = None,
    baseline: Annotated[int, Query(ge=1, le=100_000)] = BASELINE,
    each_setting: bool = False,
    what: Literal["value", "residual"] = "value",
) -> ChartsShape:
    """Control charts of a part type's characteristics: alarms with what may explain them, capability."""
    options = ChartOptions(tuple(sorted(set(rules or (1,)))), baseline, each_setting, what)
    names = tuple(characteristic or ())
    shape = worked_out(
        *(request, here, ("charts", part_type, names, options)),
        lambda: control_charts(here.store, part_type, names, options),
    )
    return said(shape, say)


@routes.get("/diagnosis/series/{part_type:path}")
def diagnose_series(part_type: str, here: Here, request: Request, say: Say) -> SeriesDiagnosisShape:
    """Diagnoses the parts of a type: causes with probabilities, evidence, remedy, and deciding measurement."""
    asked = DiagnosisOptions(part_type)
    shape = worked_out(request, here, ("series", part_type), lambda: seen_series.series(here.store, asked))
    return said(shape, say)


@routes.get("/diagnosis/part/{serial:path}")
def diagnose_part(
    serial: str, here: Here, request: Request, say: Say, part_type: str | None = None
) -> PartDiagnosisShape:
    """The diagnosis of one part."""
    asked = ("part", serial, part_type)
    shape = worked_out(request, here, asked, lambda: seen_series.part(here.store, serial, DiagnosisOptions(part_type)))
    return said(shape, say)
