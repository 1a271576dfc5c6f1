"""Pages: results as one HTML file, with charts that read without JavaScript and answer to a pointer with it."""
