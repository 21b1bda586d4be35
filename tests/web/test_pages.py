"""Every page for every role, wide and narrow: nothing is complained of, all is readable, and fingers hit it."""

import json
from pathlib import Path

import pytest

from tests.support.axe import findings
from tests.support.full_shop import SCRIPT
from tests.support.served import NARROW, WIDE, Browsing, Window

FINGER_PX = 48
PAGES = (
    "/",
    "/orders",
    "/orders/O1",
    "/orders/new",
    "/parts",
    "/parts/1",
    "/parts/2",
    "/proposals",
    "/proposals/dome1",
    "/programs",
    "/correct",
    "/files",
    "/certificates",
    "/alarms",
    "/settings",
    "/machines",
    "/machines/lathe",
    "/machines/mill",
    "/series",
    "/series/SHAFT/journal",
    "/charts/SHAFT/seat",
    "/diagnosis",
    "/diagnosis/SHAFT",
    "/diagnosis/MODBAS2/parts/2611",
    "/tools",
    "/tools/1",
    "/wall",
)
SMALL = """() => [...document.querySelectorAll('a, button, input, select, textarea, [role=button]')]
    .filter(one => !one.matches('.skip') && one.checkVisibility())
    .map(one => one.matches('[type=checkbox]') ? one.closest('.mantine-Checkbox-body') : one)
    .map(one => [one.outerHTML.slice(0, 120), one.getBoundingClientRect()])
    .filter(([, box]) => box.width < SIZE - 0.5 || box.height < SIZE - 0.5)
    .map(([html, box]) => `${box.width} x ${box.height}: ${html}`)""".replace("SIZE", str(FINGER_PX))
WIDER = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"


LIFE = "async () => (await (await fetch('/api/v1/parts/1/life')).json()).corrections[0]"


def pages_of(window: Window) -> tuple[str, ...]:
    """All of them, with the change of a program, whose address is of hashes."""
    window.go("/")
    made = window.page.evaluate(LIFE)
    return *PAGES, f"/programs/{made['source_sha256']}/diff/{made['corrected_sha256']}"


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_every_page_can_be_read_touched_and_understood(web: Browsing, dark: bool) -> None:
    with web.window("admin", dark=dark) as window:
        for path in pages_of(window):
            window.go(path)
            for size in (WIDE,) if dark else (NARROW, WIDE):  # sizes are those of either scheme
                window.resize(size)
                if size == (
                    WIDE if dark else NARROW
                ):  # axe looks at colours and names, which are those of either width
                    assert findings(window) == [], (path, size)
                _is_shown(window, path, size)
                assert window.page.evaluate(SMALL) == [], (path, size)
        assert window.complaints == []


def _is_shown(window: Window, path: str, size: tuple[int, int]) -> None:
    assert window.page.locator("main h1").first.inner_text(), path
    assert window.page.evaluate(WIDER) <= 0, f"{path} scrolls sideways at {size}"


@pytest.mark.parametrize("role", ["viewer", "operator", "engineer"])
def test_every_page_opens_for_every_role(web: Browsing, role: str) -> None:
    """On a phone: what fits there for an administrator and for this role fits a desk as well."""
    with web.window(role) as window:
        window.resize(NARROW)
        for path in pages_of(window):
            window.go(path)
            _is_shown(window, path, NARROW)
        assert window.complaints == []


def test_a_script_in_a_name_is_a_text(web: Browsing) -> None:
    """Of machine, part type, serial number, reason, alarm and program: all of them are on these pages."""
    with web.window("admin") as window:
        for path in ("/", "/orders", "/parts", "/parts/3"):
            window.go(path)
            assert SCRIPT in window.page.locator("main").inner_text().replace("\n", ""), path
            assert window.page.locator("main img, main script").count() == 0, path
        assert window.complaints == []


def test_the_first_load_is_small(web: Browsing) -> None:
    """All that a browser loads before it shows Today: at most 250 kB, packed as on the way."""
    import gzip

    folder = Path(__file__).parents[2] / "src" / "trueloop" / "pages"
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    wanted, files = {"index.html", "src/pages/Today.tsx"}, set()
    while wanted:
        one = manifest[wanted.pop()]
        files |= {one["file"], *one.get("css", ())}
        wanted |= {name for name in one.get("imports", ()) if manifest[name]["file"] not in files}
    packed = sum(len(gzip.compress((folder / name).read_bytes())) for name in files)
    assert 50_000 < packed <= 250_000
