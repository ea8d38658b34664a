"""Import maps suggested from the content of foreign files."""
