"""Control charts and diagnoses over HTTP are what the commands compute, in the language that is asked for."""

import json
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import pytest

from tests.support.full_shop import full_shop
from tests.support.series import inspection
from tests.support.service import Running, problem
from trueloop.jobs.diagnose import seen_series
from trueloop.jobs.diagnose.seen_series import DiagnosisOptions
from trueloop.jobs.monitor.charts import control_charts
from trueloop.loops.monitor.chart import ChartOptions
from trueloop.report.texts.texts import german
from trueloop.server.app import Studies
from trueloop.storage.store import keep

SEATS = (0.2, 1.0, -1.0, 0.5, -0.5, 0.2, 1.0, -1.0, -0.2, 27.0)
HALF = 3 * sum(abs(a - b) for a, b in pairwise(SEATS)) / 9 / 1.128379
"""By hand: three standard deviations from the mean moving range, d2 = 2 / sqrt(pi)."""


def test_charts_are_those_of_the_command(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    shown = vera.get("charts/SHAFT?characteristic=seat&rules=1&rules=2&rules=3").json()
    options = ChartOptions(rules=(1, 2, 3))
    assert shown == json.loads(control_charts(service.store, "SHAFT", ("seat",), options).model_dump_json())
    (seat,) = shown["characteristics"]
    # nine in a row below the centre, the last of them 508; then one far above the limits
    assert [(one["first"], one["last"]) for one in seat["alarms"]] == [("508", "509")]
    individuals = seat["segments"][0]["charts"][0]
    assert individuals["centre"] == pytest.approx(2.72)
    assert individuals["high"][0] == pytest.approx(2.72 + HALF, abs=2e-3)
    residual = vera.get("charts/SHAFT?what=residual&baseline=9").json()
    assert (residual["unit"], residual["what"], len(residual["characteristics"])) == ("sigma", "residual", 2)


def test_diagnoses_are_those_of_the_command(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    of_type = seen_series.series(service.store, DiagnosisOptions("SHAFT"))
    assert vera.get("diagnosis/series/SHAFT").json() == json.loads(of_type.model_dump_json())
    of_part = seen_series.part(service.store, "2611", DiagnosisOptions("MODBAS2"))
    assert vera.get("diagnosis/part/2611?part_type=MODBAS2").json() == json.loads(of_part.model_dump_json())


def test_what_is_said_is_said_in_german_too(service: Running) -> None:
    """Every sentence of the calculation; numbers and names stay."""
    full_shop(service.store)
    vera = service.signed_in("viewer")
    english, shown = (vera.get(f"diagnosis/series/SHAFT?language={one}").json() for one in ("en", "de"))
    assert [one["key"] for one in shown["causes"]["candidates"]] == [
        one["key"] for one in english["causes"]["candidates"]
    ]
    pairs = list(zip(english["causes"]["candidates"], shown["causes"]["candidates"], strict=True))
    assert all(german()[one["remedy"]] == other["remedy"] for one, other in pairs)
    for name in ("key", "probability", "size_um"):
        assert all(one[name] == other[name] for one, other in pairs)
    assert english["causes"]["decide"] != shown["causes"]["decide"]


@pytest.mark.parametrize(
    ("path", "code"),
    [
        ("charts/SHAFT?characteristic=none", "MON-NONE"),
        ("charts/none", "SER-UNKNOWN"),
        ("charts/SHAFT?rules=9", "SRV-REQUEST"),
        ("charts/SHAFT?baseline=0", "SRV-REQUEST"),
        ("diagnosis/series/none", "DIA-NONE"),
        ("diagnosis/part/none?part_type=SHAFT", "DIA-NONE"),
        ("diagnosis/part/505?part_type=SHAFT&language=fr", "SRV-REQUEST"),
    ],
)
def test_what_cannot_be_worked_out_is_refused(service: Running, path: str, code: str) -> None:
    full_shop(service.store)
    assert problem(service.signed_in("viewer").get(path)) == code


def test_nothing_is_worked_out_twice_until_a_fact_comes(service: Running) -> None:
    """Eight who ask at once wait for one answer; a part more, and it is another; what is refused is not kept."""
    full_shop(service.store)
    studies, times = Studies(), list[int]()

    def work_out() -> int:
        times.append(len(times))
        return times[-1]

    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(lambda _: studies.of(service.store, "a", work_out), range(8))) == {0}
    assert studies.of(service.store, "b", work_out) == 1
    keep(service.store, [inspection("510", {"seat": 1.0})])
    assert studies.of(service.store, "a", work_out) == 2
    with pytest.raises(ZeroDivisionError):
        studies.of(service.store, "c", lambda: 1 // 0)
    assert studies.of(service.store, "c", work_out) == 3


def test_a_chart_shows_the_part_that_came_last(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    before = vera.get("charts/SHAFT?characteristic=seat").json()
    assert vera.get("charts/SHAFT?characteristic=seat").json() == before
    keep(service.store, [inspection("510", {"seat": 1.0})])
    after = vera.get("charts/SHAFT?characteristic=seat").json()
    counts = [one["characteristics"][0]["segments"][-1]["stop"] for one in (before, after)]
    assert counts == [10, 11]
