"""Page, text and figures of a controller design."""
