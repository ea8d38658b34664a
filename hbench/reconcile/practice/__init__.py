"""What an effect does at the bench: its size at the working point and along the logs."""
