"""The page of the component holds every pin and parameter, with its meaning; and the numbers that pins show."""

import re

from scripts.component_page import PAGE, SOURCE, page
from trueloop import _core

COMP = SOURCE.read_text(encoding="utf-8")


def test_the_table_is_that_of_the_component() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert page(text, COMP) == text, "python -m scripts.component_page"


def test_every_pin_and_parameter_is_in_the_table() -> None:
    declared = re.findall(r"^(?:pin|param) .*", COMP.partition(";;")[0], re.MULTILINE)
    assert len(declared) >= 50
    assert PAGE.read_text(encoding="utf-8").count("\n| `") >= len(declared)


def test_numbers_that_pins_show_are_named_as_the_corrector_names_them() -> None:
    names = _core.realtime_names()
    pins = {"phases": "phase", "faults": "fault-code", "refusals": "reload-error", "waits": "waits-for"}
    for kind, pin in pins.items():
        meaning = re.search(rf'^pin out signed {pin} "(.*)";', COMP, re.MULTILINE)
        assert meaning
        for number, name, _ in names[kind]:
            assert re.search(rf"\b{number} [a-z ]*{re.escape(name.split()[-1])}", meaning[1]), (pin, number, name)
