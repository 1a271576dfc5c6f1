"""What the user reads: words for the terminal, figures, pages. Nothing here is imported before it is needed."""
