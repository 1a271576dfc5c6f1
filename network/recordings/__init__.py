"""What drives a machine and what was measured on it: scenarios, recordings, mappings, inputs over time."""
