"""The snippets of a page: what its fences hold, by their languages.

| fence | what it is |
|---|---|
| `console` | A dialogue: lines after `$ ` are commands, the others what is printed; `…` stands for anything. |
| `sh` | Commands that need what a test has not: a machine, a network, a service. Their options are checked. |
| `python` | Statements, run in order. |
| `pycon` | Statements after `>>>` with what they print. |
| `toml` | A file's keys. The second word says of which file: `toml job`. |

A word with a dot in it is a file's name: the fence is that file, `csv shaft/readings.csv`. `exit=3` is the exit
status of the last command.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile

from scripts.manual.markdown import READER

PROMPT = "$ "


@dataclass(frozen=True)
class Command:
    """A command of a dialogue, and the lines that it prints."""

    words: str
    printed: tuple[str, ...]


@dataclass(frozen=True)
class Snippet:
    """A fence: its language, the words after it, its text, the line of the page where it begins."""

    language: str
    words: tuple[str, ...]
    text: str
    line: int

    @property
    def file(self) -> str | None:
        """The file that it is."""
        return next((word for word in self.words if "." in word), None)

    @property
    def status(self) -> int:
        """What the last command ends with."""
        return next((int(word[5:]) for word in self.words if word.startswith("exit=")), 0)

    def commands(self) -> list[Command]:
        """The commands of a dialogue."""
        lines, found = self.text.splitlines(), []
        for at, line in enumerate(lines):
            if line.startswith(PROMPT):
                printed = takewhile(lambda after: not after.startswith(PROMPT), lines[at + 1 :])
                found.append(Command(line.removeprefix(PROMPT), tuple(printed)))
        return found


def snippets(page: str) -> Iterator[Snippet]:
    """Every snippet of a page in order; code that is only indented is in no language."""
    for token in READER.parse(page):
        line = token.map[0] + 1 if token.map else 0
        if token.type in ("fence", "code_block"):
            language, *words = token.info.split() or [""]
            yield Snippet(language, tuple(words), token.content, line)
