"""Numbers with units: from text to SI and back, and how numbers are shown."""
