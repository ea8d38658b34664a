"""Page, text, figures and files of a diagnosis."""
