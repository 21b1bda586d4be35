"""Fields explained by the text below them, without reading any source when a class is made."""

import inspect

import pytest
from pydantic import Field

from trueloop.described import Described, meanings


class Plain(Described):
    """A model with a field of each kind."""

    below: float
    """The text below,

    in two paragraphs."""
    given: int = Field(0, description="as it was made")
    """Not this one."""
    bare: int = 0


class Heir(Plain):
    bare: int = 1
    """Explained later."""


def test_a_field_is_explained_by_the_text_below_it_or_as_it_was_made() -> None:
    texts = {"below": "The text below,\n\nin two paragraphs.", "given": "as it was made"}
    assert meanings(Plain) == texts and meanings(Heir) == texts | {"bare": "Explained later."}
    properties = Heir.model_json_schema()["properties"]
    assert {name: one.get("description") for name, one in properties.items()} == meanings(Heir)


def test_no_source_is_read_when_a_class_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: object) -> None:
        raise AssertionError("source read")

    for name in ("getsource", "getsourcelines", "findsource", "getblock"):
        monkeypatch.setattr(inspect, name, refuse)

    class Later(Described):
        length_mm: float
        """A length."""

    assert Later(length_mm=1.0).length_mm == 1.0
