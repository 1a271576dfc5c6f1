"""What every candidate would explain at most about one fit, and whether that is more than chance."""
