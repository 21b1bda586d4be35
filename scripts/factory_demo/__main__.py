"""`python -m scripts.factory_demo [FOLDER [PARTS]]`: ten parts of two types, or fewer; `make demo-factory`.

Leaves in FOLDER (out/factory) the store, `certificates/`, `screenshots/` of every page, the measuring machine's files
and `summary.json`, and prints what came of each part.
"""

import json
import shutil
import sys
import time
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from scripts.factory_demo.browser import pictures, window
from scripts.factory_demo.cell import cell
from scripts.factory_demo.day import Day, Plan
from scripts.factory_demo.lathe import virtual_lathe
from scripts.factory_demo.office import founded, served, trueloop
from scripts.factory_demo.parts import DOMES, DOMES_BY_FEW, KNOBS
from scripts.factory_demo.truth import blank

FOLDER: Final = Path(__file__).parents[2] / "out" / "factory"
TEN: Final = Plan(((DOMES, 4), (KNOBS, 3), (DOMES_BY_FEW, 3)), chip=3, stopped=2, turned=6)
THREE: Final = Plan(((DOMES, 1), (KNOBS, 2)), chip=2, stopped=1, turned=3)
LONGEST_S: Final = 900.0


def main(folder: Path = FOLDER, parts: int = 10) -> int:
    """Makes the parts; 0 when all are released."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    begun, plan = time.monotonic(), TEN if parts == 10 else THREE
    key = founded(folder)
    with (
        served(folder) as address,
        virtual_lathe(blank(plan.kinds[0])) as lathe,
        cell(folder, lathe.control, address, key) as armed,
    ):
        _tell(f"the service is at {address}; LinuxCNC is on")
        day = Day(folder, plan, address, lathe, armed, _tell)
        day.begin()
        day.until_done(LONGEST_S)
        trueloop("series", "propose", "--type", plan.kinds[0].name, "--db", str(folder / "trueloop.db"))
        _tell("every page is looked at")
        with window(address, "ada") as page:
            seen = pictures(page, address, folder / "screenshots")
        summary = {"parts": [_row(day, one) for one in day.made], "memory": _memories(day), "pages": seen}
    _keep(folder, summary | {"took_s": round(time.monotonic() - begun, 1)})
    return 0


def _row(day: Day, made: dict[str, Any]) -> dict[str, Any]:
    """What the store has of the part beside what is true of it."""
    life = day.ana.get(f"/parts/{made['id']}/life")
    correction = life["corrections"][-1]
    return made | {"correction": correction["id"], "said": correction["summary"], "state": life["part"]["state"]}


def _memories(day: Day) -> list[dict[str, Any]]:
    """What the store remembers of each corner: of how many parts, and how well it knows the error that it leaves."""
    found = []
    for tool in day.ana.get("/tools")["items"]:
        memory = day.ana.get(f"/tools/{tool['id']}/memory")
        band_um = max((width for curve in memory["curves"] for width in curve["band_um"]), default=None)
        found.append({"edge": tool["edge"], "parts": memory["parts"], "largest_band_um": band_um})
    return found


def _keep(folder: Path, summary: dict[str, Any]) -> None:
    (folder / "summary.json").write_text(json.dumps(summary, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print("part  type     corner  spindle °C  true error of the arc, µm: RMS  largest")
    for one in summary["parts"]:
        print(
            f"{one['serial']:<5} {one['type']:<8} {one['corner']:<7} {one['spindle_c']:<11.1f} "
            f"{one['true_rms_um']:>29.2f} {one['true_largest_um']:>8.2f}"
        )
    print(f"{len(summary['parts'])} parts, {len(summary['pages'])} pages in {summary['took_s']:.0f} s: {folder}")


def _tell(words: str) -> None:
    print(f"{datetime.now():%H:%M:%S} {words}", flush=True)


if __name__ == "__main__":
    try:
        sys.exit(main(Path(sys.argv[1]) if sys.argv[1:] else FOLDER, int(sys.argv[2]) if sys.argv[2:] else 10))
    except (AssertionError, TimeoutError) as reason:
        sys.exit(f"the demo failed: {reason}")
