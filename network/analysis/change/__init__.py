"""What has changed about a machine between two sets of recordings: numbers that moved, sensors that drifted."""
