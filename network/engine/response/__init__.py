"""A run as a fit sees it: linear runs over knots, cell means, and how they answer to heat and to parameters."""
