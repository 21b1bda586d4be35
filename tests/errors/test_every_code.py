"""Every code of the catalogue is produced, and what it says helps the person who reads it.

Each `test_<area>.py` beside this file holds `PRODUCERS`: for a code, a call that is refused with it or that returns
findings of which one has it.
"""

import importlib
import re
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from scripts.error_page import PAGE, page
from tests.errors.expected import kept, words
from trueloop.errors import Code, Finding, TrueloopError

AREAS = sorted(file.stem for file in Path(__file__).parent.glob("test_*.py") if file != Path(__file__))
PRODUCERS: list[tuple[str, Code, Callable[[], object]]] = [
    (area, code, produce)
    for area in AREAS
    for code, produce in importlib.import_module(f"tests.errors.{area}").PRODUCERS.items()
]
NUMBER_OR_QUOTED = re.compile(r"\d|'[^']+'|\"[^\"]+\"|`[^`]+`")


@pytest.fixture(scope="module")
def expected() -> dict[str, str]:
    return kept()


def complaint(code: Code, produce: Callable[[], object]) -> TrueloopError | Finding:
    """The error raised, or the finding of that code among those returned."""
    try:
        produced = produce()
    except TrueloopError as error:
        return error
    findings = produced if isinstance(produced, Iterable) else [produced]
    of_this_code = [item for item in findings if isinstance(item, Finding) and item.code is code]
    assert of_this_code, f"neither raised nor found: {produced!r}"
    return of_this_code[0]


def test_every_code_is_produced() -> None:
    missing = set(Code) - {code for _, code, _ in PRODUCERS}
    assert not missing, f"no test produces {', '.join(sorted(missing))}"


def test_every_code_is_its_name_in_words() -> None:
    assert all(code.value == code.name.replace("_", "-") for code in Code)


@pytest.mark.parametrize(
    ("area", "code", "produce"),
    [pytest.param(area, code, produce, id=f"{area.removeprefix('test_')}-{code}") for area, code, produce in PRODUCERS],
)
def test_the_complaint_names_code_values_hint_and_place(
    area: str, code: Code, produce: Callable[[], object], expected: dict[str, str]
) -> None:
    said = complaint(code, produce)
    assert said.code is code
    assert words(said) == expected[f"{area} {code}"], "if it is meant so: python -m tests.errors.expected"
    assert NUMBER_OR_QUOTED.search(said.message), f"no value in {said.message!r}"
    assert said.hint.strip()
    if isinstance(said, TrueloopError):
        place = "".join(
            f"{part}:" for part in (said.place.file, said.place.line, said.place.column) if part is not None
        )
        assert str(said).startswith(f"{place} {code}: {said.message}" if place else f"{code}: {said.message}")
        assert f"hint: {said.hint}" in str(said)
        assert said.override is None or said.override in str(said)


def test_every_code_has_a_meaning_of_its_own() -> None:
    meanings = [code.meaning for code in Code]
    assert all(meanings)
    assert len(set(meanings)) == len(meanings)


def test_the_page_of_errors_is_the_catalogue() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python -m scripts.error_page`"
