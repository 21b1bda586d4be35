"""A part corrected in the browser: program dropped, sizes typed, the wear number read; on a desk and on a telephone."""

import os
import re
from pathlib import Path

import pytest
from playwright.sync_api import FilePayload, expect

from tests.server.test_by_hand import AFTER, FEATURES, OF_SIDES, PLATE, READ, SHAFT, SIDES, drawing_of_sides
from tests.support.axe import findings
from tests.support.factory import Shop
from tests.support.served import NARROW, WIDE, Browsing, Window
from tests.web.test_decide import own, shop
from tests.web.test_pages import SMALL, WIDER
from trueloop.domain.record import sha256_of
from trueloop.jobs.factory.by_hand import made_before
from trueloop.jobs.factory.hand_job import AskedPart

__all__ = ["own", "shop"]
PICTURES = os.environ.get("TRUELOOP_SCREENSHOTS")
"""A folder for pictures of every step, to be looked at."""
CUT_OFF = """() => [...document.querySelectorAll('.mantine-Button-label')]
    .filter(one => one.scrollWidth > one.clientWidth).map(one => one.textContent)"""
PLATE_FILES = ("finish.nc", "part-1.dmo")


def usable(window: Window, name: str) -> None:
    """Nothing scrolls sideways or is cut off, fingers hit all, and it can be read aloud."""
    assert window.page.evaluate(WIDER) <= 0, name
    assert window.page.evaluate(CUT_OFF) == [], name
    assert window.page.evaluate(SMALL) == [], name
    assert findings(window) == [], name
    if PICTURES:
        window.page.screenshot(path=Path(PICTURES) / f"{name}.png", full_page=True)


def shown(window: Window, program: bytes = SHAFT) -> None:
    """Hands a program over that several controls could run: which it is, is asked for."""
    window.go("/files")  # the page begins anew
    window.go("/correct")
    handed(window, program)


def handed(window: Window, program: bytes) -> None:
    page = window.page
    page.get_by_label("Drop the finish program").set_input_files(
        {"name": "finish.nc", "mimeType": "text/plain", "buffer": program}
    )
    expect(page.locator("main")).to_contain_text("Program: finish.nc")
    page.get_by_label("Nose radius of the finishing tool").fill("0,8")
    page.get_by_role("button", name="Show the part").click()
    expect(page.get_by_role("alert").locator("code")).to_have_text("NC-DIALECT")
    page.get_by_label("Control").select_option("fanuc-lathe")
    page.get_by_role("button", name="Show the part").click()


def measured(window: Window, values: dict[str, str], serial: str) -> None:
    for name, value in values.items():
        window.page.get_by_role("textbox", name=re.compile(rf"^\d+ {name}$")).fill(value)
    window.page.get_by_label("Serial number or mark").fill(serial)
    window.page.get_by_label("± of the gauge").fill("4")


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["desk", "telephone"])
def test_a_shaft_is_corrected_and_the_next_one_asks_what_cut_it(
    own: Browsing, shop: Shop, size: tuple[int, int]
) -> None:
    with own.window("operator", size) as window:
        page = window.page
        shown(window)
        expect(page.get_by_role("img", name="cylinder-1")).to_be_visible()
        go = page.get_by_role("button", name="Correct", exact=True)
        expect(go).to_be_disabled()
        usable(window, f"part-{size[0]}")
        measured(window, READ, "0017")
        go.click()
        result = page.get_by_role("region", name="What to do")
        expect(result.get_by_role("link")).to_have_text("Download corrected.nc")
        expect(result).not_to_contain_text("wear X")  # never both
        usable(window, f"contour-{size[0]}")
        result.get_by_label("One of them, never both").select_option("wear")
        expect(result).to_contain_text("T3 wear X −0.022 mm (diameter), Z +0.000 (X ± 0.012")
        expect(result.get_by_role("link")).to_have_count(0)
        usable(window, f"wear-{size[0]}")
        expect(page.get_by_role("region", name="What to expect").locator("li").last).to_be_visible()  # every warning
        (known,) = made_before(shop.store, AskedPart(sha256_of(SHAFT), 0.8))
        with page.expect_download() as download:
            page.get_by_role("link", name="Download report.html").click()
        assert b"<svg" in Path(download.value.path()).read_bytes()

        for field in (page.get_by_label("cylinder-1 a"), page.get_by_label("Serial number or mark")):
            expect(field).to_have_value("")  # the second part
        expect(page.get_by_label("What cut this part")).to_have_value("")
        measured(window, AFTER, "0018")
        expect(page.locator("main")).to_contain_text("state what cut this part first")
        page.get_by_label("What cut this part").select_option("given")
        expect(go).to_be_enabled()
        page.get_by_label("What cut this part").select_option(f"{known.id} wear")
        of = re.compile(f"this program, with the wear number of {known.id}, T3, part 0017")
        expect(page.get_by_label("What cut this part")).to_have_accessible_description(of)
        expect(result).to_have_count(0)
        go.click()
        expect(result).to_contain_text("T3 wear X")
        expect(page.get_by_label("What cut this part")).to_have_value("")
        expect(page.get_by_label("What cut this part").locator("option")).to_have_count(2 + 2 * 2)
        assert window.complaints == []


