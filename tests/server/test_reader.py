"""In which unit a reader wants what is said: kept with the account; numbers of the service are in mm and µm for all."""

import pytest

from tests.support.full_shop import full_shop
from tests.support.in_inches import disagreement
from tests.support.service import Running, problem

SENTENCES = (
    "diagnosis/part/2611?part_type=MODBAS2",
    "diagnosis/series/SHAFT",
    "tools/1/memory",
    "series/SHAFT/journal",
)


def texts(value: object) -> list[str]:
    """All texts of an answer, in their order."""
    if isinstance(value, dict):
        return [text for one in value.values() for text in texts(one)]
    if isinstance(value, list):
        return [text for one in value for text in texts(one)]
    return [value] if isinstance(value, str) else []


def numbers(value: object) -> list[float]:
    """All numbers of an answer, in their order."""
    if isinstance(value, dict):
        return [number for one in value.values() for number in numbers(one)]
    if isinstance(value, list):
        return [number for one in value for number in numbers(one)]
    return [value] if isinstance(value, int | float) else []


def test_the_unit_is_of_the_account_and_of_its_next_session_too(service: Running) -> None:
    otto = service.signed_in("operator")
    assert otto.get("me").json()["unit"] == "mm"
    assert otto.ask("PATCH", "me", json={"unit": "inch"}).json()["unit"] == "inch"
    changed = otto.ask("PATCH", "me", json={"language": "de"}).json()
    assert (changed["unit"], changed["language"]) == ("inch", "de")
    assert otto.get("me").json()["unit"] == "inch"
    assert service.signed_in("operator").get("me").json()["unit"] == "inch"
    assert service.signed_in("viewer").get("me").json()["unit"] == "mm"
    assert problem(otto.ask("PATCH", "me", json={"unit": "cm"})) == "SRV-REQUEST"


@pytest.mark.parametrize("language", ["en", "de"])
@pytest.mark.parametrize("path", SENTENCES)
def test_sentences_are_in_the_unit_asked_for_and_numbers_as_their_names_say(
    service: Running, path: str, language: str
) -> None:
    full_shop(service.store)
    vera, sign = service.signed_in("viewer"), "&" if "?" in path else "?"
    metric, inch = (vera.get(f"{path}{sign}language={language}&unit={one}").json() for one in ("mm", "inch"))
    assert numbers(metric) == numbers(inch) != []
    assert [disagreement(*both, language=language) for both in zip(texts(metric), texts(inch), strict=True)] == [
        "" for _ in texts(metric)
    ]
    assert vera.get(f"{path}{sign}language={language}").json() == metric


def test_a_curve_and_its_words_are_in_the_unit_asked_for(service: Running) -> None:
    full_shop(service.store)
    vera = service.signed_in("viewer")
    (made,) = vera.get("parts/1/life").json()["corrections"]
    path = f"corrections/{made['id']}/curves"
    metric, inch = (vera.get(f"{path}?unit={one}").json()["items"] for one in ("mm", "inch"))
    assert all(disagreement(one["said"], other["said"]) == "" for one, other in zip(metric, inch, strict=True))
    for at in (f"{path}/{metric[0]['number']}", "proposals/dome1/picture"):
        drawn, its = (vera.get(f"{at}?unit={one}").text for one in ("mm", "inch"))
        assert "(µm)" in drawn and "µin" not in drawn
        assert "(µin)" in its and "µm" not in its and "(mm)" not in its


@pytest.mark.parametrize("path", [*SENTENCES, "charts/SHAFT", "proposals/dome1/picture"])
def test_a_unit_that_is_none_is_refused(service: Running, path: str) -> None:
    full_shop(service.store)
    assert problem(service.signed_in("viewer").get(f"{path}{'&' if '?' in path else '?'}unit=cm")) == "SRV-REQUEST"
