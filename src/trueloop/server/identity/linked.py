"""The account of whom an identity provider names: linked by an administrator, never made by signing in."""

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from sqlalchemy import Row, select

from trueloop.errors import TrueloopError
from trueloop.server.identity.accounts import Change, change_account, subject_of
from trueloop.server.identity.provider import Oidc, refused
from trueloop.server.identity.who import ROLES, Role
from trueloop.storage.factory_tables import ACCOUNT
from trueloop.storage.store import Store


def account_of(store: Store, oidc: Oidc, claims: Mapping[str, object], now: datetime) -> Row[Any]:
    """Returns the account, with the role that the claim gives it where one is named. Raises SRV-OIDC for a stranger,
    for a disabled account, and for a claim that gives no role.
    """
    subject = str(claims["sub"])
    found = _found(store, oidc, subject)
    if found is None or found.disabled:
        raise refused(
            f"no account is open for {subject!r} of {oidc.issuer}; an administrator links one: "
            f"trueloop user link NAME {subject!r} --issuer {oidc.issuer}"
        )
    if not oidc.role_claim:
        return found
    role = role_of(oidc, claims)
    if role == found.role:
        return found
    try:
        change_account(store, found.name, Change(role=role), now, by=oidc.issuer)
    except TrueloopError as error:
        raise refused(f"the role {role!r} cannot be given: {error.message}") from error
    changed = _found(store, oidc, subject)
    if changed is None or changed.disabled:
        raise refused("the account was changed meanwhile")
    return changed


def role_of(oidc: Oidc, claims: Mapping[str, object]) -> Role:
    """Returns the highest role that a value of the claim gives. Raises SRV-OIDC where none does."""
    claim = claims.get(oidc.role_claim)
    values = claim if isinstance(claim, list) else [claim]
    given = [role for value, role in oidc.roles if value in values]
    if not given:
        raise refused(f"its claim {oidc.role_claim!r} gives no role")
    return max(given, key=ROLES.index)


def _found(store: Store, oidc: Oidc, subject: str) -> Row[Any] | None:
    wanted = select(ACCOUNT).where(ACCOUNT.c.oidc_subject == subject_of(oidc.issuer, subject))
    with store.reading() as connection:
        return connection.execute(wanted).one_or_none()
