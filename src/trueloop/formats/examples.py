"""The jobs, programs and measurements that come with trueloop."""

from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place

EXAMPLES: Final = Path(__file__).parents[1] / "examples"


def example(name: str) -> Path:
    """Returns the path of an example: `name` is that of a file below `examples/`. Readers refuse one that is not there.

    >>> trueloop.example("modbas2/job.toml").name
    'job.toml'
    """
    return EXAMPLES / name


def titles() -> dict[str, str]:
    """Returns the folders of examples, each with the first line of its README."""
    texts = {one.name: (one / "README.md").read_text("utf-8") for one in sorted(EXAMPLES.iterdir()) if one.is_dir()}
    return {name: text.partition("\n")[0].removeprefix("# ") for name, text in texts.items()}


def copy_example(name: str, folder: Path) -> int:
    """Copies a folder of examples to a new place; how many files. Raises JOB-EXISTS, and OUT-FOLDER of the system."""
    from trueloop.formats.outputs import write_all

    if folder.exists():
        raise Code.JOB_EXISTS.refusal(
            f"{str(folder)!r} is there already",
            hint="name another folder with --output, or go on with what is there",
            place=Place(str(folder)),
            values={"file": str(folder)},
        )
    source = example(name)
    files = sorted(file for file in source.rglob("*") if file.is_file())
    for place in sorted({file.parent for file in files}):
        here = [(file.name, file.read_bytes()) for file in files if file.parent == place]
        write_all(folder / place.relative_to(source), here)
    return len(files)
