"""Text and figures of a comparison of two campaigns."""
