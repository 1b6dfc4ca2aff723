"""Prints the outcome of a check of the sources and returns its exit code."""


def verdict(script, finds_its_own_example, found, read, good):
    """found: its complaints. read: number of things that it looked at; none is a failure. good: the line without complaints."""
    if not finds_its_own_example:
        print(f"{script} does not find the faults of its own example")
        return 1
    print("\n".join(found) or good)
    return 1 if found or not read else 0
