"""YAML read so that nothing hostile in it can do harm, every value with its line."""
