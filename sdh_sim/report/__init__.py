"""The report of a comparison: a page with figures, and its numbers as CSV and Parquet."""
