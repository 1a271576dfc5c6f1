"""The search for sensors that are mixed up: all pairs scored about a fit, the best confirmed by fits."""
