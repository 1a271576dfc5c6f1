"""`python -m network.cli` is `lptn`."""

from network.cli import main

main()
