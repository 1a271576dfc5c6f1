"""The search for what switches on and off: draws, their refinement, fits of the best."""
