"""One service on a full shop, and one browser, for all tests of the pages that change nothing."""

from collections.abc import Iterator

import pytest

from tests.support.full_shop import full_shop
from tests.support.served import Browsing, browsing, served, tell_corrector
from trueloop.jobs.store.codec import store_codec
from trueloop.server.pages import folder_of
from trueloop.server.settings import Settings
from trueloop.storage.store import open_store


@pytest.fixture(scope="session")
def web(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browsing]:
    assert (folder_of(Settings()) / "index.html").is_file(), "the pages were not built: make web"
    store = open_store(str(tmp_path_factory.mktemp("web") / "trueloop.db"), create=True, codec=store_codec())
    full_shop(store)
    with served(store) as address, browsing(address) as found:
        tell_corrector(store, address)
        yield found
    store.close()
