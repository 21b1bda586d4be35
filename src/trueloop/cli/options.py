"""Options that belong together, as one value: a command takes a dataclass, typer sees an option for each of its fields.

    @dataclass(frozen=True, kw_only=True)
    class Reading:
        unit: Annotated[str | None, typer.Option("--unit")] = None

    @guarded
    def path(file: ProgramFile, reading: Reading) -> None: ...

A field may be such a dataclass itself. Help lists options in the order of parameters and fields.
"""

import functools
import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import MISSING, dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final, get_type_hints

import typer

from trueloop.cli.program_file import Reading
from trueloop.cli.shared_options import option, positive
from trueloop.domain.option import LIMITS, MAP_OPTIONS, MapOptions
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.errors import Finding
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.jobs.store.opened import Choice, Keeping


def with_groups(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command as a function of single options."""
    hints = get_type_hints(command, include_extras=True)
    groups = {name: hint for name, hint in hints.items() if is_dataclass(hint)}

    @functools.wraps(command)
    def run(*args: object, **given: object) -> object:
        values = {name: _value(group, given) for name, group in groups.items()}
        return command(*args, **given, **values)

    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        group = groups.get(parameter.name)
        single = _parameters(group) if group else [parameter.replace(annotation=hints[parameter.name])]
        parameters += [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in single]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run


def _parameters(group: Any) -> Iterator[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    for field in fields(group):
        if is_dataclass(hint := hints[field.name]):
            yield from _parameters(hint)
            continue
        default = inspect.Parameter.empty if field.default is MISSING else field.default
        yield inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def _value(group: Any, table: dict[str, object]) -> object:
    """The dataclass of its fields' values, which are taken out of those given."""
    hints = get_type_hints(group)
    return group(
        **{name: _value(hint, table) if is_dataclass(hint) else table.pop(name) for name, hint in hints.items()}
    )


LARGEST_UM: Final[float] = LIMITS["correction_mm"].default
STEEPEST: Final[float] = LIMITS["slope"].default
TOLERANCE_UM: Final[float] = MAP_OPTIONS["tolerance_mm"].default

LimitUm = Annotated[float, option(LIMITS["correction_mm"].option.meaning, "--limit-um", min=0.0)]
Slope = Annotated[float, option(f"{LIMITS['slope'].option.meaning[:-1]}, µm/mm.", "--slope", min=0.0)]
ToleranceUm = Annotated[
    float, option(MAP_OPTIONS["tolerance_mm"].option.meaning, "--tolerance-um", min=0.001, callback=positive)
]


def map_options(reading: Reading, decimals: int, tolerance_um: float, limit_um: float, slope: float) -> MapOptions:
    """The options of a command as a loop takes them; slope in µm/mm."""
    return MapOptions(
        tolerance_mm=tolerance_um / UM_PER_MM,
        limit_mm=limit_um / UM_PER_MM,
        slope=slope / UM_PER_MM,
        skipped_blocks=reading.skipped_blocks,
        unit=reading.unit,
        decimals=decimals,
    )


Db = Annotated[
    str | None,
    option(
        "Store to keep it in.  [default: store.db of the job, else trueloop.db beside it, which is made]",
        "--db",
        metavar="FILE|URL",
    ),
]
NoStore = Annotated[bool, option("Work without a store, whatever the job states.", "--no-store")]
Supersede = Annotated[
    bool, option("Replace a stored version that differs; the old one is kept as history.", "--supersede")
]
Accept = Annotated[
    list[str] | None, option("Store despite this refusal, e.g. --accept STO-CLOCK.", "--accept", metavar="CODE")
]

AcceptRefused = Annotated[
    list[str] | None,
    option(
        "Go on although it is refused with this code, as DIA-UNSTABLE or MCH-RUN; several times.",
        "--accept",
        metavar="CODE",
    ),
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
        from trueloop.jobs.store.opened import Keeping

        return Keeping(self.choice, serial, self.supersede, tuple(self.accept or ()))


def print_findings(findings: "Iterable[Finding]") -> None:
    """Prints findings on stderr."""
    for found in findings:
        typer.echo(str(found), err=True)


def kept_as_dict(kept: "KeptFacts | None") -> dict[str, object]:
    """Returns the facts that were stored, for JSON: nothing without a store."""
    if kept is None:
        return {}
    new: dict[str, int] = {}
    for stored in kept.new:
        name = type(stored.value).__name__
        new[name] = new.get(name, 0) + 1
    findings = [
        {"code": finding.code, "message": finding.message, "severity": finding.severity} for finding in kept.findings
    ]
    obtained = {"obtained": [one.as_dict for one in kept.obtained]} if kept.obtained else {}
    return {"store": {"where": kept.where, "new": new, "findings": findings}, **obtained}
