"""The table `[features]` of a mapping: the part's names of features, by those in the file."""

import tomllib
from collections.abc import Mapping
from pathlib import Path

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.formats.toml_tables import SYNTAX_HINT

HINT = 'a table [features] with lines such as "DIAMETER 7" = "journal"'


def feature_names(mapping: Path | None) -> Mapping[str, str]:
    """The names of a mapping of any kind of file; none without a mapping or table. Raises MSR-MAPPING."""
    if mapping is None:
        return {}
    try:
        content = tomllib.loads(read_text(mapping, Code.MSR_MAPPING, hint=HINT))
    except (ValueError, RecursionError) as error:
        why = f"not a TOML file: {error}"
        raise TrueloopError(Code.MSR_MAPPING, why, hint=SYNTAX_HINT, place=Place(str(mapping))) from error
    names = content.get("features", {})
    if not isinstance(names, dict) or not all(isinstance(one, str) for one in names.values()):
        raise TrueloopError(
            Code.MSR_MAPPING, "'features' is no table of names in quotes", hint=HINT, place=Place(str(mapping))
        )
    return names
