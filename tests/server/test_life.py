"""A part's life over HTTP is that of the store at this moment, whichever program wrote to it."""

import math
from dataclasses import replace

import pytest
from sqlalchemy import insert

from tests.support.service import Running
from tests.support.stores import AT, cut, link, part, touched
from trueloop.domain.part import Part
from trueloop.storage.schema import CERTIFICATE, EVENT, stamp
from trueloop.storage.store import find, keep, open_store


def test_what_another_program_keeps_shows_at_once(service: Running) -> None:
    keep(service.store, [part()])
    (row,) = (one.row for one in find(service.store, Part))
    vera, address = service.signed_in("viewer"), f"parts/{row}/life"
    empty = vera.get(address)
    assert empty.headers["ETag"] == '"0"'
    assert (empty.json()["inspections"], empty.json()["certificates"], empty.json()["events"]) == ([], [], [])
    other = open_store(service.store.engine.url.render_as_string(hide_password=False))
    given = touched()
    kept = keep(other, [given, cut(), link(given, cut())])
    (shown,) = vera.get(address).json()["inspections"]
    assert (shown["file"], shown["touches"], shown["stage"]) == (given.sha256, 3, "finish")
    assert shown["rms_um"] == pytest.approx(math.sqrt((0 + 1 + 4) / 49 / 3)), "errors of 0, 1/7 and 2/7 um"
    keep(other, [replace(given, values=given.values[:2], count=2)], supersedes=kept[0].row)
    (shown,) = vera.get(address).json()["inspections"]
    assert (shown["touches"], shown["rms_um"]) == (2, pytest.approx(math.sqrt(1 / 49 / 2)))
    said = {"at": stamp(AT), "who": "otto"}
    page = {"part": row, "sha256": "3" * 64, "verdict": "in", "content": b"page"}
    event = {"what": "certified", "subject": f"part:{row}", "document": '{"why": "in"}'}
    with other.writing() as connection:
        connection.execute(insert(CERTIFICATE).values(**said, **page))
        connection.execute(insert(EVENT).values(**said, **event))
    other.close()
    found = vera.get(address).json()
    assert [(one["serial"], one["made_by"], one["sha256"]) for one in found["certificates"]] == [
        ("17", "otto", "3" * 64)
    ]
    assert [(one["what"], one["values"]) for one in found["events"]] == [("certified", {"why": "in"})]
