"""The optional packages of trueloop, by the extras that its metadata lists."""

import re
from importlib.metadata import requires

EXTRA = re.compile(r"""(?P<requirement>[^;]+?)\s*;\s*extra\s*==\s*['"](?P<extra>\w+)['"]""")


def install_command(extra: str) -> str:
    """Returns the command that installs the packages of an extra: `pip install "plotly>=5.24"`.

    In double quotes, which every shell knows: without them, and in single ones on Windows, `>` writes a file.
    It names the packages themselves: trueloop comes from a clone or a wheel, where pip finds no extra of it by name.
    """
    found = (EXTRA.fullmatch(line) for line in requires("trueloop") or ())
    return " ".join(
        ["pip install", *(f'"{match["requirement"]}"' for match in found if match and match["extra"] == extra)]
    )
