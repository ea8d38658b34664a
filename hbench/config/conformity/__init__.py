"""Files that state when a cylinder conforms."""
