"""Every way in which tools and edges are refused."""

from collections.abc import Callable

from tests.support.tools import NOW, at, mount, put, set_anew, turn
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.errors import Code
from trueloop.jobs.tools import edge_of, require_touches_since
from trueloop.storage.store import Store, open_store


def _mounted() -> Store:
    store = open_store("sqlite://", create=True)
    mount(store, at(8))
    return store


def _past() -> object:
    store = _mounted()
    set_anew(store, at(9))
    return set_anew(store, at(8, 30))


def _ended() -> object:
    store = _mounted()
    turn(store, "2", at(10))
    put(store, "remove", at(11))
    return edge_of(store, Edge(Tool(3, "SVJBR 2020"), "VBMT 160408", "1"), 3, at(12))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.EDG_UNKNOWN: lambda: put(_mounted(), "set", at(9), tool="T4"),
    Code.EDG_OTHER: lambda: edge_of(_mounted(), Edge(Tool(3), corner="2"), 3, at(9)),
    Code.EDG_ENDED: _ended,
    Code.EDG_POCKET: lambda: mount(_mounted(), at(9), holder="PCLNR 2525"),
    Code.EDG_CORNER: lambda: turn(_mounted(), "1", at(9)),
    Code.EDG_VALUE: lambda: mount(_mounted(), at(9), nose_radius_mm=None),
    Code.EDG_TIME: lambda: set_anew(_mounted(), NOW.replace(hour=20)),
    Code.EDG_PAST: _past,
    Code.EDG_SETTING: lambda: require_touches_since(Setting(Edge(Tool(3, "SVJBR 2020")), at(10)), at(9)),
}
