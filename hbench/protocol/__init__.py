"""Protocol between host and board: message dictionary, payloads, frames. No input or output."""
