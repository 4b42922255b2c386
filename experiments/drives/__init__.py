"""What the drives of the hand change: labels, loads, and which bound predicts them."""
