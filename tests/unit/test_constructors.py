"""A call of a constructor with more than five positional arguments hides which value is which: those are named."""

import ast
from pathlib import Path

import trueloop

ROOT = Path(trueloop.__file__).parent
MOST = 5


def _records(trees: list[ast.Module]) -> set[str]:
    """Returns the names of the dataclasses and named tuples of the product."""
    return {
        node.name
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        and any("dataclass" in ast.unparse(one) for one in node.decorator_list)
        | any(ast.unparse(one).endswith("NamedTuple") for one in node.bases)
    }


def _positional(call: ast.Call) -> int:
    """Counts them; those of a tuple that is unpacked at the call count each."""
    unpacked = [one.value for one in call.args if isinstance(one, ast.Starred)]
    return len(call.args) + sum(len(one.elts) - 1 for one in unpacked if isinstance(one, ast.Tuple))


def test_constructors_take_at_most_five_positional_arguments() -> None:
    trees = {one: ast.parse(one.read_text()) for one in ROOT.rglob("*.py") if "manual" not in one.parts}
    others = {"Table"}  # also a class of SQLAlchemy and of rich
    records = {*_records(list(trees.values())), "cls"} - others
    assert len(records) > 500
    assert [
        f"{file.relative_to(ROOT)}:{call.lineno} {ast.unparse(call.func)}"
        for file, tree in trees.items()
        for call in ast.walk(tree)
        if isinstance(call, ast.Call)
        and ast.unparse(call.func).rpartition(".")[2] in records
        and _positional(call) > MOST
    ] == []
