"""Which state a change is of: `ETag` in answers, `If-Match` in changes."""

from fastapi import Request, Response

from trueloop.errors import Code, TrueloopError
from trueloop.server.identity.accounts import stale


def wanted(request: Request) -> str:
    """The state that `If-Match` names. Raises SRV-MATCH where it does not say."""
    given = request.headers.get("if-match", "").strip()
    if not given or given == "*":
        raise TrueloopError(
            Code.SRV_MATCH,
            f"the change does not say of which state: the header 'If-Match' is {given or 'missing'}",
            hint="send `If-Match` with the ETag that the thing had when it was read",
        )
    return given.removeprefix("W/").strip('"')


def require_same(request: Request, now: str) -> None:
    """Raises SRV-MATCH, and SRV-STALE where it is another by now."""
    given = wanted(request)
    if given != now:
        raise stale(given, now)


def tag(response: Response, etag: str) -> None:
    """Says which state an answer is."""
    response.headers["ETag"] = f'"{etag}"'
