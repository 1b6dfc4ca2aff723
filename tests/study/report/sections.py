"""Sections of a page between markers, each written by a command of its own."""
import pathlib
import sys


def split(path, name):
    """Returns the text of a page before a section between markers, the section, and the text after it."""
    text = pathlib.Path(path).read_text()
    begin, end = f"<!-- begin of the {name} -->\n", f"<!-- end of the {name} -->\n"
    if begin not in text or end not in text:
        sys.exit(f"{path}: has no lines {begin}and {end}between which its section belongs: add them where it shall be")
    first, last = text.index(begin) + len(begin), text.index(end)
    return text[:first], text[first:last], text[last:]
