"""The programs of [6811, Appendix], as scanned: words that slid into another block go back where they belong."""

import re
from pathlib import Path

WORD = re.compile(r"[XZIKRF](?:-?[\d.]+|\((?:[^()]|\([^()]*\))*\))")


def nist_program(corpus: Path, number: str) -> bytes:
    """Program `number`, its words dealt out again to the blocks between G95 and the first rapid move after it.

    In several listings the words of a block stand at the end of the line before, after its comment. Blocks and words
    are both in order; a letter that comes again begins the next block. Comments of these blocks are lost.
    """
    lines = (corpus / "data" / "nist" / "programs" / f"{number}.nc").read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if re.match(r"N\d+ +G95", line)) + 1
    last = next(i for i, line in enumerate(lines[first:], start=first) if re.match(r"N\d+ +G00 ", line))
    heads = [" ".join(line.split()[:2]) for line in lines[first:last]]
    blocks: list[list[str]] = [[]]
    for word in WORD.findall(" ".join(lines[first:last])):
        if any(word[0] == earlier[0] for earlier in blocks[-1]):
            blocks.append([])
        blocks[-1].append(word)
    cut = [" ".join([head, *words]) for head, words in zip(heads, blocks, strict=True)]
    return "\n".join([*lines[:first], *cut, *lines[last:], ""]).encode()
