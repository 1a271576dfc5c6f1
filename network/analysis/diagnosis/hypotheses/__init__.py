"""A case, what is supposed to be missing in it, and how that is fitted."""
