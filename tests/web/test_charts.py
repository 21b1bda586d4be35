"""Pictures over parts, angles and time: drawn, said in words too, and of the values that the service gives."""

import re

from playwright.sync_api import expect

from tests.support.served import Browsing, Window

INKED = """() => { const one = document.querySelector('.chart canvas');
    return new Set(one.getContext('2d').getImageData(0, 0, one.width, one.height).data).size }"""


def point(window: Window, share: float) -> str:
    """What is said of the place in the picture that is so far from its left."""
    over = window.page.locator(".chart .u-over")
    box = over.bounding_box()
    assert box is not None
    over.hover(position={"x": share * box["width"], "y": box["height"] / 2})
    said = window.page.locator(".pointed")
    expect(said).not_to_be_empty()
    return said.inner_text()


def test_a_series_is_drawn_and_a_part_of_it_said_where_one_points(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/series/SHAFT/journal")
        expect(window.page.get_by_role("img", name="journal over parts: 10 parts")).to_be_visible()
        assert window.page.evaluate(INKED) > 20
        assert point(window, 0.99).startswith("509: +13.5 µm, expected +12.4 ± 5.4")
        assert point(window, 0.01).startswith("500: +9.0 µm")
        assert window.complaints == []


def test_what_a_picture_shows_stands_in_the_table_too(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/series/SHAFT/journal")
        rows = window.page.get_by_role("table", name="Parts").get_by_role("row")
        expect(rows).to_have_count(11)
        expect(rows.filter(has_text="504")).to_contain_text("tool set")
        expect(window.page.locator("main")).to_contain_text("0.27 → 0.73 at part 504")
        rows.filter(has_text="507").get_by_role("link").click()
        expect(window.page.get_by_role("heading", level=1)).to_have_text(re.compile("PCLNL"))


def test_an_edge_says_what_it_remembers_and_what_the_next_part_needs(web: Browsing) -> None:
    with web.window("viewer", locale="de-DE") as window:
        window.go("/tools/1")
        main = window.page.locator("main")
        expect(main).to_contain_text("From 3 parts, 3 of them inspected")
        expect(window.page.get_by_role("row").filter(has_text="MODBAS2 B")).to_contain_text("1 of 31")
        whole = point(window, 0.5)
        window.page.get_by_label("Curve").select_option("")
        expect(
            window.page.get_by_role("img", name=re.compile("form of the edge over the contact angle"))
        ).to_be_visible()
        assert point(window, 0.51) != whole
        assert window.complaints == []


def test_pictures_follow_dark_and_light_and_the_width(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/series/SHAFT/journal")
        canvas = window.page.locator(".chart canvas")
        wide = canvas.bounding_box()
        window.resize((400, 800))
        window.until("document.querySelector('.chart canvas').clientWidth < 380")
        narrow = canvas.bounding_box()
        assert wide and narrow and narrow["width"] < wide["width"] / 2
        before = window.page.evaluate("document.querySelector('.chart canvas').toDataURL()")
        window.page.emulate_media(color_scheme="dark")
        window.until("before => document.querySelector('.chart canvas')?.toDataURL() !== before", before)
        assert window.complaints == []


def test_control_charts_say_what_alarms_and_what_may_explain_it(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/series/SHAFT/seat")
        window.page.get_by_role("link", name="Control charts").click()
        row = window.page.get_by_role("row").filter(has_text="509")
        expect(row).to_contain_text("one value beyond 3 σ")
        expect(row).to_contain_text("a step that nobody knows of")
        expect(window.page.get_by_role("row").filter(has_text="Cpk")).to_be_visible()
        expect(window.page.get_by_role("img", name="Individuals of seat: 10 parts")).to_be_visible()
        window.page.get_by_label("Values").select_option("residual")
        expect(window.page.get_by_role("heading", name="Capability")).to_have_count(0)
        window.page.get_by_label("Nelson’s tests").select_option("all")
        expect(window.page.locator("main .mantine-Loader-root")).to_have_count(0)
        assert window.complaints == []


def test_a_diagnosis_names_causes_with_evidence_and_what_would_decide(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/diagnosis")
        window.page.get_by_role("link", name="SHAFT", exact=True).click()
        main = window.page.locator("main")
        expect(main).to_contain_text("The probability that nothing acts is")
        expect(main).to_contain_text("What would decide")
        window.page.get_by_role("link", name="505", exact=True).click()
        expect(window.page.get_by_role("heading", level=1)).to_have_text("Diagnosis: 505, SHAFT")
        expect(window.page.get_by_role("row").filter(has_text="CMM or gauge").first).to_be_visible()
        window.go("/diagnosis/none")
        expect(window.page.get_by_role("alert")).to_contain_text("DIA-NONE")


def test_a_change_of_a_program_stands_beside_the_curves_it_was_made_for(web: Browsing) -> None:
    """Pictures and words: of who sees none, `alt` says what the curve reaches."""
    with web.window("viewer") as window:
        window.go("/parts/1")
        named = "finish.ngc → finish.ngc corrected for part a (rev B)"
        window.page.get_by_role("link", name=named).click()
        expect(window.page.get_by_role("heading", name=named)).to_be_visible()
        dome = window.page.get_by_role("img", name=re.compile("Error curve of dome: .* is material left on"))
        dome.scroll_into_view_if_needed()
        window.until("one => one.complete && one.naturalWidth > 100", dome.element_handle())
        light = dome.get_attribute("src")
        window.page.get_by_role("button", name="Dark").click()
        expect(dome).not_to_have_attribute("src", str(light))
        window.until("one => one.complete && one.naturalWidth > 100", dome.element_handle())
        window.go("/programs")
        row = window.page.get_by_role("row").filter(has_text="finish.ngc corrected for part a (rev B)")
        expect(row.get_by_role("link", name="Change of the program")).to_be_visible()
        assert window.complaints == []


def test_a_proposal_is_seen_and_how_the_last_part_was_corrected(web: Browsing) -> None:
    with web.window("viewer", locale="de-DE") as window:
        window.go("/proposals/dome1")
        main = window.page.locator("main")
        expect(main).to_contain_text("How part 2711, the last one behind it, was corrected")
        window.until("document.querySelector('img.picture').naturalWidth > 100")
        assert window.page.locator("img.picture").count() > 2
        assert window.complaints == []
