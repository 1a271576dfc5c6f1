"""ROOM 3: what a measured channel does to the truth. One effect, one file."""
