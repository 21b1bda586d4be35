"""The stable names: those listed, each with an example that runs, none imported before it is used."""

import ast
import doctest
import inspect
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trueloop

STUB = Path(trueloop.__file__).with_suffix(".pyi")
NAMES = sorted(set(dir(trueloop)) - {"__version__"})


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Examples write into the folder they run in."""
    monkeypatch.chdir(tmp_path)


def test_the_stub_re_exports_what_is_listed_and_nothing_else() -> None:
    names = [
        name for node in ast.parse(STUB.read_text()).body if isinstance(node, ast.ImportFrom) for name in node.names
    ]
    assert sorted(name.name for name in names) == NAMES
    assert all(name.asname == name.name for name in names)


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_what_its_module_defines_under_it(name: str) -> None:
    found = getattr(trueloop, name)
    assert found.__name__ == name
    assert f"from {found.__module__} import {name} as {name}\n" in STUB.read_text()


@pytest.mark.parametrize("name", NAMES)
def test_the_example_of_a_name_runs(name: str) -> None:
    found = getattr(trueloop, name)
    known = {"trueloop": trueloop, "np": np, "replace": replace, "Path": Path}
    example = doctest.DocTestParser().get_doctest(inspect.getdoc(found) or "", known, name, inspect.getfile(found), 0)
    assert example.examples
    said: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.IGNORE_EXCEPTION_DETAIL).run(example, out=said.append)
    assert not said, "".join(said)


def test_nothing_is_imported_before_a_name_is_used() -> None:
    code = (
        "import sys, trueloop; dir(trueloop); heavy = {'numpy', 'scipy', 'pydantic', 'trueloop._core'};"
        "assert not heavy & set(sys.modules); trueloop.example; assert not heavy & set(sys.modules);"
        "trueloop.check; assert 'numpy' in sys.modules and 'pydantic' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
