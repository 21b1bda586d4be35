"""The real-time evaluator as it is compiled: of what it calls nothing panics and nothing asks for memory."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
FUNCTION = re.compile(r"^(_[\w.$]+):$(.*?)^\s*\.size\s", re.MULTILINE | re.DOTALL)
CALL = re.compile(r"\s(?:callq?|jmpq?|bl?)\s+\*?(_?[A-Za-z][\w.$]+)")
HARMLESS = re.compile(r"mem(cpy|set|move)|pulp.*detect_is_available")
"""What may be called of elsewhere: copies, and asking once which registers the processor has."""


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """Every function of the compiled crate, and what it calls."""
    folder = tmp_path_factory.mktemp("machine-code")
    build = ["cargo", "rustc", "--quiet", "--locked", "--release", "--lib", "-p", "error-eval"]
    options = ["--target-dir", str(folder), "--", "--emit", "asm", "-C", "codegen-units=1"]
    subprocess.run([*build, *options], cwd=ROOT, check=True, capture_output=True)
    assembly = "\n".join(path.read_text() for path in folder.glob("release/deps/error_eval-*.s"))
    return {name: set(CALL.findall(body)) for name, body in FUNCTION.findall(assembly)}


@pytest.mark.parametrize("function", ["5Model5error", "5Model6errors"])
def test_nothing_panics_or_asks_for_memory(functions: dict[str, set[str]], function: str) -> None:
    waiting = [name for name in functions if function in name]
    assert waiting
    reached: set[str] = set()
    while waiting:
        name = waiting.pop()
        reached.add(name)
        waiting += functions.get(name, set()) - reached
    elsewhere = {name for name in reached - functions.keys() if not HARMLESS.search(name)}
    assert not elsewhere
    assert not [name for name in reached if re.search("panic|unwrap_failed|something_went_wrong|alloc", name)]


def test_a_function_that_panics_would_be_seen(functions: dict[str, set[str]]) -> None:
    """What bytemuck has for casts that do not fit is compiled too, never called, and calls a panic."""
    assert any("panic" in called for name in functions if "something_went_wrong" in name for called in functions[name])
