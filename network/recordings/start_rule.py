"""How a run may be told to begin, beside temperatures."""

ESTIMATED = "estimated"
"""The start that is found from a recording itself."""