def test_what_is_wrong_is_shown_with_its_code_and_a_question_is_answered(own: Browsing) -> None:
    with own.window("engineer", NARROW) as window:
        page = window.page
        window.go("/correct")
        expect(page.get_by_role("button", name="Show the part")).to_be_disabled()
        shown(window, SHAFT.replace(b"G21 ", b""))
        expect(page.get_by_role("alert").locator("code")).to_have_text("NC-UNIT")
        usable(window, "question")
        page.get_by_label("Unit").select_option("mm")
        page.get_by_role("button", name="Show the part").click()
        expect(page.get_by_role("img", name="cylinder-1")).to_be_visible()
        measured(window, {**READ, "cylinder-3 a": "1.1817"}, "1")
        page.get_by_role("button", name="Correct", exact=True).click()
        expect(page.get_by_role("alert").locator("code")).to_have_text("MSR-NOMINAL")
        usable(window, "refused")
        page.get_by_role("button", name="Menu").click()
        page.get_by_role("button", name="Deutsch").click()
        page.get_by_role("button", name="Menü").click()
        page.get_by_role("button", name="Korrigieren", exact=True).click()
        alert = page.get_by_role("alert")
        expect(alert).to_contain_text("'cylinder-3 a' ist 1,1817 mm, Nennmaß 30: Kein Fehler eines Schnitts")
        expect(page.locator("main")).to_contain_text("Länge 80,000")
        usable(window, "refused-german")
    with own.window("viewer") as window:
        window.go("/correct")
        expect(window.page.locator("main")).to_contain_text("needs the role operator; you are viewer")
        assert window.complaints == []


def test_no_answer_is_sent_with_the_next_program_and_no_text_counts_as_a_number(own: Browsing) -> None:
    with own.window("operator") as window:
        page = window.page
        shown(window, SHAFT.replace(b"G21 ", b""))
        page.get_by_label("Unit").select_option("inch")
        expect(page.get_by_label("Nose radius of the finishing tool")).to_have_value("0,8")
        with page.expect_request("**/by-hand/part*") as asked:
            handed(window, SHAFT)  # which asks what its control is: the answer before is forgotten
        sent = asked.value.post_data_json or {}
        assert sent["unit"] is None and sent["dialect"] is None
        expect(page.get_by_role("img", name="cylinder-1")).to_be_visible()
        expect(page.get_by_label("Unit")).to_have_count(0)

        measured(window, READ, "1")
        go, wrong = page.get_by_role("button", name="Correct", exact=True), "correct or empty the marked fields first"
        expect(go).to_be_enabled()
        for label, text, good in (("± of the gauge", "4 my", "4"), ("per side (on the radius)", "0.2.", "")):
            page.get_by_label(label).fill(text)
            expect(page.get_by_label(label)).to_have_attribute("aria-invalid", "true")
            expect(go).to_be_disabled()
            expect(page.locator("main")).to_contain_text(wrong)
            page.get_by_label(label).fill(good)
            expect(go).to_be_enabled()
        page.get_by_label("Tool number").fill("T3")
        expect(page.get_by_role("button", name="Show the part")).to_be_disabled()
        expect(page.locator("main")).to_contain_text("This is not a whole number from 1.")


