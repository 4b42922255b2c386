"""Standard load protocols for robot hands, run in simulation beside their closed forms."""
