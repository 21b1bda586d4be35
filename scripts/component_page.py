"""Writes the pins and parameters of rtec.comp into docs/realtime-component.md: python -m scripts.component_page."""

import re
from pathlib import Path
from typing import Final

PAGE: Final = Path(__file__).parents[1] / "docs" / "realtime-component.md"
SOURCE: Final = Path(__file__).parents[1] / "src/trueloop/controllers/linuxcnc/realtime/rtec.comp"
DECLARED: Final = re.compile(r'^(pin|param) (\w+) (\w+) ([\w-]+)(?:#\[(\d+)\])?(?: = (\S+))? "(.*)";$', re.MULTILINE)
BEGIN: Final = "<!-- pins: python -m scripts.component_page -->\n"
END: Final = "<!-- end of pins -->"


def table(comp: str) -> str:
    """A row for every pin and parameter that is declared."""
    rows = []
    for kind, way, of, name, count, value, meaning in DECLARED.findall(comp):
        shown = f"{name}0…{int(count) - 1}" if count else name
        said = f"{kind} {way}" if kind == "pin" else f"parameter{f', {value}' if value else ''}"
        rows.append(f"| `{shown}` | {said} | {of} | {meaning} |")
    return "\n".join(["| name | | type | meaning |", "|---|---|---|---|", *rows]) + "\n"


def page(text: str, comp: str) -> str:
    """The page with its table made anew."""
    before, _, rest = text.partition(BEGIN)
    return before + BEGIN + table(comp) + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), SOURCE.read_text(encoding="utf-8")), encoding="utf-8")
