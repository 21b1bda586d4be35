"""The manual in a real browser: readable narrow and wide, light and dark; the search finds what it should."""

import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.manual.contents import pages
from tests.support.axe import findings
from tests.support.manual import served_manual
from tests.support.served import NARROW, WIDE, Browsing, Window, browsing

WIDER = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"
TELLING = (
    "index.html",
    "first-part.html",
    "signs.html",
    "shop-tutorial.html",
    "dialects.html",
    "python.html",
    "search.html?q=wear+offset",
)
"""Pages that hold all that a page can hold: lists, code, tables, pictures, what a search found."""


SOUGHT = tomllib.loads(Path(__file__).with_name("searched_words.toml").read_text(encoding="utf-8"))
"""Words of the shop, English and German, by the page whose place must stand first."""
FIRST = """queries => queries.map(words => {
  show(words);
  return (document.querySelector("#found a")?.getAttribute("href") ?? "").split(".html")[0];
})"""


@pytest.fixture(scope="module")
def shown(manual: Path) -> Iterator[Browsing]:
    with served_manual(manual) as address, browsing(address) as found:
        yield found


def go(window: Window, page: str) -> None:
    window.page.goto(window.address + page)


@pytest.mark.parametrize(("dark", "size"), [(False, NARROW), (True, WIDE)], ids=["light-narrow", "dark-wide"])
def test_axe_finds_nothing(shown: Browsing, dark: bool, size: tuple[int, int]) -> None:
    """Colours are those of the scheme, names and the order of things those of the width."""
    with shown.window(dark=dark, size=size) as window:
        for page in TELLING:
            go(window, page)
            assert findings(window) == [], page
        assert window.complaints == []


def test_no_page_is_wider_than_a_telephone_or_complained_of(shown: Browsing) -> None:
    with shown.window(size=NARROW) as window:
        for page in pages():
            go(window, page.address)
            assert window.page.evaluate(WIDER) <= 0, page.address
        assert window.complaints == []


@pytest.mark.parametrize(
    ("words", "page", "holds"),
    [
        ("diameter or radius", "", "diameter"),
        ("G41", "", "G41"),
        ("wear offset", "", "wear offset"),
        ("CMP-TWICE", "errors.html#row-cmp-twice", "CMP-TWICE"),
        ("coverage", "", "coverage"),
        ("cut_to_cut_um", "job-file.html#row-cut_to_cut_um", "cut_to_cut_um"),
        ("--supersede", "cli.html#row---supersede", "--supersede"),
        ("aufmass", "glossary.html", "Aufmaß"),
    ],
)
def test_the_search_finds(shown: Browsing, words: str, page: str, holds: str) -> None:
    """First what is named so; where a word stands in many places, places that hold it."""
    with shown.window() as window:
        go(window, "index.html")
        window.page.keyboard.press("/")
        window.page.keyboard.type(words)
        window.page.keyboard.press("Enter")
        found = window.page.locator("#found li")
        found.first.wait_for()
        assert holds.lower() in found.first.inner_text().lower()
        assert (found.first.locator("a").get_attribute("href") or "").startswith(page)
        found.first.locator("a").click()
        window.page.locator("main h1").wait_for()
        assert window.complaints == []


def test_the_words_of_the_shop_lead_to_the_page_that_answers(shown: Browsing) -> None:
    wanted = {words: page for page, queries in SOUGHT.items() for words in queries}
    assert len(wanted) > 350
    assert led_to(shown, list(wanted)) == wanted


def test_a_misspelt_word_leads_where_the_word_does(shown: Browsing) -> None:
    """One letter lost, two letters swapped, one letter wrong, each in the middle of the word."""
    wanted = dict[str, str]()
    for page, queries in SOUGHT.items():
        for word in (one for one in queries if one.isalpha() and len(one) >= 7):
            at = len(word) // 2
            made = (word[:at] + word[at + 1 :], word[:at] + word[at + 1] + word[at] + word[at + 2 :])
            wanted |= dict.fromkeys((*made, f"{word[:at]}x{word[at + 1 :]}"), page)
    led = led_to(shown, list(wanted))
    assert len(wanted) > 300 and sum(led[word] == page for word, page in wanted.items()) >= 0.98 * len(wanted)


def test_a_misspelt_word_is_shown_as_it_was_searched(shown: Browsing) -> None:
    with shown.window() as window:
        go(window, "search.html?q=passwrod")
        assert window.page.locator("#count").inner_text().endswith("Searched: password.")


def led_to(shown: Browsing, queries: list[str]) -> dict[str, str]:
    """The page of the first place by query."""
    with shown.window() as window:
        go(window, "search.html")
        return dict(zip(queries, window.page.evaluate(FIRST, queries), strict=True))


def test_words_that_are_nowhere_are_not_found(shown: Browsing) -> None:
    with shown.window() as window:
        go(window, "search.html?q=<img src=x onerror=alert(1)>zzqx")
        assert window.page.locator("#count").inner_text() == "0 places."
        assert window.page.locator("main img").count() == 0 and window.complaints == []


def test_a_dialogue_is_copied_without_what_the_computer_says(shown: Browsing) -> None:
    with shown.window() as window:
        window.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        go(window, "first-part.html")
        window.page.locator("figure.console .copy").nth(2).click()
        copied = window.page.evaluate("() => navigator.clipboard.readText()")
        assert copied == "trueloop measure read shaft/readings.csv --job shaft/job.toml\n"
