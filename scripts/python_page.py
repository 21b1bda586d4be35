"""Makes docs/python-reference.md, every stable name with its docstring."""

import inspect
import re
from itertools import takewhile
from pathlib import Path
from typing import Any, Final

import trueloop

STUB: Final = Path(trueloop.__file__).with_suffix(".pyi")
NAME: Final = re.compile(r"^from ([\w.]+) import (\w+) as \w+$")
HEAD: Final = """# Every stable name of the Python API

The names of `import trueloop`, in the order of use; [python.md](python.md) shows how they go together. Lengths are mm,
angles radians, x is a radius, a part error is positive where material is left on. Each example is run by a test, with
`np`, `Path` and `replace` imported; what is refused is raised as `TrueloopError`.
"""


def page() -> str:
    """Returns the page: a section a group of the stub, an entry a name."""
    parts = [HEAD]
    for line in STUB.read_text(encoding="utf-8").splitlines():
        if line.startswith("# ") and line.endswith((".", ",")) and line != "# In the order of use.":
            parts.append(f"\n## {line.removeprefix('# ').rstrip('.')}\n")
        elif found := NAME.match(line):
            parts.append(_entry(found[2], getattr(trueloop, found[2]), found[1]))
    return "".join(parts)


def _entry(name: str, value: Any, module: str) -> str:
    text, _, example = (inspect.getdoc(value) or "").partition("\n>>> ")
    shown = f"\n```pycon\n>>> import trueloop\n>>> {example.strip()}\n```\n" if example else ""
    prose = re.sub(r"(?<!`)``(?!`)", "`", text.strip())
    return f"\n### `{name}`\n\n```text\n{_signature(name, value)}\n```\n\n{_fenced(prose)}\n{shown}\nIn `{module}`.\n"


def _signature(name: str, value: Any) -> str:
    """As one writes the call: no types of the inside."""
    if inspect.isclass(value) and issubclass(value, Exception):
        return name
    names: list[str] = []
    stars: dict[object, str] = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    for one in inspect.signature(value).parameters.values():
        star = stars.get(one.kind, "")
        default = "" if one.default is one.empty else f"={_short(one.default)}"
        names += ["*"] if one.kind is one.KEYWORD_ONLY and "*" not in names and not _starred(names) else []
        names.append(f"{star}{one.name}{default}")
    return f"{name}({', '.join(names)})"


def _starred(names: list[str]) -> bool:
    return any(one.startswith("*") for one in names)


def _short(default: object) -> str:
    shown = repr(default)
    return shown if len(shown) < 24 else "…"


def _fenced(prose: str) -> str:
    """Indented lines of a docstring are formulas: a page says what code is."""
    lines, out = prose.splitlines(), []
    while lines:
        block = list(takewhile(lambda line: line.startswith("    "), lines))
        if block:
            out += ["```text", *(line[4:] for line in block), "```"]
            del lines[: len(block)]
        else:
            out.append(lines.pop(0))
    return "\n".join(out)
