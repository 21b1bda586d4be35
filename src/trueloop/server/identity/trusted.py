"""An identity provider that is trusted, and what is said where it is not: `Oidc`."""

from dataclasses import dataclass, field

from trueloop.errors import Code, TrueloopError
from trueloop.server.identity.who import Role


@dataclass(frozen=True)
class Oidc:
    """An identity provider that is trusted. `secret`: empty for a client without one. `label`: what pages call it.

    `role_claim`: the claim that gives the role, by `roles` (a value of the claim, a role), the highest that fits;
    empty: the role is the account's.
    """

    issuer: str
    client_id: str
    secret: str = field(default="", repr=False)
    label: str = "Single sign-on"
    role_claim: str = ""
    roles: tuple[tuple[str, Role], ...] = ()


def refused(why: str) -> TrueloopError:
    """Makes the error SRV-OIDC."""
    hint = "sign in anew; if it stays so, an administrator has to look at the account and the provider's settings"
    return TrueloopError(Code.SRV_OIDC, f"the sign-in is not taken: {why}", hint=hint)
