"""Writes the files under ``models``; nothing else imports it."""
