"""docs/dialects.md says what the dialects do, not what they should do."""

import re
from pathlib import Path

import pytest

from tests.support.dialect_table import FEATURES, KEPT, NOT_YET, WORKS, controls, outcome, table
from trueloop.nc.program.dialect import DIALECTS

DOCUMENT = (Path(__file__).parents[3] / "docs" / "dialects.md").read_text(encoding="utf-8")


def test_the_page_carries_the_table_as_it_is_today() -> None:
    assert f"\n{table()}\n" in DOCUMENT
    assert f"\n{controls()}\n" in DOCUMENT


def test_every_dialect_is_introduced_and_has_a_program_that_works() -> None:
    introduced = re.findall(r"`([a-z0-9-]+)`", "".join(re.findall(r"^\| (`.*?) \|", DOCUMENT, re.M)))
    assert sorted(introduced) == sorted(DIALECTS)
    for dialect in DIALECTS:
        assert WORKS in {outcome(texts[dialect], dialect) for texts in FEATURES.values() if dialect in texts}


@pytest.mark.parametrize(
    ("text", "expected"), [("G21 G00 X1.", WORKS), ("G21 G68", KEPT), ("G21 G777", NOT_YET), ("G21 Ä", NOT_YET)]
)
def test_the_outcomes_are_told_apart(text: str, expected: str) -> None:
    assert outcome(text, "fanuc-lathe") == expected
