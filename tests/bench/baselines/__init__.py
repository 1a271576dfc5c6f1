"""Simpler ways to name what is missing, on the cases of the proof: what the diagnosis has to beat."""
