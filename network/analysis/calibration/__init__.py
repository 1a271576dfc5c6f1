"""Calibration: the uncertain numbers of a machine from its recordings, with what the recordings cannot tell."""
