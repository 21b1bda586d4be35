"""Makes docs/file-keys.md, every key of every TOML file, from the code."""

from collections.abc import Iterator
from typing import Final, get_args, get_origin

from pydantic import BaseModel

from scripts.key_tables import HEAD, row
from tests.support.toml_files import KINDS

ELSEWHERE: Final = {
    "job": ("Job of a turned part", "job-file.md"),
    "probe": ("Probe", "probing.md#the-probe-file"),
    "surface": ("Job of a surface", "surface.md#the-job"),
    "milled": ("Job of a milled part", "milled.md#the-job"),
    "cell": ("Cell", "cell.md"),
}
"""Files whose keys have a page that explains them at length."""
TITLES: Final = {
    "machine": "Machine, for a model of its errors ([machine.md](machine.md#the-machine-file))",
    "readings": "Readings by instruments' own files ([machine.md](machine.md#instruments-own-files))",
    "offsets": "Work offsets and tools ([cli.md](cli.md#offsets-file))",
    "mapping": "Mapping of a table ([measurements.md](measurements.md#tables-by-mapping))",
    "meaning": (
        "Mapping of a control's output "
        "([inspection-formats.md](inspection-formats.md#dumps-and-print-outs-of-controls))"
    ),
    "signals": "Signals of the real-time corrector ([realtime-signals.md](realtime-signals.md#configuration))",
    "links": "Links to controls ([links.md](links.md))",
    "virtual-machine": "Virtual lathe ([simulator.md](simulator.md#the-machine-file))",
    "virtual-mill": "Virtual mill ([simulator.md](simulator.md#the-virtual-mill))",
}
START: Final = """# Every key of every file

The TOML files that trueloop reads, with every table and key: unit, default, meaning. A key that is not listed is
refused with the one that is nearest. Units stand in the names.

"""


def page() -> str:
    """Returns the page: links to the files that have a page of their own, then a section a file."""
    parts = [START]
    parts += [f"- {title}: [{link.partition('#')[0]}]({link})\n" for title, link in ELSEWHERE.values()]
    for kind, title in TITLES.items():
        parts.append(f"\n## {kind.capitalize()} file\n\n{title}.\n")
        for heading, model in tables(KINDS[kind], ""):
            keys = [key for key, one in model.model_fields.items() if not inner(one.annotation)]
            parts.append(f"\n### `{heading}` ({kind})\n\n" if heading else "\n")
            parts.append(HEAD + "".join(row(model, key) for key in keys))
    return "".join(parts)


def tables(model: type[BaseModel], path: str) -> Iterator[tuple[str, type[BaseModel]]]:
    """The tables of a file, each with its heading as it is written there; one without keys of its own is left out."""
    if any(not inner(one.annotation) for one in model.model_fields.values()):
        yield (path if path.startswith("[") else f"[{path}]") if path else "", model
    for key, one in model.model_fields.items():
        for kind, below in inner(one.annotation):
            name = f"{path.strip('[]')}.{key}" if path else key
            yield from tables(below, {"dict": f"{name}.NAME", "tuple": f"[[{name}]]"}.get(kind, name))


def inner(annotation: object, kind: str = "") -> list[tuple[str, type[BaseModel]]]:
    """The tables in a key's type, and whether it holds one, several in order, or several by name."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [(kind, annotation)]
    origin = get_origin(annotation)
    kinds: dict[object, str] = {dict: "dict", tuple: "tuple"}
    kind = kinds.get(origin, kind) if isinstance(origin, type) else kind
    return [found for one in get_args(annotation) for found in inner(one, kind)]
