"""What runs and recordings tell: residuals, sweeps, calibrated numbers, missing physics."""
