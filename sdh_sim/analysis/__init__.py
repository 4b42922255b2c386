"""Predicted against simulated success: statistics of tables of trials."""
