"""What an installed trueloop consists of."""

import os
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import distribution, entry_points
from pathlib import Path

import pytest

import trueloop

ROOT = Path(__file__).parents[2]


def test_the_version_stands_in_the_cargo_workspace_alone() -> None:
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]
    assert trueloop.__version__ == distribution("trueloop").version == workspace["package"]["version"]
    assert "version" not in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for crate in workspace["members"]:
        package = tomllib.loads((ROOT / crate / "Cargo.toml").read_text())["package"]
        assert package["version"] == {"workspace": True}, crate


def test_the_changelog_tells_of_this_version() -> None:
    assert f"\n## [{trueloop.__version__}]" in (ROOT / "CHANGELOG.md").read_text()


def test_an_unknown_attribute_of_the_package_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        trueloop.nothing  # type: ignore[attr-defined]  # noqa: B018


def test_the_command_loads() -> None:
    (command,) = entry_points(group="console_scripts", name="trueloop")
    assert callable(command.load())


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """The wheel of this tree."""
    folder = tmp_path_factory.mktemp("wheel")
    maturin = Path(sys.executable).with_name("maturin")
    subprocess.run(
        [maturin, "build", "--release", "--locked", "--out", folder], cwd=ROOT, check=True, capture_output=True
    )
    (path,) = folder.glob("trueloop-*-abi3-*.whl")
    return zipfile.ZipFile(path)


def test_the_wheel_holds_every_module_example_and_type_the_core_and_the_licence(wheel: zipfile.ZipFile) -> None:
    held = set(wheel.namelist())
    modules = {str(file.relative_to(ROOT / "src")) for file in (ROOT / "src").glob("trueloop*/**/*.py")}
    examples = {
        f"trueloop/examples/{file.relative_to(ROOT / 'examples')}"
        for file in (ROOT / "examples").rglob("*")
        if file.is_file()
    }
    assert examples
    assert examples <= held
    pages = {f"trueloop/pages/{name}" for name in ("index.html", "icon.svg", "licences.txt", "manifest.json")}
    assert pages <= held, "the pages were not built: make web"
    assert any(name.startswith("trueloop/pages/assets/") and name.endswith(".js") for name in held)
    manual = {f"trueloop/manual/{name}" for name in ("index.html", "search.html", "search-index.js", "first-part.html")}
    assert manual <= held, "the manual was not built: make docs"
    types = {"trueloop/__init__.pyi", "trueloop/_core.pyi", "trueloop/py.typed"}
    assert modules | types | {"trueloop/_core.abi3.so"} <= held
    assert any(name.endswith("dist-info/licenses/LICENSE") for name in held)
    assert not any(name.startswith(("tests", "benches")) for name in held)


def test_the_demo_runs_from_the_wheel_alone(wheel: zipfile.ZipFile, tmp_path: Path) -> None:
    wheel.extractall(tmp_path / "site")
    run = subprocess.run(
        [
            sys.executable,
            "-c",
            "import trueloop; print(trueloop.__file__); from trueloop.cli.main import main; main()",
            "demo",
        ],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "site")},
        check=True,
        capture_output=True,
        text=True,
    )
    assert run.stdout.splitlines()[0] == str(tmp_path / "site" / "trueloop" / "__init__.py")
    assert (tmp_path / "out" / "modbas2" / "report.html").stat().st_size > 100_000


def test_licence_and_lowest_python_are_declared() -> None:
    metadata = distribution("trueloop").metadata
    assert (metadata["License-Expression"], metadata["Requires-Python"]) == ("Apache-2.0", ">=3.11")
    assert "Apache License" in (ROOT / "LICENSE").read_text()
