"""The service as a process, and people who use it: over HTTP, as their pages do."""

import itertools
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import httpx2

from scripts.factory_demo.parts import PROBE, PartKind

PASSWORD: Final = "four words, none alike"
STAFF: Final = {"otto": "operator", "ana": "engineer", "ada": "admin"}
MACHINE: Final = "lathe 1"
COMMAND: Final = (sys.executable, "-c", "from trueloop.cli.main import main; main()")
ROUTE: Final = ("semifinish", "probe", "correct", "finish", "remove", "measure", "release")
RELEASE: Final = ROUTE.index("release")
REMOVE: Final = ROUTE.index("remove")
WAIT_S: Final = 30.0
_NUMBERS: Final = itertools.count()


def trueloop(*words: str, said: str = "") -> str:
    """A command; what it prints."""
    done = subprocess.run([*COMMAND, *words], input=said, capture_output=True, text=True, check=False, timeout=WAIT_S)
    assert done.returncode == 0, f"trueloop {' '.join(words)}: {done.stderr}"
    return done.stdout.strip()


def founded(folder: Path) -> str:
    """A store with accounts, a tool in its holder, and the lathe's key."""
    db = ("--db", str(folder / "trueloop.db"))
    trueloop("db", "init", db[1])
    for name, role in STAFF.items():
        trueloop("user", "add", name, "--role", role, "--password-stdin", *db, said=PASSWORD)
    insert = ("--holder", "SVJBR 2020", "--insert", "VBMT 160408", "--corner", "1", "--nose-radius-mm", "0.8")
    trueloop("tool", "mount", "T1", *insert, *db)
    return trueloop("key", "add", "cell 1", "--machine", MACHINE, *db).split()[-1]


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The service; its address."""
    command = [*COMMAND, "serve", "--port", "0", "--db", str(folder / "trueloop.db")]
    with (folder / "service.log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
    try:
        assert process.stdout is not None
        said = process.stdout.readline().split()
        assert said, f"the service does not start, see {folder / 'service.log'}"
        yield said[-1].rstrip("/")
    finally:
        process.terminate()
        process.wait(WAIT_S)


class Person:
    """Somebody of the staff, signed in."""

    def __init__(self, address: str, name: str) -> None:
        self._http = httpx2.Client(base_url=f"{address}/api/v1", headers={"Origin": address}, timeout=WAIT_S)
        self.post("/session", {"name": name, "password": PASSWORD})

    def get(self, path: str) -> Any:
        """What stands there."""
        return self._answer(self._http.get(path))

    def post(self, path: str, body: object, **given: Any) -> Any:
        """A change."""
        headers = {"Idempotency-Key": f"demo-{next(_NUMBERS)}"} | given.pop("headers", {})
        return self._answer(self._http.post(path, json=body, headers=headers, **given))

    def hand_over(self, name: str, content: bytes) -> str:
        """A file; its hash."""
        headers = {"Idempotency-Key": f"demo-{next(_NUMBERS)}"}
        answer = self._http.post("/uploads", params={"name": name}, content=content, headers=headers)
        return str(self._answer(answer)["sha256"])

    def record(self, order: str, part: int, step: int, why: str) -> None:
        """A step done by hand, in the order as it stands."""
        etag = self._http.get(f"/orders/{order}").headers["etag"]
        self.post(f"/orders/{order}/parts/{part}/record", {"step": step, "why": why}, headers={"If-Match": etag})

    def page(self, path: str) -> str:
        """A page as text."""
        return self._http.get(path).text

    def _answer(self, answer: httpx2.Response) -> Any:
        assert answer.status_code < 300, f"{answer.url.path}: {answer.text}"
        return answer.json()


def programs(ana: Person, kind: PartKind) -> dict[str, str]:
    """Its programs, handed over, kept and released: their hashes by the kind of the step."""
    found = {}
    for step, text in kind.programs.items():
        name = f"{kind.name}-{step}-{len(kind.plan.touches)}" if step == "probe" else f"{kind.name}-{step}"
        sha = ana.hand_over(f"{name.lower()}.ngc", text)
        ana.post(f"/uploads/{sha}/program", {"dialect": "linuxcnc"})
        ana.post(f"/programs/{sha}/release", {"why": "ran in"})
        found[step] = sha
    return found


def ordered(ana: Person, kind: PartKind, serials: list[str]) -> str:
    """An order for parts; its number."""
    sha = programs(ana, kind)
    blocks = [
        {"kind": one, "program_sha256": sha.get(one, ""), "feature": "", "corrected": one == "finish"} for one in ROUTE
    ]
    plan = {"part_type": kind.name, "revision": "", "machine": MACHINE, "serials": serials, "blocks": blocks}
    return str(ana.post("/orders", plan | {"job_toml": kind.job, "probe_toml": PROBE})["row"]["id"])
