"""Options that are taken together: typer sees each of them, the command one value."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from typer.testing import CliRunner

from trueloop.cli.terminal import ExitStatus, guarded


@dataclass(frozen=True, kw_only=True)
class Inner:
    deep: Annotated[int, typer.Option("--deep")] = 3


@dataclass(frozen=True, kw_only=True)
class Outer:
    file: Annotated[Path, typer.Argument(metavar="FILE")]
    needed: Annotated[str, typer.Option("--needed")]
    inner: Inner
    many: Annotated[list[str] | None, typer.Option("--many")] = None


def app() -> typer.Typer:
    made = typer.Typer(rich_markup_mode=None)

    @made.command()
    @guarded
    def command(outer: Outer, last: Annotated[bool, typer.Option("--last")] = False) -> None:
        typer.echo(f"{outer} {last}")

    return made


def test_every_field_is_an_option_in_the_order_of_the_fields() -> None:
    shown = CliRunner().invoke(app(), ["--help"]).stdout
    places = [shown.index(name) for name in ("--needed", "--deep", "--many", "--last")]
    assert places == sorted(places) and "FILE" in shown


def test_the_command_gets_the_values_as_they_were_given() -> None:
    result = CliRunner().invoke(app(), ["a.nc", "--needed", "x", "--many", "1", "--many", "2", "--deep", "7"])
    assert (
        result.stdout.strip() == f"{Outer(file=Path('a.nc'), needed='x', inner=Inner(deep=7), many=['1', '2'])} False"
    )
    assert f"{Inner()}" in CliRunner().invoke(app(), ["a.nc", "--needed", "x", "--last"]).stdout


def test_a_field_without_default_is_required() -> None:
    result = CliRunner().invoke(app(), ["a.nc"])
    assert result.exit_code == ExitStatus.USAGE and "--needed" in result.stderr
