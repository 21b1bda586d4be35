"""Which control a command means."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from trueloop.jobs.links.opened import Opened
    from trueloop.jobs.links.recorded import Recorder

NotRunning = Annotated[bool, typer.Option("--not-running", help="It does not run: for links that cannot know it.")]

Db = Annotated[
    str | None, typer.Option("--db", metavar="FILE|URL", help="Record the transfer in this store.  [default: in none]")
]


@dataclass(frozen=True, kw_only=True)
class LinkOf:
    """Which control."""

    link: Annotated[str, typer.Option("--link", "-l", help="The link's name in the settings.")]
    settings: Annotated[
        Path, typer.Option("--settings", help="A TOML file with a table for each link.", metavar="LINKS.toml")
    ] = Path("links.toml")

    def opened(self) -> "Opened":
        """The link; what its user has to know goes to stderr."""
        from trueloop.jobs.links.opened import opened

        found = opened(self.settings, self.link, lambda said: typer.echo(said, err=True))
        if found.link.note:
            typer.echo(f"note: {found.link.note}", err=True)
        return found

    def recorder(self, db: str | None) -> "Recorder | None":
        """What keeps the transfer, where a store is named."""
        if db is None:
            return None
        from trueloop.jobs.links.recorded import Recorder
        from trueloop.jobs.store.opened import opened

        return Recorder(opened(db), self.link)
