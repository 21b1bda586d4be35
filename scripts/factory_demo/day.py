"""What happens in the shop while LinuxCNC makes parts: each step looks at all orders and does what is to be done."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from scripts.factory_demo.browser import decide, window
from scripts.factory_demo.cell import Cell
from scripts.factory_demo.cmm import measure
from scripts.factory_demo.lathe import VirtualLathe
from scripts.factory_demo.office import RELEASE, REMOVE, Person, ordered, trueloop
from scripts.factory_demo.parts import PartKind
from scripts.factory_demo.truth import blank

LOOK_S: Final = 0.2
PROBE_STEP: Final = 1
CMM_U_UM: Final = 0.6


@dataclass(frozen=True)
class Plan:
    """Batches of parts in their order; by the number of the part, from 1: which one is probed with a chip on it, whose
    probing is stopped, and before which one the insert is turned.
    """

    batches: tuple[tuple[PartKind, int], ...]
    chip: int
    stopped: int
    turned: int

    @property
    def kinds(self) -> list[PartKind]:
        """Of each part."""
        return [kind for kind, count in self.batches for _ in range(count)]


@dataclass
class Day:
    """The shop at work. `made`: a row a part, with its true errors; `tell`: what happens, for people."""

    folder: Path
    plan: Plan
    address: str
    lathe: VirtualLathe
    cell: Cell
    tell: Callable[[str], None]
    made: list[dict[str, Any]] = field(default_factory=list)
    orders: list[str] = field(default_factory=list)
    stopped: bool = False
    wiped: bool = False
    states: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.otto, self.ana = Person(self.address, "otto"), Person(self.address, "ana")
        for name in ("cmm", "taken-in", "certificates", "screenshots"):
            (self.folder / name).mkdir(exist_ok=True)

    def begin(self) -> None:
        """The probe is calibrated, orders are planned, the first is armed at the machine."""
        self.otto.post("/machines/lathe 1/calibrated", {"values": {"effective_radius_mm": "1.4946"}})
        number = 0
        for kind, count in self.plan.batches:
            serials = [f"P{number + k + 1}" for k in range(count)]
            self.orders.append(ordered(self.ana, kind, serials))
            self.tell(f"order {self.orders[-1]}: {count} {kind.name}, {serials[0]} to {serials[-1]}")
            number += count
        for order, (_, count) in zip(self.orders, self.plan.batches, strict=True):
            self.cell.arm(order, count)

    def until_done(self, longest_s: float) -> None:
        """Raises TimeoutError where the parts are not released by then."""
        until = time.monotonic() + longest_s
        while not self.step():
            if time.monotonic() > until:
                raise TimeoutError(f"not done within {longest_s:g} s: {self.states}; logs are in {self.folder}")
            time.sleep(LOOK_S)

    def step(self) -> bool:
        """Whether all is done."""
        self.lathe.chip = len(self.made) + 1 == self.plan.chip and not self.wiped
        self.lathe.step()
        for order in self.orders:
            now = self.otto.get(f"/orders/{order}")
            for part in now["parts"]:
                self._see(order, part)
        return all(state == "released" for state in self.states.values()) and bool(self.states)

    def _see(self, order: str, part: dict[str, Any]) -> None:
        state = part["state"]
        if self.states.get(part["serial"]) != state:
            self.states[part["serial"]] = state
            self.tell(f"{part['serial']}: {state} {part['held_why']}".rstrip())
        if state == "held":
            self._decide(order, part)
        elif state == "finished" and self.lathe.clean and self.lathe.metal.cuts_of_blank == 2:
            self._take_out(order, part)
        elif state == "removed":
            self._take_in(order, part)
        elif state == "measured":
            self._release(order, part)
        elif part["steps"][PROBE_STEP] == "started":
            self._stop_once()

    def _stop_once(self) -> None:
        """Somebody stops the probing of one part, before it is through."""
        if not self.stopped and len(self.made) + 1 == self.plan.stopped and self.lathe.probing:
            self.lathe.stop()
            self.stopped = True
            self.tell("Stop is pressed while the part is probed")

    def _decide(self, order: str, part: dict[str, Any]) -> None:
        """The operator looks, decides on the part's page, and arms the rest again."""
        picture = self.folder / "screenshots" / f"decision-{part['serial']}.png"
        button, why = "It was not cut", "stopped by mistake while it was probed"
        if part["steps"][PROBE_STEP] == "recorded":
            button, why = "Probe it again", "a chip lay on it, wiped off"
            assert not self.wiped, part["held_why"]
            self.wiped, self.lathe.chip = True, False
            self.lathe.wiped()
        with window(self.address, "otto") as page:
            decide(page, f"{self.address}/parts/{part['id']}", button, why, picture)
        self.tell(f"otto decides on {part['serial']} in the browser: {why}; {button.lower()}")
        now = self.otto.get(f"/orders/{order}")
        self.cell.arm(order, sum(one["state"] not in ("released", "measured", "removed") for one in now["parts"]))

    def _take_out(self, order: str, part: dict[str, Any]) -> None:
        """The part goes to the measuring machine, the next blank into the chuck; its insert is turned at times."""
        number = len(self.made) + 2
        kinds = self.plan.kinds
        kind = kinds[min(number, len(kinds)) - 1]
        corner = "2" if number == self.plan.turned else None
        made = self.lathe.exchange(blank(kind, self.lathe.metal, corner))
        if corner:
            trueloop("tool", "turn", "T1", "--corner", corner, "--db", str(self.folder / "trueloop.db"))
            self.tell("the insert is turned to its second corner")
        row = {"serial": part["serial"], "type": made.kind.name, "id": part["id"], "corner": made.corner}
        row["spindle_c"] = round(made.spindle_c, 2)
        self.made.append(row | measure(made, part["serial"], self.folder / "cmm", number))
        self.otto.record(order, part["id"], REMOVE, "by the gantry")

    def _take_in(self, order: str, part: dict[str, Any]) -> None:
        """The file that the measuring machine left."""
        file = self.folder / "cmm" / f"{part['serial']}.qif"
        if not file.exists():
            return
        sha = self.otto.hand_over(file.name, file.read_bytes())
        of = {"order": order, "part": part["id"], "after": "finish"}
        for one in self.otto.post(f"/uploads/{sha}/measurement", of)["remarks"]:
            self.tell(f"{part['serial']}: {one['said']}")
        file.rename(self.folder / "taken-in" / file.name)

    def _release(self, order: str, part: dict[str, Any]) -> None:
        made = self.ana.post("/certificates", {"part": part["id"], "u_um": CMM_U_UM})
        page = self.ana.page(f"/certificates/{made['id']}")
        (self.folder / "certificates" / f"{part['serial']}.html").write_text(page, encoding="utf-8")
        self.ana.record(order, part["id"], RELEASE, f"certificate {made['id']}: {made['verdict']}")
