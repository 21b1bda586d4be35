"""The site, file by file: a value first, then written whole."""

import json
import shutil
import tomllib
from pathlib import Path
from typing import Final

from scripts import reference
from scripts.manual import layout
from scripts.manual.contents import ROOT, groups, pages
from scripts.manual.links import Files, redirect
from scripts.manual.markdown import headings, html_of, tokens_of
from scripts.manual.search_index import Entry, entries

ASSETS: Final = Path(__file__).parent / "assets"
FIRST: Final = ("cli.html", "errors.html", "job-file.html")
"""Of places that a search finds equally good, those of these pages come first: they define what others name."""
PLACE: Final = ROOT / "src" / "trueloop" / "manual"


def site() -> dict[str, bytes]:
    """Every file of the site by its name. Raises DeadLinkError."""
    lists, files = groups(), Files({one.source: one for one in pages()})
    made, places = {}, []
    words = tomllib.loads((Path(__file__).parent / "search_words.toml").read_text(encoding="utf-8"))
    for one in pages():
        tokens = tokens_of(one.text)
        redirect(tokens, one.source, files)
        names = words.pop(one.address.removesuffix(".html"), ())
        places += [
            Entry(one.title, one.title, one.address, [one.about], names),
            *entries(one.title, one.address, tokens),
        ]
        made[one.address] = layout.page(one, html_of(tokens), headings(tokens), lists).encode()
    if words:
        raise KeyError(f"search_words.toml has words of pages that the index does not list: {', '.join(words)}")
    made["search.html"] = layout.search(lists).encode()
    places.sort(key=lambda place: place.address.partition("#")[0] not in FIRST)
    rows = [place.as_list() for place in places if place.names or any(place.text)]
    made["search-index.js"] = f"const PLACES = {json.dumps(rows, ensure_ascii=False)};\n".encode()
    copied = files.copied | {file.name: file for file in ASSETS.iterdir()}
    return made | {name: _bytes_of(file) for name, file in copied.items()}


def _bytes_of(file: Path) -> bytes:
    return reference.text_of(file).encode() if reference.is_generated(file) else file.read_bytes()


def write(folder: Path = PLACE) -> int:
    """Writes the site into a folder of its own, and takes away what stood there."""
    made = site()
    shutil.rmtree(folder, ignore_errors=True)
    for name, content in made.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return len(made)
