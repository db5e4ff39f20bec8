"""Keeps what git does not know out of wheels and source archives: a user's own modules, notes."""

import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Excludes the untracked files of a checkout."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Before a build: exclude them; a source archive, which is no checkout, has none."""
        if version == "editable" or not (Path(self.root) / ".git").exists():
            return
        # Hatch itself leaves out what .gitignore lists, and knows no other list of git's.
        listing = subprocess.run(
            ["git", "ls-files", "-z", "--others", "--exclude-from=.gitignore"],
            cwd=self.root,
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        if names := [name for name in listing.split("\0") if name]:
            config = self.build_config.target_config
            escaped = ["/" + "".join(f"\\{c}" if c in "*?[\\!# " else c for c in n) for n in names]
            config["exclude"] = [*config.get("exclude", []), *escaped]
            self.app.display_warning(f"left out, since git does not know it: {', '.join(names)}")
