"""A certificate as lines for a terminal."""

from collections.abc import Iterator

from trueloop.report.monitor.certificate_shape import CertificateShape

HEAD = ("characteristic", "limits", "actual", "U (k = 2)", "verdict", "by", "not known")


def certificate_rows(shown: CertificateShape) -> Iterator[tuple[str, ...]]:
    """Cells of a table, one row a characteristic; mm, of angles degrees."""
    for one in shown.characteristics:
        limits = ["" if limit is None else f"{limit:.4f}" for limit in (one.lower_limit, one.upper_limit)]
        yield (
            one.characteristic,
            " … ".join(limits),
            "" if one.actual is None else f"{one.actual:.4f}",
            "" if one.expanded_u is None else f"{one.expanded_u:.4f}",
            (one.verdict or "") if one.verdict == "out" or not one.missing else "not certified",
            one.device,
            "; ".join(one.missing),
        )


def in_force_lines(shown: CertificateShape) -> Iterator[str]:
    """What was in force, what is not known of it, and the certificate's hash."""
    for one in shown.in_force:
        yield " ".join(text for text in (f"{one.what}:", one.identity, one.words and f"({one.words})") if text)
    yield from (f"not known: {text}" for text in shown.missing)
    yield f"sha256 {shown.sha256}"
