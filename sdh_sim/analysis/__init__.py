"""Statistics of predicted against simulated success, from tables of trials."""
