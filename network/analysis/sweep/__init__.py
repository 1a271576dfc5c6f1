"""Many simulations: simplification levels, numbers that vary, and what they cost."""
