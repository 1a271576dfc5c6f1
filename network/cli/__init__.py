"""The command `lptn`."""

from network.cli.commands import cli as cli
from network.cli.commands import main as main
