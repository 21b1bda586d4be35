"""`trueloop explain`: each code's meaning; a mistyped code names those it may be."""

import json

import pytest

from tests.support.cli import invoke, run
from trueloop.errors import Code


@pytest.mark.parametrize("given", ["CMP-SIZE", "cmp-size", "CMP_SIZE"])
def test_a_code_is_explained_however_it_is_written(given: str) -> None:
    assert run("explain", given) == (
        "CMP-SIZE: a correction larger than the limit.\nValues, in the JSON of a message: size_um, limit_um.\n"
    )


def test_a_code_without_values_says_its_meaning_alone() -> None:
    assert run("explain", "GEO-DXF") == "GEO-DXF: a drawing that cannot be read as a profile.\n"


def test_json_holds_what_the_catalogue_does() -> None:
    for code in Code:
        assert json.loads(run("explain", code, "--json")) == {
            "code": str(code),
            "meaning": code.meaning,
            "values": list(code.values),
        }


def test_a_mistyped_code_is_a_fault_of_the_command_line() -> None:
    assert "did you mean CMP-SIZE" in invoke("explain", "CMP-SIZ", status=2).output
    assert "docs/errors.md lists all of them" in invoke("explain", "?", status=2).output
