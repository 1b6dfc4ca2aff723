"""What of the simulation is linked."""
import subprocess


def symbols(nm, path, kinds, *options):
    """Of these kinds, as nm calls them."""
    listing = subprocess.run([nm, "--extern-only", *options, path], check=True, capture_output=True, text=True)
    lines = (line.split() for line in listing.stdout.splitlines())
    return {fields[-1] for fields in lines if len(fields) in (2, 3) and fields[-2] in kinds}


def functions_of(nm, *libraries):
    """Those that no other library of the project defines as well."""
    return set().union(*(symbols(nm, library, "T", "--defined-only") for library in libraries))
