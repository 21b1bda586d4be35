"""What axe finds on a page: WCAG 2.2 AA and good practice. It comes with the pages' own tools (`make web`)."""

from pathlib import Path
from typing import Any

from tests.support.served import Window

AXE = Path(__file__).parents[2] / "web" / "node_modules" / "axe-core" / "axe.min.js"


def findings(window: Window) -> list[str]:
    """A line for each rule that is broken, with the first elements that break it."""
    window.page.evaluate(AXE.read_text(encoding="utf-8"))
    found: dict[str, Any] = window.page.evaluate("async () => await axe.run()")
    return [f"{one['id']}: {[node['html'][:160] for node in one['nodes'][:3]]}" for one in found["violations"]]
