"""Options of commands that keep what they find in a store, and what they say of it."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from trueloop.errors import Finding
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.jobs.store.keeping import Keeping
    from trueloop.jobs.store.where import Choice

Db = Annotated[
    str | None,
    typer.Option(
        "--db",
        metavar="FILE|URL",
        help="Store to keep it in.  [default: store.db of the job, else trueloop.db beside it]",
    ),
]
NoStore = Annotated[bool, typer.Option("--no-store", help="Work without a store, whatever the job states.")]
Supersede = Annotated[
    bool, typer.Option("--supersede", help="Replace a stored version that differs; the old one is kept as history.")
]
Accept = Annotated[
    list[str] | None,
    typer.Option("--accept", metavar="CODE", help="Store despite this refusal, e.g. --accept STO-CLOCK."),
]


def chosen(db: str | None, no_store: bool) -> "Choice":
    """Returns the store that two options name. Raises BadParameter where they contradict each other."""
    if db and no_store:
        raise typer.BadParameter("--db names a store, and --no-store works without one", param_hint="--no-store")
    if db == "none":
        raise typer.BadParameter(
            "write --no-store to work without a store, ./none for a file of that name", param_hint="--db"
        )
    return False if no_store else db


@dataclass(frozen=True, kw_only=True)
class StoreChoice:
    """Where a command keeps what it finds."""

    db: Db = None
    no_store: NoStore = False
    supersede: Supersede = False
    accept: Accept = None

    @property
    def choice(self) -> "Choice":
        """The store, as jobs take it."""
        return chosen(self.db, self.no_store)

    def keeping(self, serial: str | None) -> "Keeping":
        """As jobs take it."""
        from trueloop.jobs.store.keeping import Keeping

        return Keeping(self.choice, serial, self.supersede, tuple(self.accept or ()))


def print_findings(findings: "Iterable[Finding]") -> None:
    """What was noticed, on stderr."""
    for found in findings:
        typer.echo(str(found), err=True)


def kept_as_dict(kept: "KeptFacts | None") -> dict[str, object]:
    """What was kept, for machines: nothing where there is no store."""
    if kept is None:
        return {}
    new: dict[str, int] = {}
    for one in kept.new:
        name = type(one.value).__name__
        new[name] = new.get(name, 0) + 1
    findings = [{"code": one.code, "message": one.message, "severity": one.severity} for one in kept.findings]
    obtained = {"obtained": [one.as_dict for one in kept.obtained]} if kept.obtained else {}
    return {"store": {"where": kept.where, "new": new, "findings": findings}, **obtained}
