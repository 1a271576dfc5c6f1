"""What commands leave in a folder, and the page of a diagnosis."""
