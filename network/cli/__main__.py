"""`python -m network.cli` is `lptn`."""

from network.cli.commands import main

main()
