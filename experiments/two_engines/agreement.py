def both_labels(runs): return None
def report(labels, console): pass
