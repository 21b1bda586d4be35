"""Lengths in mm or inch as the reader has chosen: every page beside itself, in both units, judged by arithmetic."""

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import expect

from tests.support.full_shop import full_shop
from tests.support.in_inches import OTHER, disagreement, unit_of
from tests.support.served import Browsing, Window, served, tell_corrector
from tests.web.test_charts import point
from tests.web.test_files import choose as hand_over
from tests.web.test_pages import pages_of
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.accounts import Change, change_account
from trueloop.server.identity.keys import ROLES
from trueloop.server.settings import now
from trueloop.storage.store import Store, open_store

BLOCKS = """() => {
    const main = document.querySelector('main').cloneNode(true);
    for (const one of main.querySelectorAll('.age, .contact, .diff, pre, select, .chart, .state')) one.remove();
    const said = [];
    for (const cell of main.querySelectorAll('td')) {
        const table = cell.closest('table');
        const head = table.querySelectorAll('th')[cell.cellIndex]?.textContent ?? '';
        said.push([table.getAttribute('aria-label'), head, cell.innerText ?? cell.textContent]);
    }
    for (const one of main.querySelectorAll('table')) one.remove();
    for (const one of main.querySelectorAll('dd'))
        said.push(['DL', one.previousElementSibling.textContent, one.textContent]);
    for (const one of main.querySelectorAll('h1, h2, h3, p, li, legend, label, figcaption, img'))
        said.push([one.tagName, '', one.alt ?? one.textContent]);
    return said;
}"""
DRAWN = """const before = CanvasRenderingContext2D.prototype.fillText; window.drawn = [];
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
        const at = this.getTransform().transformPoint(new DOMPoint(x, y));
        window.drawn.push([text, at.y, this.textAlign]); before.apply(this, arguments); }"""
"""Notes all that is written into pictures, with its height in the window."""
SIZES = b"""Serial;Characteristic;Feature;Nominal;Lower limit;Upper limit;Actual;Unit
a;Diameter 1;main-cylinder;89.408;89.390;89.430;89.4102;mm
"""


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    store = open_store(str(tmp_path_factory.mktemp("units") / "trueloop.db"), create=True, codec=store_codec())
    full_shop(store)
    yield store
    store.close()


@pytest.fixture(scope="module")
def served_shop(web: Browsing, shop: Store) -> Iterator[Browsing]:
    """The same browser on a service of its own, whose accounts choose."""
    with served(shop) as address:
        tell_corrector(shop, address)
        yield Browsing(web.browser, address)


@pytest.fixture
def own(served_shop: Browsing, shop: Store) -> Browsing:
    """The same, and nobody has chosen anything yet."""
    for role in ROLES:
        change_account(shop, role, Change(language="en", unit="mm"), now())
    return served_shop


def choose(window: Window, unit: str) -> None:
    """By Settings, as a person does."""
    window.go("/settings")
    window.page.get_by_label(re.compile("Unit of lengths|Einheit der Längen")).select_option(unit)
    window.settled()


def blocks(window: Window, path: str) -> list[list[str]]:
    window.go(path)
    if path == "/machines/lathe":  # of its corrector is told when the page is there
        window.page.get_by_role("img", name=re.compile("X: (correction|Korrektur)")).wait_for()
    found: list[list[str]] = window.page.evaluate(BLOCKS)
    return found


def in_inches(head: str) -> str:
    """A head of a column with the other unit."""
    unit = unit_of(head)
    return f"{head.removesuffix(unit)}{OTHER.get(unit, unit)}"


def in_german(window: Window) -> None:
    window.page.get_by_role("button", name="Deutsch").click()
    expect(window.page.locator("html")).to_have_attribute("lang", "de")


@pytest.mark.parametrize("language", ["en", "de"])
def test_every_page_says_the_same_lengths_in_either_unit(own: Browsing, language: str) -> None:
    """Each number with its unit, in cells by the head of the column, is 25.4 mm to the inch; all else is equal."""
    converted, said = set(), dict[str, dict[str, list[list[str]]]]()
    with own.window("admin") as window:
        window.go("/")
        if language == "de":
            in_german(window)
        for unit in ("mm", "inch"):
            choose(window, unit)
            said[unit] = {path: blocks(window, path) for path in pages_of(window) if path != "/settings"}
        assert window.complaints == []
    for path, metric in said["mm"].items():
        assert len(metric) == len(said["inch"][path]), path
        for (place, head, text), (_, its_head, its_text) in zip(metric, said["inch"][path], strict=True):
            assert its_head == in_inches(head), path
            assert disagreement(text, its_text, unit_of(head), language) == "", (path, place, head)
            converted |= {(path, place, head)} if text != its_text else set()
    assert {path.split("/")[1] for path, *_ in converted} == {
        *("charts", "correct", "diagnosis", "machines", "parts", "programs", "proposals", "series", "tools")
    }


