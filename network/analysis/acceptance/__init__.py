"""Acceptance tests: the thermal tests of ISO 230-3, from a simulation or a recording."""
