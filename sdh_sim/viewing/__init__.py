"""Pictures, films and rerun recordings of a trial."""
