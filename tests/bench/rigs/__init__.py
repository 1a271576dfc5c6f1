"""Real rigs in one command: what is simulated, calibrated, diagnosed and named, and what of the concealed is found."""
