"""The grammar of entries: fields, places, patches, and how an entry is read from YAML and written back."""
