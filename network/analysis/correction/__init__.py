"""Corrections for a control: the machine reduced to few states, its filter, and what that costs in micrometres."""
