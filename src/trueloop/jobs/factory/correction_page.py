"""The report of a stored correction, made anew from what was kept: the same words and pictures as on the day."""

from typing import Any

from trueloop.domain.correction import Correction
from trueloop.domain.page_options import Language
from trueloop.factory.known import unknown
from trueloop.loops.turned import correction as turned
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.page import page
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find


def correction_page(store: Store, number: str, language: Language) -> str:
    """One HTML file, by the id of the correction's record. Raises FAC-UNKNOWN, also for one of another product."""
    found: list[Correction[Any]] = [one.value for one in find(store, Correction, identity=joined((number,)))]
    made = found[-1].payload if found else None
    if not isinstance(made, turned.Correction):
        raise unknown("correction", number, "the store has no correction of a turned part with that id")
    return page(made, Texts(language, "mm"))
