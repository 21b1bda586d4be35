"""What a person does and sees in the browser: a decision on a held part, and every page."""

import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from playwright.sync_api import Page, expect, sync_playwright

from scripts.factory_demo.office import PASSWORD, READINGS

ROUTES: Final = Path(__file__).parents[2] / "web" / "src" / "frame" / "routes.ts"
WIDE: Final = {"width": 1400, "height": 900}
WAIT_MS: Final = 30_000.0
SETTLES_MS: Final = 200.0
FLAGS: Final = ("--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu")


@contextmanager
def window(address: str, name: str) -> Iterator[Page]:
    """A browser in which somebody has signed in."""
    program = shutil.which("chromium")
    assert program, "Chromium is not installed: apt-get install -y --no-install-recommends chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        try:
            page = browser.new_page(viewport=WIDE, locale="en-GB", color_scheme="light")  # type: ignore[arg-type]
            page.set_default_timeout(WAIT_MS)
            page.goto(address)
            page.get_by_label("Name").fill(name)
            page.get_by_label("Password", exact=True).fill(PASSWORD)
            page.get_by_role("button", name="Sign in").click()
            expect(page.get_by_label("Password", exact=True)).to_have_count(0)
            _settled(page)
            yield page
        finally:
            browser.close()


def decide(page: Page, address: str, button: str, why: str, picture: Path) -> None:
    """Decides on the page of a held part, once more where the cell has changed the part meanwhile.

    The picture is of what the person sees before.
    """
    page.goto(address)
    _settled(page)
    page.get_by_label("Reason").first.fill(why)
    page.screenshot(path=picture)
    decided, changed = page.get_by_role("button", name=button), page.get_by_role("alert").filter(has_text="FAC-STALE")
    for _ in range(READINGS):
        decided.click()
        page.wait_for_timeout(SETTLES_MS)
        until = time.monotonic() + WAIT_MS / 1000
        while decided.count() and not changed.count():
            assert time.monotonic() < until, f"{address}: no answer to {button!r}"
            page.wait_for_timeout(SETTLES_MS)
        if not decided.count():
            return
    raise AssertionError(f"{address}: the part changed {READINGS} times while it was decided on")


def pictures(page: Page, address: str, folder: Path) -> dict[str, str]:
    """A picture of each page of the pages' own list: addresses by route; of pages with a number where a link leads."""
    routes = re.findall(r'path: "([^"]+)"', ROUTES.read_text(encoding="utf-8"))
    assert routes, f"{ROUTES} lists no page"
    patterns = {route: re.compile(re.sub(r":\w+", "[^/]+", route)) for route in routes}
    found: dict[str, str] = {route: route for route in routes if ":" not in route}
    seen: dict[str, str] = {}
    while left := [route for route in found if route not in seen]:
        for route in left:
            page.goto(address + found[route])
            _settled(page)
            page.screenshot(path=folder / f"{_name(route)}.png", full_page=True)
            seen[route] = found[route]
            for link in _links(page):
                fits = [one for one in routes if patterns[one].fullmatch(link)]
                if fits and fits[0] not in found and not any(link == one for one in routes):
                    found[fits[0]] = link
    return seen


def _links(page: Page) -> list[str]:
    """Addresses of the pages that this one leads to, the last first: the last part is the one most is known of."""
    here: list[str] = page.eval_on_selector_all("a[href^='/']", "all => all.map(one => one.getAttribute('href'))")
    return here[::-1]


def _settled(page: Page) -> None:
    page.locator("main h1").first.wait_for()
    expect(page.locator("main .mantine-Loader-root")).to_have_count(0, timeout=WAIT_MS)


def _name(route: str) -> str:
    return re.sub(r"\W+", "-", route).strip("-") or "today"
