"""Tests of residuals: is what is left white noise, and if not, when, how often and with what does it go."""
