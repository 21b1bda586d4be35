"""Passwords: argon2id with 19 MiB and two passes (OWASP's setting), and what a password has to be."""

import math
import re
import unicodedata
from functools import cache
from threading import BoundedSemaphore
from typing import Final

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

from trueloop.errors import Code

SHORTEST: Final = 12
LONGEST: Final = 128
COMMON_LOG10: Final = 9.0
"""A password among the first 10⁹ guesses is common: by lists of passwords, words, names, rows of keys and dates."""
_LOOKED_AT: Final = 72
"""So many characters are judged, for the time that judging takes."""
_OF_THE_SHOP: Final = """
trueloop true loop correcthorsebatterystaple machine shop machineshop machinist workshop toolroom factory lathe
mill milling turning grinding machining spindle quality inspection operator admin administrator sommer winter
herbst frühling werkstatt maschine maschinenbau drehmaschine fräsmaschine drehbank drehteil drehen dreher fräsen
fräser schleifen bohren messen messraum prüfung qualität zerspanung fertigung produktion betrieb firma halle büro
meister schicht schichtleiter lehrling azubi passwort kennwort geheim zugang anmeldung benutzer willkommen hallo
schlüssel deutschland montag januar februar märz april mai juni juli august september oktober november dezember
fanuc siemens sinumerik heidenhain okuma mazak haas linuxcnc dmg mori hermle renishaw zeiss
"""
"""Words that people in a shop take first, which the lists of zxcvbn, English ones, are without."""
_WITHOUT_UMLAUTS: Final = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue"})
_HASHER: Final = PasswordHasher(time_cost=2, memory_cost=19 * 1024, parallelism=1)
_AT_ONCE: Final = BoundedSemaphore(2)
"""Each takes 19 MiB and a core for some 25 ms: attempts wait for each other, not other people for them."""


def hashed(password: str, name: str = "") -> str:
    """Returns what is stored. Raises SRV-PASSWORD for one that is too short, too long or common."""
    _require_good(_same(password), name)
    with _AT_ONCE:
        return _HASHER.hash(_same(password))


def is_right(stored: str | None, password: str) -> bool:
    """Returns whether it is the password; False after equal work without a stored one (no account, no password)."""
    with _AT_ONCE:
        try:
            right = _HASHER.verify(stored or _nobodys(), _same(password)[: 4 * LONGEST])
        except (VerificationError, InvalidHashError):
            return False
    return right and bool(stored)


def _same(password: str) -> str:
    return unicodedata.normalize("NFC", password)  # ü is typed in two ways


@cache
def _nobodys() -> str:
    return _HASHER.hash("of nobody")


_BETWEEN_WORDS: Final = re.compile(r"(?<=[^\W_])[-_.,+](?=[^\W_])|!+$")


def _guesses_log10(password: str, name: str) -> float:
    """Returns how many guesses it takes, as a power of ten: by the lists, the shop's words and the account's name."""
    from zxcvbn import zxcvbn  # an eighth of a second, for its lists

    words = [name, *re.split(r"[\W_]+", name), "correct horse battery staple", *_OF_THE_SHOP.split()]
    words += [word.translate(_WITHOUT_UMLAUTS) for word in words]
    as_typed = password[:_LOOKED_AT]
    return min(
        float(zxcvbn(text, user_inputs=words)["guesses_log10"])
        for text in {as_typed, _BETWEEN_WORDS.sub("", as_typed)}  # hyphens between words add nothing
    )


def _require_good(password: str, name: str) -> None:
    why = ""
    if not SHORTEST <= len(password) <= LONGEST:
        why = f"it has {len(password)} characters; {SHORTEST} to {LONGEST} are taken"
    elif (guesses_log10 := _guesses_log10(password, name)) < COMMON_LOG10:
        why = f"it is among the first 1e{math.ceil(guesses_log10)} guesses; 1e{COMMON_LOG10:.0f} are to be needed"
    if why:
        raise Code.SRV_PASSWORD.refusal(
            f"the password is not taken: {why}",
            hint="take four words that have nothing to do with each other; any characters and blanks are allowed",
            values={"length": float(len(password)), "shortest": float(SHORTEST)},
        )
