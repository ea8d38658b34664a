"""Raw logs of the board as Code Composer Studio data files, and the layout of their records."""
