"""`trueloop serve --demo`: a shop of the examples, as its pages show it."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import TrueloopError
from trueloop.factory.shown.orders import order_rows, today
from trueloop.factory.shown.programs import proposal_views
from trueloop.jobs.db.imported import check_store
from trueloop.jobs.store.opened import open_store
from trueloop_lab.example_shop import make_example_shop


def test_every_list_of_the_pages_has_something_and_the_store_is_sound(tmp_path: Path) -> None:
    file = tmp_path / "shop.db"
    (tmp_path / "shop.db.unfinished").write_text("a run that was interrupted")
    make_example_shop(file)
    assert [one.name for one in tmp_path.iterdir()] == ["shop.db"]
    store = open_store(str(file))
    assert not check_store(store).findings
    (order,) = order_rows(store).items
    assert (order.quantity, order.held) == (4, 1)
    now = datetime.now(UTC)
    assert {one.action for one in today(store, now).waiting} == {"decide", "measure"}
    (proposal,) = proposal_views(store, now)
    before, after = (
        sum(abs(getattr(one, name)) for one in proposal.effects) for name in ("error_before_um", "error_after_um")
    )
    assert proposal.state == "accepted" and after < before
    store.close()


def test_a_folder_that_takes_no_file_is_refused_and_a_store_of_ones_own_is_not_filled(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError, match="STO-"):
        make_example_shop(tmp_path / "missing" / "shop.db")
    assert (
        "leave out --db" in invoke("serve", "--demo", "--db", str(tmp_path / "own.db"), status=ExitStatus.USAGE).stderr
    )
    assert not list(tmp_path.iterdir())
