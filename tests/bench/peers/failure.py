class Failure(Exception):
    """One sentence for a person: what went wrong, and what was expected."""
