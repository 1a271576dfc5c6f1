"""Proof: machines simulated by separate code, with effects concealed from their machine files, and a scorer.

Nothing in here imports the product. The truth has its own mesh, its own integrator and its own laws; what it shares
with the product is only the file format: what a place, a link and a number with ± mean.
"""