def test_typed_lengths_keep_their_size_when_the_reader_changes_the_unit(own: Browsing) -> None:
    """0.254 mm are 0.01 inch and 4 µm are 157.4803 µinch, by 25.4 mm; the service is sent what was typed."""
    with own.window("operator") as window:
        page = window.page
        shown(window)
        measured(window, READ, "1")
        page.get_by_label("per side (on the radius)").fill("0,254")
        page.get_by_role("button", name="Inch").click()
        for label, text in (
            ("Nose radius of the finishing tool, in", "0,03149606"),
            ("± of the gauge (k = 2), µin", "157.4803"),
            ("per side (on the radius), in", "0,01"),
        ):
            expect(page.get_by_label(label)).to_have_value(text)
        with page.expect_request("**/by-hand/correction*") as asked:
            page.get_by_role("button", name="Correct", exact=True).click()
        sent = asked.value.post_data_json or {}
        assert sent["part"]["nose_radius_mm"] == 0.8
        assert sent["measured"]["expanded_uncertainty_um"] == 4
        assert sent["measured"]["measured_allowance_mm"] == 0.254
        page.get_by_role("button", name="Millimetres").click()
        expect(page.get_by_label("Nose radius of the finishing tool, mm")).to_have_value("0,8")


def test_the_page_states_how_the_program_was_read_and_takes_the_tip_and_the_tool_number(own: Browsing) -> None:
    with own.window("operator") as window:
        page = window.page
        shown(window, SHAFT.replace(b"G42 ", b""))
        expect(page.locator("main")).to_contain_text("Without G41 or G42 the pass was taken for the path of the nose's")
        expect(page.get_by_role("textbox", name="Tool number")).to_have_accessible_description(re.compile("T, not D"))
        page.get_by_label("Orientation of the tip").select_option("3")
        with page.expect_request("**/by-hand/part*") as asked:
            page.get_by_role("button", name="Show the part").click()
        assert (asked.value.post_data_json or {})["tip"] == 3
        expect(page.locator("main")).to_contain_text("taken for the path of the tip of orientation 3")
        usable(window, "notes")


def test_a_file_of_measurements_without_a_unit_is_given_one(own: Browsing) -> None:
    rows = "".join(f"{name.partition(' ')[0]};diameter;{value}\n" for name, value in READ.items())
    with own.window("operator") as window:
        page = window.page
        window.go("/correct")
        page.get_by_label("Drop the finish program").set_input_files(
            {"name": "sizes.csv", "mimeType": "text/csv", "buffer": f"Feature;Quantity;Actual\n{rows}".encode()}
        )
        expect(page.locator("main")).to_contain_text("Measurement: sizes.csv")
        handed(window, SHAFT)
        page.get_by_label("Unit of the measurements").select_option("mm")
        with page.expect_request("**/by-hand/correction*") as asked:
            page.get_by_role("button", name="Correct", exact=True).click()
        assert (asked.value.post_data_json or {})["measured"]["file_unit"] == "mm"


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["desk", "telephone"])
def test_a_part_of_two_set_ups_is_corrected_by_a_program_and_a_wear_number(
    own: Browsing, size: tuple[int, int]
) -> None:
    """The journey of `tests/server/test_by_hand.py`, whose docstring has the figures, without a terminal."""
    with own.window("operator", size) as window:
        page = window.page
        window.go("/correct")
        files = [("first.nc", SIDES[0]), ("second.nc", SIDES[1]), ("shaft.dxf", drawing_of_sides())]
        page.get_by_label("Drop the finish program").set_input_files(
            [FilePayload(name=name, mimeType="text/plain", buffer=content) for name, content in files]
        )
        first, second = (page.get_by_role("group", name=f"Set-up {k}") for k in (1, 2))
        expect(first).to_contain_text("Program: first.nc")
        expect(second).to_contain_text("Program: second.nc")
        for setup, tool, zero in ((first, "1", "0"), (second, "2", "-80")):
            setup.get_by_label("Nose radius of the finishing tool").fill("0,8")
            setup.get_by_label("Offset number of tool 1").fill(tool)
            setup.get_by_label("where this program’s Z is 0").fill(zero)
        second.get_by_role("button", name="Add another tool").click()
        second.get_by_label("Nose radius of tool 2").fill("0.4")
        second.get_by_label("Offset number of tool 2").fill("4")
        page.get_by_role("button", name="Show the part").click()
        expect(page.get_by_role("alert").locator("code")).to_have_text("NC-DIALECT")
        first.get_by_label("Control").select_option("Fanuc, turning")
        page.get_by_role("button", name="Show the part").click()
        expect(page.get_by_role("alert").locator("code")).to_have_text("SET-MIRROR")
        expect(page.get_by_role("alert")).not_to_contain_text("[[setups]]")
        usable(window, f"setups-refused-{size[0]}")
        second.get_by_label("The part is turned round").check()
        page.get_by_role("button", name="Show the part").click()
        expect(page.locator("main")).to_contain_text("side1: T1, side2: T2, side2: T4. Control: Fanuc, turning")
        measured(window, OF_SIDES, "0017")
        usable(window, f"setups-{size[0]}")
        page.get_by_role("button", name="Correct", exact=True).click()
        result = page.get_by_role("region", name="What to do")
        expect(result).to_contain_text("T2 wear X −0.0100 mm (diameter), Z −0.0050")
        expect(result.get_by_role("link")).to_have_text("Download corrected-side1.nc")
        usable(window, f"setups-result-{size[0]}")
        expect(page.get_by_label("What cut this part").locator("option")).to_have_count(2 + 1)
        page.get_by_label("What cut this part").select_option(index=2)
        measured(window, OF_SIDES, "0018")
        page.get_by_role("button", name="Correct", exact=True).click()
        expect(page.get_by_role("region", name="What to expect")).to_contain_text("Z −10.0 µm, of which X −5.0 µm")
        assert window.complaints == []


