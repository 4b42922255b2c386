"""What is read of folders and files that a user brings: nothing else, and within bounds."""
