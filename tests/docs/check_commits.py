#!/usr/bin/env python3
"""Subjects of commits that are not yet on main are `area: verb object`, at most 72 characters; the why is in the body.

usage: check_commits.py SOURCE_DIR
"""
import pathlib
import re
import subprocess
import sys

LONGEST = 72
SUBJECT = re.compile(r"[a-z0-9][\w./-]*: \S")
MAIN = ("origin/main", "main")


def complaint(subject):
    """The reason why a subject is refused; empty if it is good."""
    if len(subject) > LONGEST:
        return f"{len(subject)} characters, at most {LONGEST}"
    if not SUBJECT.match(subject):
        return "does not begin with `area: `"
    return ""


def git(source, *words):
    try:
        result = subprocess.run(["git", "-C", source, *words], capture_output=True, text=True, check=False)
    except FileNotFoundError:  # a machine without git
        return None
    return result.stdout if result.returncode == 0 else None


def new_commits(source):
    """(hash, subject) of each commit of HEAD on none of the main branches; merges are left out. None without such a branch."""
    known = [branch for branch in MAIN if git(source, "rev-parse", "--verify", "--quiet", branch + "^{commit}")]
    if not known:
        return None
    log = git(source, "log", "--no-merges", "--format=%h %s", "HEAD", "--not", *known)
    return [line.split(" ", 1) if " " in line else (line, "") for line in (log or "").splitlines()]


def refuses_bad_ones():
    """The check itself: of these subjects the last four are refused."""
    good = ["net: decide in each stage whether a row of nodes floats", "core/net: x", "a: " + (LONGEST - 3) * "x"]
    bad = ["a: " + (LONGEST - 2) * "x", "mend the net", "net:mend it", ""]
    return not any(map(complaint, good)) and all(map(complaint, bad))


def main(source):
    if not refuses_bad_ones():
        print("check_commits.py does not refuse the subjects of its own example")
        return 1
    commits = new_commits(source)
    if commits is None:
        print(f"no branch {' or '.join(MAIN)} to compare with: no subject checked")
        return 0
    wrong = [f"{commit}: {complaint(subject)}: {subject}" for commit, subject in commits if complaint(subject)]
    print("\n".join(wrong) or f"{len(commits)} commits that are not on main, all subjects are `area: verb object`")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
