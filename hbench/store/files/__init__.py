"""Atomic writes, bounded reads, and tables as text, MATLAB and Parquet files."""
