"""Where the movement of the tool centre point comes from: by heat source, by part, by stretching, bending and tilt."""
