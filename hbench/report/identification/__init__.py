"""Page, text and figures of an identification, and its plant files."""
