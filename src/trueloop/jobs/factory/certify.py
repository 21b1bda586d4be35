"""A part's certificate, made from the store and kept in it."""

from datetime import datetime

from trueloop.domain.page_options import Language
from trueloop.domain.part import Part
from trueloop.domain.record import sha256_of
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import unknown
from trueloop.factory.requests import Certify
from trueloop.factory.roles import By
from trueloop.jobs.monitor.certificate import certificate_of
from trueloop.report.monitor.certificate import certificate_page
from trueloop.report.texts.texts import Texts
from trueloop.storage.store import Store, find


def certify(store: Store, part: int, language: Language, by: By, now: datetime, u_um: float | None = None) -> str:
    """Certifies the part in this row; returns the hash of the page. Raises FAC-UNKNOWN, FAC-ROLE, and MON errors.

    `u_um`: standard uncertainty of readings that state none.
    """
    found = next((one.value for one in find(store, Part) if one.row == part), None)
    if found is None:
        raise unknown("part", str(part), "the store has no such row")
    shape = certificate_of(store, found.serial, found.part_type.name, u_um, by.name)
    page = certificate_page(shape, Texts(language, "mm")).encode()
    carry_out(store, Certify(part, page, shape.outcome), by, now)
    return sha256_of(page)
