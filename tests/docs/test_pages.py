"""Every snippet of the manual runs, or is at least what it says it is; scripts/manual/snippets.py has the rules."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer

from scripts.manual.contents import ROOT, pages
from scripts.manual.snippets import Command, Snippet, snippets
from tests.docs.outcomes import OUTCOMES
from tests.support.dialogue import OF_A_NAME, run_page, same
from tests.support.toml_files import KINDS, wrong_in
from trueloop.cli.main import app
from trueloop.errors import Code

LANGUAGES = {"console", "sh", "python", "pycon", "toml", "csv", "text", "hal", "ini", "nc", "nginx"}
RUN = {"console", "python", "pycon"}
PAGES = {page.source: list(snippets(page.text)) for page in pages()}
TRANSLATED = {"erstes-teil.md": "first-part.md", "werkstatt.md": "shop-tutorial.md"}
"""The German pages, each by the English page whose commands it has."""
RUN_ELSEWHERE = {"python-reference.md", *TRANSLATED}
"""The examples of the first are those of docstrings, which tests/unit/test_api.py runs."""
OTHERS = {"apt-get", "cargo", "cd", "cp", "createdb", "curl", "docker", "git", "pip", "/usr/bin/python3"}
"""Commands of others, which a page may name without running them."""


def of(*languages: str) -> list[object]:
    """The snippets in these languages, each with where it stands."""
    found = [(page, one) for page, all_of_it in PAGES.items() for one in all_of_it if one.language in languages]
    return [pytest.param(one, id=f"{page.name}:{one.line}") for page, one in found]


def with_snippets(*languages: str) -> list[object]:
    """The pages that have such snippets."""
    found = [page for page, all_of_it in PAGES.items() if any(one.language in languages for one in all_of_it)]
    found = [page for page in found if page.name not in RUN_ELSEWHERE]
    return [pytest.param(page, id=page.name) for page in found]


@pytest.mark.parametrize("page", with_snippets(*RUN))
def test_what_a_page_shows_is_what_happens(page: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """In a folder of its own that is empty: whatever it needs, the page brings."""
    monkeypatch.chdir(tmp_path)
    for name, value in {"COLUMNS": "120", "TZ": "UTC", "USER": "ana", "LOGNAME": "ana"}.items():
        monkeypatch.setenv(name, value)
    for snippet in PAGES[page]:
        for command in snippet.commands() if snippet.language == "console" else ():
            if kept := OF_A_NAME.fullmatch(command.words):
                monkeypatch.setenv(kept["name"], "")  # what the page sets is gone with the test
    known = run_page(page)
    if page.name in OUTCOMES:
        OUTCOMES[page.name](known)


@pytest.mark.parametrize(("german", "english"), TRANSLATED.items())
def test_a_translated_page_has_the_commands_codes_and_pictures_of_the_english(german: str, english: str) -> None:
    assert {page.name for page in PAGES if page.parent.name == "de"} == set(TRANSLATED)
    texts = [next(one.text for one in pages() if one.source.name == name) for name in (german, english)]
    of_german, of_english = ([(one.language, one.words, one.text) for one in snippets(text)] for text in texts)
    assert of_german == of_english
    for what in (r"`([A-Z]{2,3}-[A-Z-]+)`", r"images/[\w-]+\.png", r"^#+ (?:\d\.)?", r"^\|"):
        of_german, of_english = (re.findall(what, text, re.MULTILINE) for text in texts)
        assert of_german == of_english, what


def test_most_commands_of_the_manual_run() -> None:
    all_of_them = [one for of_a_page in PAGES.values() for one in of_a_page]
    run = sum(len(one.commands()) for one in all_of_them if one.language == "console")
    named = sum(one.text.count("trueloop ") for one in all_of_them if one.language == "sh")
    assert run >= 80 and run > named


@pytest.mark.parametrize("snippet", of("sh"))
def test_a_command_that_is_not_run_has_the_options_it_shows(snippet: Snippet) -> None:
    for line in snippet.text.splitlines():
        words = shlex.split(line, comments=True)
        if words and words[0] == "trueloop":
            assert unknown_in(words[1:]) == [], line
        elif words and words[0] == "make":
            assert re.search(rf"^{re.escape(words[1])}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M), line
        else:
            assert not words or words[0] in OTHERS, line


def unknown_in(words: list[str]) -> list[str]:
    """What of a command line no command of trueloop knows."""
    command: Any = typer.main.get_command(app)
    while words and hasattr(command, "commands"):
        name, *words = words
        if name not in command.commands:
            return [name]
        command = command.commands[name]
    options = {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
    return [word for word in words if re.match(r"--?[a-z]", word) and word.partition("=")[0] not in options]


def test_every_command_that_a_sentence_names_is_one() -> None:
    named = {
        (page.source.name, words)
        for page in pages()
        for words in re.findall(r"`trueloop ([a-z][^`\n]*)`", page.text)
        if page.source.name != "CHANGELOG.md"
    }
    assert len(named) > 200
    texts = {"…", "offset"}  # a command left open; the comment of a tool table
    assert [one for one in sorted(named) if set(unknown_in(one[1].split())) - texts] == []


@pytest.mark.parametrize("snippet", of("toml"))
def test_keys_of_a_file_are_keys_of_that_file(snippet: Snippet) -> None:
    kinds = [word for word in snippet.words if word in KINDS]
    assert len(kinds) == 1, f"of which file? ```toml and one of {', '.join(KINDS)}"
    assert wrong_in(snippet.text, kinds[0]) == []


def test_every_code_that_a_page_names_is_one() -> None:
    areas = {code.split("-")[0] for code in Code}
    named = {
        (page.source.name, found)
        for page in pages()
        for found in re.findall(r"`([A-Z]{2,3}-[A-Z-]+)`", page.text)
        if found.split("-")[0] in areas
    }
    assert len(named) > 400 and [(page, code) for page, code in named if code not in set(Code)] == []


def test_every_snippet_says_what_it_is() -> None:
    unknown = [
        f"{page.name}:{one.line}: {one.language!r}"
        for page, all_of_it in PAGES.items()
        for one in all_of_it
        if one.language not in LANGUAGES
    ]
    assert unknown == []


def test_code_that_is_only_indented_does_not_say_what_it_is() -> None:
    (found,) = snippets("# Page\n\n    trueloop demo\n")
    assert found.language not in LANGUAGES and found.line == 3


def test_a_dialogue_is_compared_to_the_last_character() -> None:
    def printed(*lines: str) -> Command:
        return Command("x", lines)

    assert same(printed("a 1", "b"), "a 1  \nb\n")
    assert same(printed("a …", "…", "d"), "a 1\nb\nc\nd\n") and same(printed("a", "…"), "a\n")
    assert not same(printed("a 1"), "a 12\n") and not same(printed("a"), "a\nb\n") and not same(printed(), "a\n")


def test_options_that_there_are_not_are_found() -> None:
    assert unknown_in(["db", "check", "--db", "x"]) == []
    assert unknown_in(["db", "chek"]) == ["chek"]
    assert unknown_in(["compensate", "job.toml", "--no-such", "-1"]) == ["--no-such"]


def test_keys_that_there_are_not_are_found() -> None:
    assert wrong_in('[part]\nname = "x"\n', "job") == []
    assert len(wrong_in('[part]\nnam = "x"\n[gauging]\nreadings_u_um = "4"\n', "job")) == 2
