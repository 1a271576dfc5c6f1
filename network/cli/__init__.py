"""The command `lptn`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from network.platform.stopping import STATUS, stoppable, tell_stopped

if TYPE_CHECKING:
    from network.cli.commands import cli as cli


def main(arguments: Sequence[str] | None = None) -> None:
    """The entry point. A stop is heard from here on, while the commands are still being loaded, too."""
    try:
        with stoppable():
            from network.cli.commands import run

            run(arguments)
    except KeyboardInterrupt:
        tell_stopped(lambda sentence: print(sentence, file=sys.stderr))
        sys.exit(STATUS)


def __getattr__(name: str) -> Any:
    if name != "cli":
        raise AttributeError(f"network.cli has no '{name}'")
    from network.cli.commands import cli

    return cli
