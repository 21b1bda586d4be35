"""Every text of a turned part's page stands in both languages, with the same values; numbers follow the reader."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from string import Formatter

import pytest

from tests.support.correction import example_correction, size_error_correction
from trueloop.errors import Code
from trueloop.report.markup import text_of
from trueloop.report.texts.texts import Texts, german
from trueloop.report.turned.page import page
from trueloop.wording import Um, Worded, Wording, changed, wording

SOURCE = Path(__file__).parents[3] / "src" / "trueloop"
CALLS = {"say", "wording"}
ELSEWHERE = {"cli", "controllers"}
"""Folders where `say` is another function."""


ELSEWHERE_THAN_ON_PAGES = {"CEL", "CTL", "FIT", "LAB", "LNK", "MCH", "MTC", "OUT", "RTC", "SIM", "SRF", "VAL"}
"""Areas of codes that no page of the service meets."""


def texts_of_the_code() -> Iterator[str]:
    """The first argument of every call of `say` and `wording`; one that is no literal could not be translated."""
    for file in SOURCE.rglob("*.py"):
        if not ELSEWHERE & set(file.relative_to(SOURCE).parts):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in CALLS:
                    given = node.args[0]
                    if isinstance(given, ast.Constant):
                        yield str(given.value)
                    else:
                        assert ast.unparse(given) == "template", f"{file}: a text that is no literal"


def values_of(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name}


def test_every_text_has_a_translation_and_every_translation_a_text() -> None:
    meanings = {code.meaning for code in Code if code.partition("-")[0] not in ELSEWHERE_THAN_ON_PAGES}
    assert set(texts_of_the_code()) | meanings == set(german())


@pytest.mark.parametrize(("english", "translated"), list(german().items()))
def test_a_translation_has_the_values_and_the_tags_of_its_text(english: str, translated: str) -> None:
    assert values_of(english) == values_of(translated)
    assert set(re.findall("<[^>]*>", english)) - {"<br>"} == set(re.findall("<[^>]*>", translated)) - {"<br>"}


@pytest.mark.parametrize("part", ["modbas2", "piecs11", "facetst", "offset"])
def test_no_english_sentence_is_left_on_a_german_page(part: str) -> None:
    """Sentences of the calculation too; what a job or a program says is left as it is."""
    correction = size_error_correction() if part == "offset" else example_correction(part)
    shown = text_of(page(correction, Texts("de")).split("<script>")[0])
    for word in (" the ", " touches ", " of ", "standard deviation", "programmed", "predicted"):
        sentences = [
            s for s in re.split(r"(?<=[.;:])\s|\n", shown) if word in s and "N0" not in s and "option" not in s
        ]
        assert not sentences, sentences


def test_german_numbers_have_a_comma_and_keep_their_signs() -> None:
    say = Texts("de")
    assert (say.error(-1.25), say.size(1.25, 2), say.mm(44.7)) == ("−1,2", "1,25", "44,700")
    assert say("(bad: {percent:.1f} %)", percent=12.34) == "(fehlerhaft: 12,3 %)"
    assert say.note(wording("{x} (on the radius)", x=Um(-0.0443, "+.1f"))) == "−44,3 µm (am Radius)"


def test_inches_are_exact() -> None:
    """25.4 mm are an inch, 25.4 µm a thousand microinches; a slope of 1 µm/mm is 1000 µin/in."""
    say = Texts("en", "inch")
    assert (say.mm(25.4), say.error(25.4), say.size(-25.4), say.slope(1.0)) == ("1.0000", "+1000", "−1000", "+1000")
    assert say("error ({um})") == "error (µin)"
    assert say.note(wording("{x} (on the radius)", x=Um(-0.0254, "+.1f"))) == "−1000 µin (on the radius)"


def test_a_sentence_without_parts_is_left_as_it_is_behind_the_meaning_of_its_code() -> None:
    text, meaning = "a refusal: {this} has no parts", Code.MSR_KIND.meaning
    assert Texts("de").note(text) == Texts("en").refusal(meaning, text) == text
    assert Texts("de").refusal(meaning, text) == f"{german()[meaning]}: {text}"


def test_what_is_worded_is_so_after_a_journey_between_processes_and_without_a_folder() -> None:
    inner = wording("{reading} is in", reading="/tmp/x/a.csv")
    said = wording("{n} touches of {which}", n=3, which=inner)
    sent = Worded.of(said)
    assert isinstance(sent, Worded) and isinstance(sent.values["which"], Worded)
    there = changed(sent.text(), lambda text: text.replace("/tmp/x/", ""))
    assert isinstance(there, Wording) and there == "3 touches of a.csv is in" and there.template == said.template
    assert Worded.of("plain") == "plain"
