"""A command that a hint names is known to the command line, with its options, a key to the files that have it."""

import ast
import re
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path
from typing import Any

import click
import pytest
import typer.main

from scripts.key_tables import TABLES
from trueloop.cli.main import app

SOURCE = Path(__file__).parents[3] / "src"
NAMED = re.compile(r"(?<![\w.])trueloop((?: [\w{}.:<>/=*,…-]+)+)")
"""`trueloop`, and what looks like a command and its arguments."""
KEY = re.compile(r"(?<![\w./`])`?([a-z_]+(?:\.[a-z_][a-z0-9_]*)+)(?![\w./(])")
"""Table and key, as `part.serial`."""
FILES = re.compile(r"\.(?:md|toml|csv|jsonl?|ngc|nc|img|db|hal|example|var|tbl|py|html)$")
ELSEWHERE = {"term.choose", "terms.segments", "rtec.write"}
"""Keys of the machine's file, a pin of the corrector."""
PROSE = {"in", "corrected", "and", "finds", "from", "of", "is", "was", "wrote", "as", "that", "offset"}


def _text(node: ast.expr) -> str | None:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(part) or "" if isinstance(part, ast.Constant) else "{}" for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return "".join(_text(side) or "{}" for side in (node.left, node.right))
    return None


def _hints() -> Iterator[tuple[str, str]]:
    """Place and text of all that the source gives as `hint` or `override`, and of texts kept under such a name."""
    for file in sorted(SOURCE.glob("trueloop*/**/*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            values: list[ast.expr] = []
            if isinstance(node, ast.Call):
                values = [given.value for given in node.keywords if given.arg in ("hint", "override")]
            elif isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = " ".join(ast.unparse(target).lower() for target in targets)
                values = [node.value] if "hint" in names else []
            for value in values:
                for part in ast.walk(value):
                    text = _text(part) if isinstance(part, ast.expr) else None
                    if text:
                        yield f"{file.name}:{value.lineno}", text


HINTS = sorted(set(_hints()))


def _followed(words: list[str]) -> tuple[click.Command, list[str]]:
    """The command that the words name, and the rest of them."""
    command: Any = typer.main.get_command(app)
    while words and hasattr(command, "commands"):
        assert words[0] in command.commands, f"there is no command {words[0]!r}"
        command, words = command.commands[words[0]], words[1:]
    return command, words


COMMANDS = [(where, named.group(1).split()) for where, text in HINTS for named in NAMED.finditer(text)]


@pytest.mark.parametrize(("where", "words"), [case for case in COMMANDS if case[1][0] not in PROSE])
def test_a_command_that_a_hint_names_is_there_with_its_options(where: str, words: list[str]) -> None:
    command, rest = _followed([word.rstrip("…:,.") for word in words])
    options = {name for option in command.params for name in (*option.opts, *option.secondary_opts)}
    for word in takewhile(lambda word: word not in PROSE, rest):
        name = word.partition("=")[0]
        assert not name.startswith("--") or name in options, f"{where}: {command.name} has no {name}"


def _keys() -> set[str]:
    keys: set[str] = set()
    for tables in TABLES.values():
        for heading, model in tables.items():
            table = heading.strip("[]").split(" ")[0]
            keys |= {table} | {f"{table}.{key}".removeprefix(".") for key in model.model_fields}
    return keys


@pytest.mark.parametrize(
    ("where", "key"),
    [
        (where, found)
        for where, text in HINTS
        for found in KEY.findall(text)
        if not FILES.search(found) and found not in ELSEWHERE
    ],
)
def test_a_key_that_a_hint_names_is_there(where: str, key: str) -> None:
    assert any(known == key or known.endswith(f".{key}") for known in _keys()), f"{where}: no file has a key {key}"


def test_hints_are_looked_at() -> None:
    assert len(HINTS) > 500 and len(COMMANDS) > 60
