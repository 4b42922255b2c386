"""Pictures, films and rerun recordings of a trial; import from the files."""
