"""What people change by the pages: it is done, or refused with its reason; others see it at once."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.support.factory import OPERATOR, SHA, Shop
from tests.support.full_shop import full_shop
from tests.support.served import Browsing, served
from trueloop.domain.factory import PartState, StepState
from trueloop.factory import requests as ask
from trueloop.factory.shown.orders import order_view
from trueloop.jobs.store.codec import store_codec
from trueloop.storage.store import open_store


@pytest.fixture
def shop(tmp_path: Path) -> Iterator[Shop]:
    store = open_store(str(tmp_path / "trueloop.db"), create=True, codec=store_codec())
    yield full_shop(store)
    store.close()


@pytest.fixture
def own(shop: Shop, web: Browsing) -> Iterator[Browsing]:
    """The same browser on a service of its own, which a test may change."""
    with served(shop.store) as address:
        yield Browsing(web.browser, address)


def test_a_held_part_is_decided_and_others_see_it_at_once(own: Browsing, shop: Shop) -> None:
    with own.window("operator") as window, own.window("viewer") as other:
        other.go("/orders/O1")
        window.go("/parts/2")
        cut = window.page.get_by_role("button", name="It was not cut")
        expect(cut).to_be_disabled()
        expect(window.page.locator("main")).to_contain_text("give a reason first")
        window.page.get_by_label("Reason").fill("looked: it is as it was")
        cut.click()
        expect(window.page.get_by_role("heading", name="Next: step 0")).to_be_visible()
        expect(other.page.get_by_role("row").filter(has_text="planned")).to_have_count(1)
        part = order_view(shop.store, shop.order).parts[1]
        assert (part.state, part.steps[0]) == (PartState.PLANNED, StepState.WAITING)
        assert window.complaints == other.complaints == []


def test_who_may_not_is_told_why(own: Browsing) -> None:
    with own.window("viewer") as window:
        window.go("/parts/2")
        window.page.get_by_label("Reason").fill("I would like to")
        expect(window.page.get_by_role("button", name="It was cut")).to_be_disabled()
        expect(window.page.locator("main")).to_contain_text("needs the role operator; you are viewer")
        window.go("/orders")
        expect(window.page.get_by_role("button", name="Plan an order")).to_be_disabled()
        expect(window.page.locator("main")).to_contain_text("needs the role engineer; you are viewer")


def test_a_refusal_shows_its_code_and_what_to_do(own: Browsing, shop: Shop) -> None:
    """Somebody changed the order after this page had read it, and no news of that came."""
    with own.window("operator") as window:
        window.page.context.route("**/events", lambda route: route.abort())
        window.go("/parts/2")
        shop.do(ask.Hold(shop.order, 1, "scratched"), OPERATOR)
        window.page.get_by_label("Reason").fill("it was cut")
        window.page.get_by_role("button", name="It was cut").click()
        refused = window.page.get_by_role("alert")
        expect(refused).to_contain_text("FAC-STALE")
        expect(window.page.get_by_label("Reason")).to_have_value("it was cut")
        window.page.get_by_role("button", name="It was cut").click()
        expect(window.page.get_by_role("heading", name="Next: step 1")).to_be_visible()


def test_an_order_is_planned(own: Browsing, shop: Shop) -> None:
    with own.window("engineer") as window:
        window.go("/orders/new")
        page = window.page
        page.get_by_label("Part type").fill("shaft")
        page.get_by_label("Revision").fill("B")
        page.get_by_label("Machine").select_option("lathe")
        page.get_by_label("Serial numbers").fill("c\nd\n")
        page.get_by_label("Job").fill("[part]")
        page.get_by_role("button", name="Plan an order").click()
        expect(page.get_by_role("alert")).to_contain_text("FAC-PLAN")
        for no, name in ((0, "semifinish"), (1, "probe"), (3, "finish")):
            step = page.get_by_role("group", name=f"Step {no}")
            step.get_by_label("Released program").select_option(f"{name}.ngc {SHA[name][:12]}")
        page.get_by_role("button", name="Plan an order").click()
        expect(page.get_by_role("heading", level=1, name="Order O3")).to_be_visible()
        made = order_view(shop.store, "O3")
        assert [one.serial for one in made.parts] == ["c", "d"]
        assert [one.kind.value for one in made.blocks] == [
            *("semifinish", "probe", "correct", "finish", "remove", "measure")
        ]


def test_all_that_waits_leads_to_where_it_is_decided(own: Browsing, shop: Shop) -> None:
    """An alarm is acknowledged, a proposal accepted, and the change of a program seen."""
    with own.window("engineer") as window:
        page = window.page
        window.go("/")
        page.get_by_role("link", name="acknowledge").first.click()
        alarm = page.get_by_role("row").filter(has_text="2 of 3 beyond")
        alarm.get_by_label("Reason").fill("tool changed")
        alarm.get_by_role("button", name="acknowledge").click()
        expect(alarm).to_contain_text("engineer")
        window.go("/")
        page.get_by_role("link", name="review").click()
        page.get_by_label("Reason").fill("as I measured too")
        page.get_by_role("button", name="Accept").click()
        expect(page.locator("main")).to_contain_text("accepted")
        window.go("/parts/1")
        page.get_by_role("link", name="→").click()
        expect(page.locator(".diff .after").first).to_contain_text("G1 X0.99")
        assert window.complaints == []


def test_a_certificate_is_made_and_opened_and_can_reach_nothing(own: Browsing, shop: Shop) -> None:
    """The page that opens is the one kept; it stands in a sandbox, without our cookies."""
    with own.window("operator") as window:
        window.go("/parts/1")
        expect(window.page.get_by_role("button", name="Make certificate")).to_be_disabled()
    with own.window("engineer") as window:
        page = window.page
        window.go("/parts/1")
        page.get_by_label("Its language").select_option("de")
        page.get_by_role("button", name="Make certificate").click()
        links = page.get_by_role("link", name="Certificate ↗")
        expect(links).to_have_count(2)
        window.go("/certificates")
        with page.expect_popup() as opened:
            page.get_by_role("link", name="Certificate ↗").first.click()
        certificate = opened.value
        certificate.wait_for_load_state()
        assert certificate.evaluate("document.documentElement.lang") == "de"
        certificate.set_viewport_size({"width": 400, "height": 800})
        assert certificate.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
        assert certificate.evaluate("[self.origin, window.opener]") == ["null", None]
        assert "dome" in certificate.inner_text("body")
