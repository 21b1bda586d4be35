"""What a hint names exists: the command with its options, the target of make, the page, the key of a file."""

import ast
import re
import shlex
from collections.abc import Iterator
from typing import Any

import pytest
import typer

from scripts.file_keys_page import tables
from scripts.manual.contents import ROOT, pages
from tests.docs.test_pages import unknown_in
from tests.errors.expected import kept
from tests.support.toml_files import KINDS
from trueloop.cli.main import app


def written() -> Iterator[tuple[str, str]]:
    """Every hint of the source by its file and line; what is put in at run time is an X."""
    for file in sorted((ROOT / "src").glob("trueloop*/**/*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "hint" and (text := text_of(node.value)):
                yield f"{file.relative_to(ROOT / 'src')}:{node.value.lineno}", text


def text_of(node: ast.expr) -> str:
    """A literal, or all branches of a choice between some."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.JoinedStr(values=parts):
            return "".join(text_of(part) or "X" for part in parts)
        case ast.BinOp(left=left, right=right):
            return text_of(left) + text_of(right)
        case ast.IfExp(body=body, orelse=other):
            return f"{text_of(body)}; {text_of(other)}"
    return ""


HINTS = {name: text.partition("  hint: ")[2] for name, text in kept().items()} | dict(written())
COMMAND = re.compile(r"`trueloop ([^`]+)`")
TARGET = re.compile(r"(?:`|in a clone: )make ([a-z-]+)")
PAGE = re.compile(r"\b([a-z-]+\.md)\b")
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
OF_OTHERS = {"--no-install-recommends"}
"""Options of other people's commands."""
KEY = re.compile(r"(?<![\w./-])(?!feature\.)([a-z]+)\.(?!html\b|toml\b|json\b|csv\b)([a-z_]{3,})\b(?![./(])")
"""TABLE.key; the tables below `feature` have the names of the part's own features."""


BARE = re.compile(r"`([a-z_]{3,})(?: = [^`]*)?`")
WHERE = re.compile(r"\[\[?[a-z]|\bcolumns?\b|the link's table|at the top of")
"""Where a key stands that is named without its table: the table in brackets, a column of a table, or none."""


def hints(pattern: re.Pattern[str]) -> list[object]:
    """The hints that have it, each with all it names."""
    return [pytest.param(pattern.findall(text), id=name) for name, text in HINTS.items() if pattern.search(text)]


def keys() -> set[str]:
    """TABLE.key of every file, by the innermost name of its table."""
    return {
        f"{re.sub(r'[^a-z_.]', '', heading).strip('.').rpartition('.')[2]}.{key}"
        for file in KINDS.values()
        for heading, model in tables(file, "")
        for key in model.model_fields
    }


@pytest.mark.parametrize("named", hints(COMMAND))
def test_a_command_that_a_hint_names_exists_with_its_options(named: list[str]) -> None:
    for words in named:
        assert unknown_in(shlex.split(words.replace("…", "X"))) == []


def options(command: Any) -> set[str]:
    """Those of a command and of all below it."""
    own = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    below = getattr(command, "commands", None) or {}
    return own.union(*(options(below[name]) for name in below))


@pytest.fixture(scope="module")
def all_options() -> set[str]:
    return options(typer.main.get_command(app))


@pytest.mark.parametrize("named", hints(OPTION))
def test_an_option_is_one_of_a_command(named: list[str], all_options: set[str]) -> None:
    assert set(named) - all_options <= OF_OTHERS


@pytest.mark.parametrize("named", hints(TARGET))
def test_a_target_of_make_exists(named: list[str]) -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert [one for one in named if not re.search(rf"^{re.escape(one)}:", makefile, re.M)] == []


@pytest.mark.parametrize("named", hints(PAGE))
def test_a_page_is_one_of_the_manual(named: list[str]) -> None:
    assert set(named) <= {page.source.name for page in pages()}


@pytest.mark.parametrize("named", hints(KEY))
def test_a_key_is_one_of_a_file(named: list[tuple[str, str]]) -> None:
    known = keys()
    tables_known = {one.partition(".")[0] for one in known}
    wrong = [f"{table}.{key}" for table, key in named if table in tables_known and f"{table}.{key}" not in known]
    assert wrong == []


@pytest.mark.parametrize("text", [pytest.param(text, id=name) for name, text in HINTS.items() if BARE.search(text)])
def test_a_key_is_named_with_its_table(text: str) -> None:
    in_tables = {one.partition(".")[2] for one in keys() if not one.startswith(".")}
    assert WHERE.search(text) or set(BARE.findall(text)) & in_tables == set()


def test_many_hints_name_something() -> None:
    assert min(len(hints(one)) for one in (COMMAND, OPTION, KEY)) >= 40
