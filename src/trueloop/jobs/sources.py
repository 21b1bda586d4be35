"""The files that a job is read from: its record names them by hash, its results must not overwrite them."""

from dataclasses import dataclass, field, replace
from pathlib import Path

from trueloop.domain.record import sha256_of


@dataclass(frozen=True)
class Sources:
    """Files by the names the job gives them. What is read for a job gets its path here, and so is noted.

    `folder` is where names start from, `prefix` how it is called from the job's own folder.
    """

    folder: Path
    prefix: Path = Path()
    named: dict[str, Path] = field(default_factory=dict)

    def file(self, name: Path | str) -> Path:
        """Returns the path of a file, and notes it."""
        path = self.folder / name
        self.named[str(self.prefix / name)] = path
        return path

    def beside(self, name: Path) -> "Sources":
        """Returns sources for the names in another file: they start from its folder, and are noted with these."""
        return replace(self, folder=(self.folder / name).parent, prefix=self.prefix / name.parent)

    @property
    def files(self) -> tuple[Path, ...]:
        """Returns all files that were noted."""
        return tuple(self.named.values())

    @property
    def sha256(self) -> dict[str, str]:
        """Returns their hashes by name."""
        return {name: sha256_of(path.read_bytes()) for name, path in self.named.items()}
