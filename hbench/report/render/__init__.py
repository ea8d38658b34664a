"""Documents, figures and numbers in HTML, SVG, Markdown and PDF."""