@pytest.mark.parametrize("size", [WIDE, NARROW], ids=["desk", "telephone"])
def test_a_milled_part_is_answered_with_numbers_to_enter(own: Browsing, size: tuple[int, int]) -> None:
    """The file of a measuring machine with other names, then values typed; in English and in German."""
    with own.window("operator", size) as window:
        page = window.page
        window.go("/correct")
        page.get_by_label("Part", exact=True).select_option("milled")
        files = [
            FilePayload(name=name, mimeType="text/plain", buffer=(PLATE / name).read_bytes()) for name in PLATE_FILES
        ]
        page.get_by_label("the entries.json of the last answer").set_input_files(files)
        expect(page.locator("main")).to_contain_text("Measurement: part-1.dmo")
        page.get_by_role("button", name="Show the part").click()
        expect(page.get_by_role("alert").locator("code")).to_have_text("NC-DIALECT")
        page.get_by_label("Control", exact=True).select_option("Fanuc, milling")
        page.get_by_role("button", name="Show the part").click()
        go = page.get_by_role("button", name="Find the numbers to enter")
        go.click()
        expect(page.get_by_role("alert").locator("code")).to_have_text("MIL-NONE")
        expect(page.get_by_role("alert")).not_to_contain_text("[names]")
        for theirs, feature in FEATURES.items():
            page.get_by_label(f"Name in the measurement: {feature}", exact=True).select_option(theirs)
        usable(window, f"milled-part-{size[0]}")
        go.click()
        result = page.get_by_role("region", name="What to do")
        expect(result).to_contain_text("tool 2, radius (D22): add -0.020 mm")
        expect(result).to_contain_text("G54, rotation about Z: add -0.012°")
        expect(result.get_by_role("link", name="entries.json")).to_be_visible()
        usable(window, f"milled-result-{size[0]}")
        page.get_by_role("button", name="Remove part-1.dmo").click()
        expect(go).to_be_disabled()
        page.get_by_role("textbox", name="bore1 diameter", exact=True).fill("11,980; 11,980")
        page.get_by_label("Tolerance, mm: bore1 diameter").fill("H7")
        if size == NARROW:
            page.get_by_role("button", name="Menu").click()
        page.get_by_role("button", name="Deutsch").click()
        if size == NARROW:
            page.get_by_role("button", name="Menü").click()
        page.get_by_role("button", name="Zahlen zum Eingeben bestimmen").click()
        expect(page.get_by_role("region", name="Was zu tun ist")).to_contain_text("Werkzeug 2, Radius (D22): -0,01")
        usable(window, f"milled-typed-{size[0]}")
