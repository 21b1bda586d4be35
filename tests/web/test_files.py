"""Files handed over in the browser: read and shown, kept only when that is pressed, and then released."""

from hashlib import sha256

from playwright.sync_api import expect

from tests.support.axe import findings
from tests.support.factory import Shop
from tests.support.served import NARROW, WIDE, Browsing, Window
from tests.web.test_decide import own, shop
from tests.web.test_pages import SMALL, WIDER
from trueloop.domain.inspection import Inspection
from trueloop.domain.record import Program
from trueloop.storage.store import find

__all__ = ["own", "shop"]
FACE = b"(face)\nG21 G90\nG1 X1 F100\nM2\n"
SIZES = b"""Serial;Characteristic;Feature;Nominal;Lower limit;Upper limit;Actual;Unit
a;Diameter 1;main-cylinder;89.408;89.390;89.430;89.4102;mm
"""


def choose(window: Window, name: str, content: bytes) -> None:
    window.page.get_by_label("Drop files here").set_input_files(
        {"name": name, "mimeType": "application/octet-stream", "buffer": content}
    )


def usable(window: Window) -> None:
    for size in (WIDE, NARROW):
        window.resize(size)
        assert window.page.evaluate(SMALL) == []
        assert window.page.evaluate(WIDER) <= 0
    assert findings(window) == []


def test_a_program_is_looked_at_kept_and_released(own: Browsing, shop: Shop) -> None:
    with own.window("engineer") as window:
        page, hashed = window.page, sha256(FACE).hexdigest()
        window.go("/files")
        choose(window, "new face.ngc", FACE)
        read = page.get_by_role("region", name="new face.ngc")
        expect(read).to_contain_text("LinuxCNC mm")
        usable(window)
        assert find(shop.store, Program, identity=hashed) == []
        read.get_by_role("button", name="Keep").click()
        expect(read.get_by_role("status")).to_contain_text("Kept")
        assert [one.value.name for one in find(shop.store, Program, identity=hashed)] == ["new face.ngc"]
        read.get_by_role("link", name="Programs").click()
        row = page.get_by_role("row").filter(has_text="new face.ngc")
        row.get_by_label("Reason").fill("ran in")
        row.get_by_role("button", name="release").click()
        expect(row).to_contain_text("released")
        assert window.complaints == []


def test_a_measurement_is_shown_read_in_another_way_and_refused_with_its_code(own: Browsing, shop: Shop) -> None:
    """The order's job names no part's form: what was measured fits nothing, and nothing is kept."""
    before = len(find(shop.store, Inspection))
    with own.window("operator") as window:
        page = window.page
        window.go("/files")
        choose(window, "sizes.csv", SIZES)
        read = page.get_by_role("region", name="sizes.csv")
        expect(read.get_by_role("table")).to_contain_text("89.4102")
        usable(window)
        mapping = read.get_by_label("What the columns mean")
        good = mapping.input_value()
        mapping.fill("[columns")
        expect(read).to_contain_text("read it again first")
        read.get_by_role("button", name="Read again").click()
        expect(read.locator(".remarks code")).to_have_text("MSR-MAPPING")
        mapping.fill(good)
        read.get_by_role("button", name="Read again").click()
        expect(read.get_by_role("table")).to_contain_text("89.4102")
        expect(read).to_contain_text("choose order and part first")
        read.get_by_label("Order").select_option("O1")
        read.get_by_label("Part", exact=True).select_option("a")
        read.get_by_role("button", name="Keep").click()
        refused = read.get_by_role("alert")
        expect(refused.locator("code")).to_have_text("JOB-KEY")
        assert len(find(shop.store, Inspection)) == before


def test_a_file_that_is_dropped_is_read_and_a_viewer_hands_none_over(own: Browsing) -> None:
    with own.window("operator") as window:
        window.go("/files")
        window.page.locator(".drop").evaluate(
            """zone => { const dataTransfer = new DataTransfer();
               dataTransfer.items.add(new File(['G21\\nG1 X1 F1\\nM2\\n'], 'dropped.ngc'));
               zone.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true })); }"""
        )
        expect(window.page.get_by_role("region", name="dropped.ngc")).to_contain_text("3 blocks")
    with own.window("viewer") as window:
        window.go("/files")
        expect(window.page.get_by_label("Drop files here")).to_be_disabled()
        expect(window.page.locator("main")).to_contain_text("needs the role operator; you are viewer")
