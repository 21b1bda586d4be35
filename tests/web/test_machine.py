"""One machine: what it does, its corrector as it works, and what is too old in grey."""

import re

from playwright.sync_api import expect

from tests.support.served import Browsing


def test_a_machine_shows_what_it_does_and_where_that_leads(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/machines")
        window.page.get_by_role("link", name="lathe").click()
        main = window.page.locator("main")
        expect(window.page.get_by_role("heading", level=1)).to_have_text("lathe")
        expect(main).to_contain_text("finish.ngc")
        expect(main).to_contain_text("radius_mm 0.9987")
        expect(window.page.get_by_role("row").filter(has_text="spindle")).to_contain_text("24.90")
        expect(window.page.get_by_role("button", name="The probe was calibrated now")).to_be_disabled()
        expect(main).to_contain_text("needs the role operator; you are viewer")
        main.get_by_role("link", name="b", exact=True).click()
        expect(window.page).to_have_url(re.compile("/parts/2$"))
        assert window.complaints == []


def test_the_corrector_is_drawn_as_it_works(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/machines/lathe")
        expect(window.page.get_by_role("img", name="X: correction µm over the last minute")).to_be_visible()
        over = window.page.locator(".chart .u-over").first
        box = over.bounding_box()
        assert box is not None
        over.hover(position={"x": 0.02 * box["width"], "y": 9})
        # at its begin x is 20 mm: 0.3 µm/mm in force, of it 0.2 by the model and 0.1 by the table
        expect(window.page.locator(".pointed").first).to_have_text(
            re.compile(
                r"^0\.[01] s: in force 6\.\d\d µm, asked for by the model 4\.\d\d µm, .* by the table 2\.\d\d µm$"
            )
        )
        assert window.complaints == []


def test_a_corrector_of_which_nobody_tells_says_how_it_is_told(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/machines/mill")
        expect(window.page.locator("main")).to_contain_text("trueloop realtime watch --cell")
        assert "stale" in (window.page.locator("dl.facts").first.get_attribute("class") or "")
        assert window.complaints == []
