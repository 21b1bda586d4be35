"""The report of a stored correction and its pictures, made anew from what was kept: the same as on the day."""

from datetime import datetime
from typing import Any

from trueloop.domain.option import Language
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, sha256_of
from trueloop.errors import TrueloopError
from trueloop.factory.carry_out import carry_out
from trueloop.factory.known import unknown
from trueloop.factory.requests import By, Certify
from trueloop.jobs.monitor.certificate import certify_part
from trueloop.loops.turned import correction as turned
from trueloop.report.monitor.certificate import certificate_page
from trueloop.report.style import in_the_dark
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures.curves import CurvePicture, curve_pictures, curve_svg
from trueloop.report.turned.page import WIDTHS, page
from trueloop.report.turned.sources import source_svg
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find
from trueloop.wording import wording


def correction_page(store: Store, number: str, language: Language) -> str:
    """Returns one HTML file, by the id of the correction's record. Raises FAC-UNKNOWN, also for another product's."""
    return page(_turned(store, number), Texts(language, "mm"))


def correction_curves(store: Store, number: str, say: Texts) -> tuple[CurvePicture, ...]:
    """Returns the error curves that have a picture; none of a correction of another product. Raises FAC-UNKNOWN."""
    made = _payload(store, number)
    return tuple(curve_pictures(made, say)) if isinstance(made, turned.Correction) else ()


def curve_picture(store: Store, number: str, feature: int, say: Texts, *, narrow: bool, dark: bool) -> str:
    """Draws one feature's error curve (SVG). Raises FAC-UNKNOWN."""
    made = _turned(store, number)
    if feature not in {picture.number for picture in curve_pictures(made, say)}:
        raise unknown(wording("feature"), str(feature), f"the correction {number} has no error curve of that number")
    drawn = curve_svg(made, feature, WIDTHS["narrow" if narrow else "wide"], say)
    return in_the_dark(drawn) if dark else drawn


def sources_picture(store: Store, number: str, say: Texts, *, narrow: bool, dark: bool) -> str:
    """Draws the shares of all sources in the errors of each feature (SVG). Raises FAC-UNKNOWN."""
    drawn = source_svg(_turned(store, number), WIDTHS["narrow" if narrow else "wide"], say)
    return in_the_dark(drawn) if dark else drawn


def _turned(store: Store, number: str) -> turned.Correction:
    made = _payload(store, number)
    if not isinstance(made, turned.Correction):
        raise _unknown(number)
    return made


def _payload(store: Store, number: str) -> object:
    found: list[Correction[Any]] = [stored.value for stored in find(store, Correction, identity=joined((number,)))]
    if not found:
        raise _unknown(number)
    return found[-1].payload


def _unknown(number: str) -> TrueloopError:
    return unknown(wording("correction"), number, wording("the store has no correction of a turned part with that id"))


def certify(store: Store, part: int, language: Language, by: By, now: datetime, u_um: float | None = None) -> str:
    """Certifies a part; returns the page's hash. Raises FAC-UNKNOWN, FAC-ROLE, MON. `u_um`: of readings without u."""
    found = next((stored.value for stored in find(store, Part) if stored.row == part), None)
    if found is None:
        raise unknown(wording("part"), str(part), wording("the store has no such row"))
    shape = certify_part(store, found.serial, found.part_type.name, u_um, by.name)
    page = certificate_page(shape, Texts(language, "mm")).encode()
    carry_out(store, Certify(part, page, shape.outcome), by, now)
    return sha256_of(page)
