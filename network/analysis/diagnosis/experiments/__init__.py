"""What to run next: programs, what they would tell apart, and advice."""
