"""The command line as a user calls it, in this process."""

from typer.testing import CliRunner, Result

from trueloop.cli.main import app


def invoke(*arguments: object, status: int | None = None) -> Result:
    """What a call ends with: exit code, stdout and stderr; with `status` it must end so."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert status is None or result.exit_code == status, result.output
    return result


def output_of(*arguments: object, status: int = 0) -> str:
    """All that a call says. It must end with that status."""
    return invoke(*arguments, status=status).output


def run(*arguments: object, status: int = 0) -> str:
    """What a call that succeeds writes to stdout, one that fails to stderr. It must end with that status."""
    result = invoke(*arguments, status=status)
    return result.stdout if status == 0 else result.stderr
