"""The physics: one effect is one small file in its room; the declaration says what an entry may hold."""
