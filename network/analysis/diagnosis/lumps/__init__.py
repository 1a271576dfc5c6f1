"""Bars in more lumps: where that mends more than it costs, how far to go, and what stands in for it."""
