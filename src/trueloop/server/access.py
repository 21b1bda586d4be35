"""Who may use which address: one table, `ACCESS`. An address that does not stand in it is not served.

What a request may do to a part or an order the factory decides once more, by its own table.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trueloop.errors import Code
from trueloop.server.identity.keys import ROLES, Role, Who
from trueloop.wording import wording


@dataclass(frozen=True)
class Access:
    """`role`: the least of a person, None: no person. `key`: the scope of keys that may. `open`: whoever asks.

    `once`: whether a POST needs an Idempotency-Key; not where doing it twice is doing it once, or where the answer is a
    secret. `quick`: it takes milliseconds of one processor, and waits for nobody.
    """

    role: Role | None = None
    key: Role | None = None
    open: bool = False
    once: bool = True
    quick: bool = False


READ: Final = Access("viewer")
QUICK: Final = Access("viewer", quick=True)
OPERATOR: Final = Access("operator")
ENGINEER: Final = Access("engineer")
ADMIN: Final = Access("admin")
CELL: Final = Access(key="cell")

ACCESS: Final[Mapping[tuple[str, str], Access]] = {
    ("POST", "/session"): Access(open=True, once=False),
    ("POST", "/session/first"): Access(open=True, once=False),
    ("DELETE", "/session"): READ,
    ("GET", "/session/ways"): Access(open=True),
    ("GET", "/session/oidc"): Access(open=True),
    ("GET", "/session/oidc/callback"): Access(open=True),
    ("GET", "/me"): QUICK,
    ("PATCH", "/me"): READ,
    ("GET", "/openapi.json"): READ,
    ("GET", "/events"): READ,
    ("GET", "/event-log"): QUICK,
    ("GET", "/accounts"): ADMIN,
    ("POST", "/accounts"): Access("admin", once=False),  # nothing of a password is kept; a second one is refused
    ("PATCH", "/accounts/{name}"): ADMIN,
    ("GET", "/keys"): ADMIN,
    ("POST", "/keys"): ADMIN,
    ("DELETE", "/keys/{id}"): ADMIN,
    ("GET", "/today"): QUICK,
    ("GET", "/parts"): QUICK,
    ("GET", "/parts/{id}/life"): QUICK,
    ("GET", "/corrections/{id}/report"): READ,
    ("GET", "/corrections/{id}/curves"): READ,
    ("GET", "/corrections/{id}/curves/{number}"): READ,
    ("GET", "/corrections/{id}/sources"): READ,
    ("GET", "/series"): READ,
    ("GET", "/series/{part_type}/{characteristic:path}"): READ,
    ("GET", "/charts/{part_type:path}"): READ,
    ("GET", "/diagnosis/series/{part_type:path}"): READ,
    ("GET", "/diagnosis/part/{serial:path}"): READ,
    ("GET", "/tools"): QUICK,
    ("GET", "/tools/{id}/memory"): READ,
    ("GET", "/machines"): QUICK,
    ("GET", "/machines/{name:path}"): QUICK,
    ("GET", "/machines/{name:path}/trace"): READ,
    ("GET", "/machines/{name:path}/corrector"): READ,
    ("POST", "/machines/{name:path}/calibrated"): Access("operator", key="cell"),
    ("GET", "/orders"): QUICK,
    ("POST", "/orders"): ENGINEER,
    ("GET", "/orders/{id}"): QUICK,
    ("POST", "/orders/{id}/hold"): OPERATOR,
    ("POST", "/orders/{id}/decide"): OPERATOR,
    ("POST", "/orders/{id}/arm"): Access("operator", key="cell"),
    ("POST", "/orders/{id}/parts/{part}/record"): OPERATOR,
    ("GET", "/proposals"): QUICK,
    ("GET", "/proposals/{id}"): READ,
    ("GET", "/proposals/{id}/picture"): READ,
    ("POST", "/proposals/{id}/accept"): ENGINEER,
    ("POST", "/proposals/{id}/reject"): ENGINEER,
    ("GET", "/alarms"): QUICK,
    ("POST", "/alarms/{id}/acknowledge"): OPERATOR,
    ("GET", "/programs"): QUICK,
    ("GET", "/programs/{sha}"): READ,
    ("GET", "/programs/{a}/diff/{b}"): READ,
    ("POST", "/programs/{sha}/release"): ENGINEER,
    ("GET", "/transfers"): QUICK,
    ("GET", "/links"): ENGINEER,
    ("GET", "/certificates"): QUICK,
    ("GET", "/certificates/{id}"): READ,
    ("POST", "/certificates"): ENGINEER,
    ("POST", "/uploads"): OPERATOR,
    ("GET", "/uploads/{sha}/file"): OPERATOR,
    ("POST", "/by-hand/part"): Access("operator", once=False),
    ("POST", "/by-hand/correction"): OPERATOR,
    ("POST", "/by-hand/milled"): Access("operator", once=False),
    ("POST", "/by-hand/entries"): OPERATOR,
    ("POST", "/uploads/{sha}/read"): Access("operator", once=False),
    ("POST", "/uploads/{sha}/program"): OPERATOR,
    ("POST", "/uploads/{sha}/measurement"): OPERATOR,
    ("GET", "/tasks/{id}"): QUICK,
    ("POST", "/cell/next"): CELL,
    ("POST", "/cell/facts"): CELL,
    ("POST", "/cell/touches"): CELL,
    ("POST", "/cell/temperatures"): CELL,
    ("POST", "/cell/heartbeat"): Access(key="cell", once=False),
    ("POST", "/cell/trace"): Access(key="cell", once=False),
}


def access_of(method: str, path: str) -> Access:
    """Returns the entry of an address. Raises LookupError without one: a fault of ours, noticed as the app is made."""
    found = ACCESS.get((method, path))
    if found is None:
        raise LookupError(f"{method} {path} has no entry in ACCESS")
    return found


def require(access: Access, who: Who) -> None:
    """Raises SRV-ROLE where that person or key may not, SRV-KEY for a key where only persons are let in."""
    if not who.person and access.key != who.role:
        raise Code.SRV_KEY.refusal(
            f"the key {who.name!r} is for {who.role}; this address takes {_takes(access)}",
            hint="a key serves what it was made for; people sign in",
        )
    if who.person and (access.role is None or ROLES.index(who.role) < ROLES.index(access.role)):
        needed = access.role or access.key or "admin"
        raise Code.SRV_ROLE.refusal(
            wording("{who!r} has the role {role!r}; this needs {needed!r}", who=who.name, role=who.role, needed=needed),
            hint=wording("ask somebody with that role, or an administrator for it"),
            values={"role": who.role, "needed": needed},
        )


def _takes(access: Access) -> str:
    return f"keys for {access.key}" if access.key else "no key"
