"""Memory on the metal of [6811] Tables 8 to 11: ten parts in order, each predicted from those before it."""

import csv
import io
from collections.abc import Sequence

import numpy as np
import pytest

from studies.nist_memory import THREE, arcs, as_first, fitted, replayed
from studies.nist_memory_page import PAGE, page
from studies.replay.page import cut_um, inside, left_um, replay_page
from studies.replay.replay import Replayed
from studies.replay.table import COLUMNS, replay_csv

MODBAS2, PIECS11 = slice(1, 4), slice(5, 10)
"""Parts of a type but the first."""


def fits(of: slice) -> list[Replayed]:
    return [Replayed(part, 20, fitted(part.serial), True) for part in arcs()[of]]


@pytest.mark.parametrize(("of", "cut", "own"), [(MODBAS2, 5.10, 4.45), (PIECS11, 4.84, 5.33)])
def test_what_was_cut_and_what_a_fit_of_own_touches_would_have_left(of: slice, cut: float, own: float) -> None:
    """The measure itself: RMS of [6811] Tables 9 and 11 on the arcs, and today's fit on the rebuilt E = F + C."""
    assert cut_um(replayed()[of]) == pytest.approx(cut, abs=0.01)
    assert left_um(fits(of)) == pytest.approx(own, abs=0.01)


@pytest.mark.parametrize(
    ("touches", "of", "most"),
    [(None, MODBAS2, 3.5), (THREE, MODBAS2, 3.9), (None, PIECS11, 2.7), (THREE, PIECS11, 3.3)],
)
def test_what_memory_would_have_left(touches: Sequence[int] | None, of: slice, most: float) -> None:
    assert left_um(replayed(touches)[of]) <= most
    assert {one.touches for one in replayed(touches)[of]} == {20 if touches is None else 3}


def test_a_new_type_at_angles_that_were_seen() -> None:
    """Each of the six PIECS11 parts as if it had been the first."""
    assert [one.touches for one in as_first()] == [18, *[17] * 5]
    assert left_um(as_first()) <= 3.9 < cut_um(as_first())


def test_bands_hold() -> None:
    """95 % over all parts but the first, as far as nine parts can tell."""
    assert 0.93 <= inside(replayed()[1:]) <= 0.97
    assert 0.93 <= inside(replayed(THREE)[1:]) <= 0.98


def test_the_first_part_is_its_own_fit_and_new_angles_need_all_touches() -> None:
    first, *_ = replayed(THREE)
    assert first.own_fit and first.predicted is fitted("2511")
    assert [one.touches for one in replayed(THREE)] == [20, 3, 3, 3, 20, 3, 3, 3, 3, 3]


def test_the_table_of_a_replay() -> None:
    """Error measured less error predicted is what is left, from the text alone; points are those of the tables."""
    rows = list(csv.DictReader(io.StringIO(replay_csv(replayed()[5:6]))))
    assert tuple(rows[0]) == COLUMNS == (
        "part", "point", "phi_deg", "predicted_error_um", "band_um", "touches", "semifinish_um",
    )  # fmt: skip
    part = arcs()[5]
    assert [row["point"] for row in rows] == [str(k) for k in range(7, 27)]
    assert {row["part"] for row in rows} == {"3611"} and {row["touches"] for row in rows} == {"20"}
    uncorrected = part.uncorrected_mm
    assert uncorrected is not None
    left = 1000 * uncorrected - [float(row["predicted_error_um"]) for row in rows]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(left_um(replayed()[5:6]), abs=1e-3)
    band = np.array([float(row["band_um"]) for row in rows])
    assert np.mean(np.abs(left) <= band) == replayed()[5].inside
    assert [float(row["semifinish_um"]) for row in rows] == pytest.approx(1000 * part.semifinish.error_mm, abs=1e-3)
    largest = [float(row["phi_deg"]) for row in csv.DictReader(io.StringIO(replay_csv(replayed()[4:5])))]
    assert [largest[0], largest[-1]] == pytest.approx([102.3, 4.6], abs=0.05)


def test_the_page_of_a_replay_says_its_figures() -> None:
    memory = {"20 touches": replayed(), "3 touches": replayed(THREE)}
    html = replay_page("Ten <parts>", "NISTIR 6811", fits(slice(0, 10)), memory, as_first())
    assert "Ten &lt;parts&gt;" in html and "<parts>" not in html
    for figure in (cut_um(replayed()[PIECS11]), left_um(fits(PIECS11)), left_um(replayed(THREE)[PIECS11])):
        assert "<td class=n data-label" in html and f">{figure:.2f}<" in html
    assert html.count("<figure") == 11


def test_the_page_of_figures_is_what_the_code_gives() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run  python -m studies.nist_memory_page --write"
