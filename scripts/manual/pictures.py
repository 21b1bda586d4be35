"""The pictures of the manual, made anew: pages that the commands of a tutorial have written, as a browser shows them.

`python -m scripts.manual.pictures [NAME …]` runs a tutorial in a folder of its own and photographs what is there then.
It needs Chromium.
"""

import os
import sys
import tempfile
from collections.abc import Iterable
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from scripts.manual.contents import ROOT
from tests.support.dialogue import run_page
from tests.support.full_shop import full_shop
from tests.support.served import browsing, served
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import open_store

IMAGES: Final = ROOT / "docs" / "images"
MOST_BYTES: Final = 150_000
LEAN: Final = ".kicker, .fields, .note, .button { display: none !important; } h2 { margin-top: 24px !important; }"


@dataclass(frozen=True)
class Picture:
    """What is photographed: a file that the page's commands write, from the top to the end of an element.

    `hidden`: what of it is left out, so that the rest can be read in the width of the manual.
    """

    page: str
    file: str
    until: str
    hidden: str = ""
    width: int = 860


PICTURES: Final = {
    "first-part-sheet": Picture("first-part.md", "shaft/sheet.html", "body"),
    "first-part-report": Picture("first-part.md", "shaft/out/report.html", "#before-after", "#tolerances, #errors"),
    "probe-report": Picture("probe-tutorial.md", "out/loop/report.html", "#before-after", "#tolerances, #errors, #run"),
    "cmm-series": Picture("cmm-tutorial.md", "replayed/replay.html", "#series-2", "#characteristics"),
    "machine-report": Picture("machine-tutorial.md", "out/machine/machine.html", "#term-EXX"),
    "surface-report": Picture(
        "surface-tutorial.md", "out/surface/pattern.html", "#uncertainty", "#measured, #deterministic, #random"
    ),
}
"""By name of the file."""


OF_THE_SERVICE: Final = {"shop-today": "/"}
"""Pages of the service on a shop in full work, by address."""


def take(names: Iterable[str]) -> None:
    """Makes these pictures; a page of several is run once."""
    wanted = {name: PICTURES[name] for name in names if name in PICTURES}
    for name, address in OF_THE_SERVICE.items():
        if name in names:
            photograph_service(address, IMAGES / f"{name}.png")
    for page in sorted({picture.page for picture in wanted.values()}):
        with tempfile.TemporaryDirectory() as folder, chdir(folder):
            os.environ |= {"USER": "ana", "LOGNAME": "ana", "TZ": "UTC"}
            run_page(ROOT / "docs" / page)
            for name, picture in wanted.items():
                if picture.page == page:
                    photograph(Path(folder), picture, IMAGES / f"{name}.png")


def photograph(folder: Path, picture: Picture, png: Path) -> None:
    """Of a page that a tutorial has written."""
    file = next(folder.rglob(picture.file))
    with browsing(file.as_uri()) as browser, browser.window(size=(picture.width, 800)) as window:
        window.page.goto(file.as_uri())
        hidden = f"{picture.hidden} {{ display: none !important; }}" if picture.hidden else ""
        window.page.add_style_tag(content=LEAN + hidden)
        box = window.page.locator(picture.until).first.bounding_box()
        assert box is not None
        height = box["y"] + box["height"] + 8
        window.page.screenshot(
            path=png, full_page=True, clip={"x": 0.0, "y": 0.0, "width": float(picture.width), "height": height}
        )
    check(png)


def photograph_service(address: str, png: Path) -> None:
    """A page as an engineer sees it. The pages are those that `make web` built."""
    with tempfile.TemporaryDirectory() as folder:
        store = open_store(f"{folder}/trueloop.db", create=True, codec=store_codec())
        full_shop(store)
        with served(store) as at, browsing(at) as browser, browser.window("engineer", (1000, 760)) as window:
            window.go(address)
            window.page.screenshot(path=png)
        store.close()
    check(png)


def check(png: Path) -> None:
    """Raises ValueError for a picture that is too large for a page that is read over a slow line."""
    if (size := png.stat().st_size) > MOST_BYTES:
        raise ValueError(f"{png.name}: {size} bytes, more than {MOST_BYTES}")
    print(f"{png.relative_to(ROOT)}: {size} bytes")


if __name__ == "__main__":
    take(sys.argv[1:] or [*PICTURES, *OF_THE_SERVICE])
