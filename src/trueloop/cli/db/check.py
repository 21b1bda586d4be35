"""`trueloop db check`: what is odd in a store."""

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import ExitStatus, as_dict, guarded
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines


@guarded
def check(db: Db = None, as_json: AsJson = False) -> None:
    """Check that rows are what was kept, that links lead to rows, and that labels, order and times agree."""
    from trueloop.jobs.db.checked import check_store
    from trueloop.jobs.store.opened import opened

    store = opened(db, read_only=True)
    with busy(f"checking {store.where}") as progress:
        done = check_store(store, progress)
    if as_json:
        odd = [{"severity": one.severity, **as_dict(one.as_error())} for one in done.findings]
        print_json({"store": store.where, "rows": done.rows, "findings": odd})
    else:
        print_lines([*done.findings, f"{store.where}: {done.rows} rows, {len(done.findings)} findings"])
    if done.findings:
        raise typer.Exit(ExitStatus.FINDINGS)
