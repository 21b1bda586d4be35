"""Output to a stream that is not UTF-8, as a Windows pipe or a latin-1 host: characters it lacks become ASCII ones."""

import codecs
import sys
import unicodedata
from typing import Final

HANDLER: Final = "trueloop-ascii"
ASCII: Final = "trueloop_ascii"
"""The codec of streams that are ASCII: click would write UTF-8 to one that is called `ascii`."""
_WRITTEN: Final = {
    **{"±": "+-", "µ": "u", "μ": "u", "°": " deg", "…": "...", "–": "-", "—": "-", "−": "-", "·": "*", "×": "x"},
    **{"’": "'", "‘": "'", "“": '"', "”": '"', "′": "'", "″": '"', "→": "->", "←": "<-", "↑": "^", "↓": "v"},
    **{"≤": "<=", "≥": ">=", "≠": "!=", "≈": "~", "Ø": "dia ", "ø": "dia ", "⌀": "dia ", "∅": "dia ", "√": "sqrt"},
    **{"✓": "ok", "✗": "x", "●": "*", "○": "o", "■": "#", "▲": "^", "▼": "v", "÷": "/", "ß": "ss", "§": "section "},
    **{"─": "-", "━": "-", "│": "|", "┃": "|", "\N{ZERO WIDTH NO-BREAK SPACE}": ""},
}


def plain(text: str) -> str:
    """Returns the text in ASCII: by the table, else without accents, a Greek letter by its name, else `?`."""
    return "".join(character if character.isascii() else _plain(character) for character in text)


def _plain(character: str) -> str:
    if character in _WRITTEN:
        return _WRITTEN[character]
    without = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    name = unicodedata.name(character, "")
    if name.startswith("GREEK ") and " LETTER " in name:
        letter = name.rpartition(" LETTER ")[2].partition(" ")[0]
        return letter.lower() if "SMALL" in name else letter.capitalize()
    return without or ("" if unicodedata.combining(character) else "?")


def _replaced(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return plain(error.object[error.start : error.end]), error.end


def _encoded(text: str, errors: str = "strict") -> tuple[bytes, int]:
    return plain(text).encode("ascii"), len(text)


class _Encoder(codecs.IncrementalEncoder):
    def encode(self, text: str, final: bool = False) -> bytes:
        return _encoded(text)[0]


def _codec(name: str) -> codecs.CodecInfo | None:
    if name != ASCII:
        return None
    return codecs.CodecInfo(_encoded, codecs.ascii_decode, incrementalencoder=_Encoder, name=ASCII)


def write_what_streams_take() -> None:
    """Sets stdout and stderr up so that no text fails on them; what the user set by PYTHONIOENCODING stays."""
    codecs.register_error(HANDLER, _replaced)
    codecs.register(_codec)
    for stream, errors in ((sys.stdout, "strict"), (sys.stderr, "backslashreplace")):
        if getattr(stream, "errors", None) != errors:
            continue
        if codecs.lookup(stream.encoding).name == "ascii":
            stream.reconfigure(encoding=ASCII)  # type: ignore[union-attr]
        else:
            stream.reconfigure(errors=HANDLER)  # type: ignore[union-attr]
