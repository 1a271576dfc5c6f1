"""Drafting: a first machine file from recordings alone."""
