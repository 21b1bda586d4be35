"""Links to controls as the service shows them: what a file of settings says of each, and its last transfer."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

from trueloop.factory.shown.machines import all_machines
from trueloop.factory.shown.records import known_of, last_transfers
from trueloop.factory.views.orders import LinksView, LinkView
from trueloop.formats.links_toml import read_links
from trueloop.jobs.links import link_of
from trueloop.storage.store import Store


def links_view(store: Store, settings: Path | None, now: datetime) -> LinksView:
    """Returns all links in the file, and all with recorded transfers; connects to no control. Raises LNK-FILE."""
    stated = [] if settings is None else list(_stated(settings))
    with known_of(store) as known:
        last = last_transfers(known)
        machines = {one.name for one in all_machines(known, now)}
    named = {name for name, *_ in stated}
    every = [*stated, *((name, "", "") for name in last if name not in named)]
    items = (LinkView(name, kind, where, name in machines, last.get(name)) for name, kind, where in sorted(every))
    return LinksView(settings is not None, tuple(items))


def _stated(settings: Path) -> Iterator[tuple[str, str, str]]:
    """Name, kind and address of each; passwords stand in the environment, not in the file."""
    for kind, tables in read_links(settings).by_kind.items():
        for name, table in tables.items():
            yield name, kind, link_of(table, settings.parent, lambda _: None).where
