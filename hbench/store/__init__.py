"""Files: the campaign folder, DSP log formats, import of foreign logs."""
