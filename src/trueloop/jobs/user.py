"""Who runs this."""

import getpass


def user_name() -> str:
    """Returns the name of whoever runs this, as far as the system knows."""
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown"
