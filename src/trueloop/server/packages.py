"""The packages that the service needs beyond what trueloop does: `require_packages`."""

from importlib.util import find_spec
from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.extras import install_command

NEEDED: Final = {
    "argon2": "argon2-cffi",
    "fastapi": "fastapi",
    "joserfc": "joserfc",
    "uvicorn": "uvicorn",
    "zxcvbn": "zxcvbn",
}
"""What is imported, by the name of its package."""


def require_packages() -> None:
    """Raises SRV-PACKAGE for one that is not installed."""
    for module, package in NEEDED.items():
        if find_spec(module) is None:
            raise TrueloopError(
                Code.SRV_PACKAGE,
                f"the service needs the package {package!r}",
                hint=f"install it: {install_command('service')}",
                values={"package": package},
            )
