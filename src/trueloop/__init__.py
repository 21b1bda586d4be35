"""Closed-loop machining: measure the part, model the error, cut the next pass true.

`__init__.pyi` lists the stable names and where each is defined; docs/python.md tells how they go together.
"""


def __getattr__(name: str) -> object:
    """A stable name, imported when first asked for: `import trueloop` itself takes no time."""
    if name == "__version__":
        from importlib.metadata import version

        return version("trueloop")
    home = {} if name.startswith("__") else _homes()
    if name not in home:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    found = globals()[name] = getattr(import_module(home[name]), name)
    return found


def __dir__() -> list[str]:
    """The stable names."""
    return [*_homes(), "__version__"]


def _homes() -> dict[str, str]:
    """Module by stable name, as the stub beside this file imports them: types and names cannot disagree."""
    import ast
    from pathlib import Path

    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    return {name.name: str(node.module) for node in imports for name in node.names}
