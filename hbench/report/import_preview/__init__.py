"""Page and figures of the preview of an import."""
