"""Loading firmware into a board: boot images, the serial boot ROM, outside programmers."""
