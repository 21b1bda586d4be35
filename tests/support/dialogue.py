"""The snippets of a page of the manual, run in order in one folder, as a reader would."""

import doctest
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

from scripts.manual.snippets import Command, Snippet, snippets
from tests.support.cli import invoke

OF_A_SHELL = re.compile(r"[|<>;&]|\$\(")
OF_A_NAME = re.compile(r"(?P<name>[A-Z]+)=\$\((?P<command>.+)\)")
ANYTHING = "…"


def run_page(page: Path, *, installed: bool = False) -> dict[str, Any]:
    """Runs all that a page shows in the present folder; what its Python has defined by then.

    `installed`: by the `trueloop` on the PATH, each command a process; else in this one, which is quicker.
    """
    known: dict[str, Any] = {}
    for snippet in snippets(page.read_text(encoding="utf-8")):
        where = f"{page.name}:{snippet.line}"
        if snippet.file and snippet.language != "console":
            Path(snippet.file).write_text(snippet.text, encoding="utf-8")
        if snippet.language == "console":
            _run_dialogue(snippet, where, installed)
        elif snippet.language == "python":
            exec(compile(snippet.text, where, "exec"), known)
        elif snippet.language == "pycon":
            _run_doctest(snippet, where, known)
    return known


def _run_dialogue(snippet: Snippet, where: str, installed: bool) -> None:
    commands = snippet.commands()
    assert commands, f"{where}: a dialogue without a command"
    for at, command in enumerate(commands):
        printed, status = output_of(command.words, installed=installed)
        wanted = snippet.status if at == len(commands) - 1 else 0
        assert status == wanted, f"{where}: {command.words}: status {status}\n{printed}"
        assert same(command, printed), (
            f"{where}: {command.words}\nis to print:\n{chr(10).join(command.printed)}\nprints:\n{printed}"
        )


def output_of(command: str, *, installed: bool = False) -> tuple[str, int]:
    """What a command prints, messages among it, and its exit status. `cd` stays in force, as in a shell."""
    if kept := OF_A_NAME.fullmatch(command):
        printed, status = output_of(kept["command"], installed=installed)
        os.environ[kept["name"]] = printed.strip()
        return "", status
    words = [os.path.expandvars(word) for word in shlex.split(command, comments=True)]
    if words[0] == "cd":
        os.chdir(words[1])
        return "", 0
    if words[0] == "trueloop" and not OF_A_SHELL.search(command) and not installed:
        result = invoke(*words[1:])
        return result.output, result.exit_code
    beside = "" if installed else f"{Path(sys.executable).parent}{os.pathsep}"
    run = subprocess.run(
        ["bash", "-c", command],
        env=os.environ | {"PATH": beside + os.environ["PATH"]},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=300,
        check=False,
    )
    return run.stdout, run.returncode


def same(command: Command, printed: str) -> bool:
    """Whether a command printed what the page says; blanks at the ends of lines do not count."""
    pattern = "".join(
        r"(?:.*\n)*?" if line.strip() == ANYTHING else re.escape(line.rstrip()).replace(ANYTHING, ".*?") + "\n"
        for line in command.printed
    )
    lines = "".join(f"{line.rstrip()}\n" for line in printed.splitlines())
    return re.fullmatch(pattern, lines) is not None


def _run_doctest(snippet: Snippet, where: str, known: dict[str, Any]) -> None:
    test = doctest.DocTestParser().get_doctest(snippet.text, known, where, where, 0)
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.ELLIPSIS)
    said: list[str] = []
    result = runner.run(test, out=said.append, clear_globs=False)
    known.update(test.globs)
    assert result.failed == 0, "".join(said)
