"""What explains the alarms of a series: signs and sizes of what is known, and of a diagnosis."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from tests.support.series import inspection
from trueloop.diagnosis.causes.cause import Candidate, Cause, Diagnosis
from trueloop.loops.monitor.chart import ChartOptions, MonitoredSeries, chart_of
from trueloop.loops.monitor.known import PartFacts
from trueloop.loops.post_process.series import PartSeen, series_of
from trueloop.loops.post_process.tracked import TrackedSeries, tracked

SCATTER = np.random.default_rng(4773).normal(0.0, 1.0, 30)
STEP = 8.0 * (np.arange(30) >= 20)


def followed(errors_um: Sequence[float], taken_um: Sequence[float] = (), set_at: int = -1) -> TrackedSeries:
    """A series of one diameter; `taken_um` is what a correction took off each part."""
    plain = [
        PartSeen(inspection(str(100 + k), {"journal": e}), set_before=k == set_at) for k, e in enumerate(errors_um)
    ]
    (first,) = series_of(plain)
    parts = [
        replace(one, correction_mm={first.identity: taken / 1000})
        for one, taken in zip(plain, taken_um or [0.0] * len(plain), strict=True)
    ]
    return tracked(series_of(parts)[0])


def charted(series: TrackedSeries, diagnosis: Diagnosis | None = None, **options: object) -> MonitoredSeries:
    facts = [PartFacts(one.made.serial) for one in series.parts]
    return chart_of(series, facts, ChartOptions(**{"baseline": 15, **options}), diagnosis)  # type: ignore[arg-type]


def test_a_proposal_that_took_size_off_is_named_with_its_sign() -> None:
    """8 µm taken off from part 120 on: the size changes by −8 µm, and so do the values."""
    (episode, *_) = charted(followed((SCATTER - STEP).tolist(), STEP.tolist())).episodes
    first = episode.explained.likely[0]
    assert first.kind == "proposal accepted" and first.words == "the size was changed by −8.0 µm before part 120"
    assert first.size < 0 and first.probability > 0.8


def test_offsets_that_were_entered_are_known_with_their_sign() -> None:
    """60 µm taken off a diameter that stood 60 µm too large, from the second part on: neither wear nor a step."""
    taken = np.array([0.0, *[0.060] * 7])
    series = followed((SCATTER[:8] + 60.0 - 1e3 * taken).tolist())
    facts = [
        PartFacts(one.made.serial, taken_off_mm=float(off), cut_with="correction 1" if off else "")
        for one, off in zip(series.parts, taken, strict=True)
    ]
    first = chart_of(series, facts, ChartOptions()).episodes[0].explained.likely[0]
    assert first.words == "the size was changed by −60.0 µm before part 101: correction 1"
    assert first.size < 0 and first.probability > 0.6


def test_wear_that_leaves_more_on_has_a_positive_size() -> None:
    found = charted(followed((SCATTER + 0.5 * np.arange(30)).tolist())).episodes[-1].explained
    wear = next(one for one in found.likely if one.kind == "wear")
    assert wear.size > 3.0 * wear.size_u > 0.0


def test_residuals_have_the_sign_of_the_errors() -> None:
    found = charted(followed((SCATTER + STEP).tolist()), what="residual")
    at = found.serials.index("120")
    assert found.charted.values[at] > 2.0 and found.capability is None


def test_a_tool_set_anew_begins_a_segment_where_that_is_asked_for() -> None:
    series = followed((SCATTER + STEP).tolist(), set_at=20)
    assert charted(series).episodes[0].explained.likely[0].kind == "tool set"
    assert [one.first for one in charted(series, anew=True).charted.segments] == [0, 20]
    assert charted(series, anew=True).charted.sigma < 2e-3


def test_a_diagnosis_shares_what_nothing_known_explains() -> None:
    cause = Cause("offset", "tool offset", (), 0.1, "", "", "")
    candidate = Candidate(cause, ("journal",), 0.75, 0.008, 0.001, ("seen by both",))
    series = followed((SCATTER + STEP).tolist())
    alone, with_it = charted(series), charted(series, Diagnosis((candidate,), (), 0.2))
    before, after = alone.episodes[0].explained, with_it.episodes[0].explained
    added = next(one for one in after.likely if one.kind == "offset")
    assert added.probability == pytest.approx(0.75 * before.unknown)
    assert after.unknown == pytest.approx(0.25 * before.unknown)
    assert added.size == pytest.approx(0.008 / with_it.charted.sigma) and added.words == "seen by both"
