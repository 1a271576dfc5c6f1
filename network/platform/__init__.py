"""What every room stands on: refusals, files written whole or not at all, processes, signals, units, YAML."""