def axis(window: Window) -> tuple[list[str], float, float]:
    """What is written into the picture of a series; its value at the height 0 and a pixel below, by its ticks."""
    window.go("/series/SHAFT/journal")
    window.until("window.drawn.length > 0")
    drawn = window.page.evaluate("window.drawn.splice(0)")
    ticks = [
        (float(text.replace("−", "-").replace(",", "")), height)
        for text, height, align in drawn
        if align == "right" and re.fullmatch(r"−?[\d.,]+", text)
    ]
    (first, top), (last, bottom) = ticks[0], ticks[-1]
    slope = (last - first) / (bottom - top)
    return [text for text, *_ in drawn], first - slope * top, slope


def test_axis_and_words_of_a_picture_are_in_the_unit_chosen(own: Browsing) -> None:
    """The same height of the picture is the same length: 1 µm is 39.37 µin."""
    with own.window("viewer") as window:
        window.page.add_init_script(DRAWN)
        window.go("/")
        texts, at_top, slope = axis(window)
        assert "deviation µm" in texts and not any("in" in text.split() or "µin" in text for text in texts)
        assert point(window, 0.99).startswith("509: +13.5 µm, expected +12.4 ± 5.4 µm")
        window.page.get_by_role("button", name="Inch").click()
        window.until("window.drawn.some(one => one[0] === 'deviation µin')")
        assert point(window, 0.99).startswith(
            "509: +531 µin, expected +489 ± "
        )  # 13.5 / 0.0254 = 531.5 before rounding
        window.go("/")
        window.page.evaluate("window.drawn.splice(0)")
        texts, its_top, its_slope = axis(window)
        assert "deviation µin" in texts and not any("µm" in text for text in texts)
        assert its_slope == pytest.approx(slope * 1000 / 25.4, rel=0.01)
        assert its_top == pytest.approx(at_top * 1000 / 25.4, rel=0.01)
        window.page.get_by_role("button", name="Millimetres").click()
        window.until("window.drawn.some(one => one[0] === 'deviation µm')")
        assert window.complaints == []


def test_pictures_of_the_service_are_asked_for_in_the_unit_chosen(own: Browsing) -> None:
    with own.window("viewer") as window:
        choose(window, "inch")
        window.go("/proposals/dome1")
        for one in window.page.locator("main img").all():
            source = str(one.get_attribute("src"))
            assert "unit=inch" in source
            drawn = window.page.evaluate("async at => (await fetch(at)).text()", source)
            assert "µin" in drawn and "µm" not in drawn


def test_the_choice_is_of_the_person_and_stays(own: Browsing) -> None:
    with own.window("operator") as window, own.window("engineer") as other:
        choose(window, "inch")
        window.go("/tools")
        expect(window.page.get_by_role("table")).to_contain_text("Nose radius in")
        other.go("/tools")
        expect(other.page.get_by_role("table")).to_contain_text("mm")
        window.page.reload()
        window.settled()
        expect(window.page.get_by_role("table")).to_contain_text("Nose radius in")
        with own.window("operator") as again:
            again.go("/tools")
            expect(again.page.get_by_role("table")).to_contain_text("Nose radius in")


def test_programs_are_never_converted_and_what_goes_into_a_certificate_is_asked_for_in_um(own: Browsing) -> None:
    with own.window("engineer") as window:
        (path,) = (one for one in pages_of(window) if "/diff/" in one)
        window.go(path)
        metric = window.page.locator(".diff").inner_text()
        choose(window, "inch")
        window.go(path)
        assert window.page.locator(".diff").inner_text() == metric != ""
        window.go("/parts/1")
        expect(window.page.get_by_label("Standard uncertainty of readings that state none, µm")).to_be_visible()


def test_what_is_read_in_a_file_is_shown_in_the_unit_chosen(own: Browsing) -> None:
    """89.408 mm are 3.52 in; the file's own unit stands above, as it is."""
    with own.window("operator") as window:
        window.go("/files")
        hand_over(window, "sizes.csv", SIZES)
        row = window.page.get_by_role("table").get_by_role("row").nth(1)
        expect(row).to_contain_text(re.compile("89.4080.*89.4102.*0.0022.*mm"))
        window.page.get_by_role("button", name="Inch").click()
        expect(row).to_contain_text(re.compile("3.520000.*3.520087.*0.000087.*in"))
        expect(window.page.get_by_role("region", name="sizes.csv")).to_contain_text("Measurement: table mm")
        window.page.get_by_role("button", name="Millimetres").click()
        expect(row).to_contain_text("89.4080")
