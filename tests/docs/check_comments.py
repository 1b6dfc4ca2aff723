#!/usr/bin/env python3
"""Counts the faults of comments and the old words of tests/docs/words.md; no file may have more than comment_counts.txt allows.

A file that is not listed there, such as a new or a moved one, may have none. The kinds of faults:
  opening   a comment begins with What, Where, Whether, It, That, These, Those, The same, Likewise, And or Of
  what      a comment block contains "what"
  speech    code speaks: says, tells, asks, knows, wants, lets go, takes hold, nobody, who; once for each such word
  inverted  a comment begins with "false:", so that the boolean has the name of its opposite
  sentence  a sentence has more than 25 words
  wide      a line with a comment is longer than 110 columns
  word      a comment, a name or a page of docs uses a word of the column "not" of the table in tests/docs/words.md

usage: check_comments.py SOURCE_DIR [--report | --list [PATH] | --update]
  --report  prints the counts of each folder
  --list    prints every fault with its place, of all files or of those whose path begins with PATH
  --update  lowers the allowed counts to today's; raises none. Without comment_counts.txt: writes today's
"""
import pathlib
import re
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import comment_blocks

KINDS = ("opening", "what", "speech", "inverted", "sentence", "wide", "word")
COUNTS = "tests/docs/comment_counts.txt"
TABLE = "tests/docs/words.md"
MAX_COLUMNS, MAX_WORDS = 110, 25
OPENING = re.compile(r"(What|Where|Whether|It|That|These|Those|The same|Likewise|And|Of)\b(?!\()")
SPEECH = re.compile(r"\b(say|says|said|tell|tells|told|ask|asks|asked|asking|know|knows|knew|want|wants|nobody|who|whom"
                    r"|lets? go|letting go|takes? hold|taken hold|took hold|taking hold)\b", re.I)
WORD = re.compile(r"[A-Za-z][A-Za-z'-]+|\ba\b", re.I)


def old_words(notation):
    """Pattern of the words in backquotes of the first column of the table "not | but"; None without such a table."""
    rows, inside = [], False
    for line in notation.splitlines():
        inside = line.startswith("| not ") or (inside and line.startswith("|"))
        if inside:
            rows += re.findall(r"`([^`]+)`", line.split("|")[1])
    return re.compile(r"\b(" + "|".join(map(re.escape, rows)) + r")\b", re.I) if rows else None


def sentences(text):
    """Sentences of a comment: ended by a full stop, a blank line, or a line with columns or an equation by itself."""
    return re.split(r"[.!?](?=\s|$)|\n\s*\n|\n(?= {2,})", text)


def faults(source, words):
    """(kind, line, text) of each fault in the text of a source file."""
    found = []
    for block in comment_blocks.blocks(source):
        flat = " ".join(block.text.split())
        if OPENING.match(flat):
            found.append(("opening", block.line, flat))
        if re.search(r"\bwhat\b", flat, re.I):
            found.append(("what", block.line, flat))
        found += [("speech", block.line, f"{match.group(0)}: {flat}") for match in SPEECH.finditer(flat)]
        if re.match(r"false:", flat):
            found.append(("inverted", block.line, flat))
        found += [("sentence", block.line, " ".join(sentence.split())) for sentence in sentences(block.text)
                  if len(WORD.findall(sentence)) > MAX_WORDS]
        if words:
            found += [("word", block.line, f"{match.group(0)}: {flat}") for match in words.finditer(flat)]
        for number, line in enumerate(source.splitlines()[block.line - 1:block.line + block.text.count("\n")], block.line):
            if len(line) > MAX_COLUMNS:
                found.append(("wide", number, line.strip()))
    if words:
        found += [("word", 0, f"name {name}") for name in comment_blocks.names(source)
                  if words.search(comment_blocks.as_words(name))]
    return found


def faults_of_tree(root):
    """Path -> faults, of all sources and of README.md and docs/**/*.md."""
    words = old_words((root / TABLE).read_text()) if (root / TABLE).exists() else None
    found = {str(path): faults(comment_blocks.read(root, path), words) for path in comment_blocks.sources(root)}
    for path in sorted(root.glob("docs/**/*.md")) + sorted(root.glob("README.md")):
        page = path.read_text()
        found[str(path.relative_to(root))] = [
            ("word", number, f"{match.group(0)}: {line.strip()}") for number, line in enumerate(page.splitlines(), 1)
            for match in (words.finditer(line) if words else ())]
    return found


def counts_of(found):
    return [sum(kind == fault[0] for fault in found) for kind in KINDS]


def read_counts(path):
    """Path -> allowed counts in the order of KINDS."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return {line[-1]: [int(number) for number in line[:-1]] for line in lines}


def write_counts(path, counts):
    path.write_text("# allowed faults of comments, see check_comments.py; only ever lowered, by --update\n"
                    "# " + " ".join(KINDS) + " path\n" + "".join(
                        " ".join(map(str, numbers)) + f" {name}\n" for name, numbers in sorted(counts.items())
                        if any(numbers)))


def above(counts, allowed):
    """(path, kind, count, allowed) wherever a count is above."""
    none = [0] * len(KINDS)
    return [(path, kind, count, limit) for path, numbers in counts.items()
            for kind, count, limit in zip(KINDS, numbers, allowed.get(path, none)) if count > limit]


def folder_of(path):
    parts = pathlib.PurePath(path).parts
    return "/".join(parts[:min(2, len(parts) - 1)]) or "."


def report(counts):
    folders = {}
    for path, numbers in counts.items():
        total = folders.setdefault(folder_of(path), [0] * len(KINDS))
        folders[folder_of(path)] = [a + b for a, b in zip(total, numbers)]
    folders["all"] = [sum(column) for column in zip(*folders.values())]
    print(f"{'':20}" + "".join(f"{kind:>10}" for kind in KINDS))
    for folder, numbers in folders.items():
        print(f"{folder:20}" + "".join(f"{number:10}" for number in numbers))


def finds_its_own_example():
    """The check itself: an example with each kind of fault, which must be found, and comments without any."""
    with tempfile.TemporaryDirectory() as made:
        root = pathlib.Path(made)
        for folder in ("core/a", "docs", "tests/docs"):
            (root / folder).mkdir(parents=True)
        (root / TABLE).write_text("| not | but |\n|---|---|\n| `settle`, `where flat` | resolve |\n")
        (root / "docs/page.md").write_text("Pages settle.\n")
        (root / "core/a/bad.h").write_text(
            "// Of two.\n"
            "int a;  // the mass, or what is left\n"
            "int b;  // as the node says\n"
            "bool c; // false: it is open\n"
            f"// The mass{' and a mass' * 6}\n// and a length{' and a length' * 3}.\n"
            f"int d;  // {'m' * 110}\n"
            "int where_flat;  // modes settle\n")
        (root / "core/a/good.h").write_text(
            '// Often. Mass, kg:\n//   m = rho V,\n//   a = f / m\nconst char* url = "http://what";  // Offset, m.\n' * 9)
        found = faults_of_tree(root)
        counts = {path: counts_of(faults) for path, faults in found.items()}
        expected = {"core/a/bad.h": [1, 1, 1, 1, 1, 1, 2], "core/a/good.h": [0] * 7, "docs/page.md": [0] * 6 + [1]}
        write_counts(root / COUNTS, counts)
        moved = {"core/b/bad.h": counts["core/a/bad.h"]}
        return (counts == expected and read_counts(root / COUNTS) == {k: v for k, v in counts.items() if any(v)}
                and not above(counts, counts) and len(above(moved, counts)) == len(KINDS)
                and lowered({"core/a/bad.h": [9, 0, 1, 1, 1, 1, 1], "core/b/new.h": [1] * 7}, counts)
                == {"core/a/bad.h": [1, 0, 1, 1, 1, 1, 1]})


def lowered(counts, allowed):
    """Allowed counts, none above today's and none above before."""
    return {path: [min(pair) for pair in zip(counts[path], numbers)] for path, numbers in allowed.items() if path in counts}


def main(root, option="", prefix=""):
    if not finds_its_own_example():
        print("check_comments.py does not find the faults of its own example")
        return 1
    found = faults_of_tree(root)
    counts = {path: counts_of(faults) for path, faults in found.items()}
    if option == "--report":
        report(counts)
    if option == "--list":
        print("\n".join(f"{path}:{line}: {kind}: {text}" for path, faults in found.items() if path.startswith(prefix)
                        for kind, line, text in faults))
    recorded = root / COUNTS
    allowed = read_counts(recorded) if recorded.exists() else counts if option == "--update" else {}
    if option == "--update":
        allowed = lowered(counts, allowed)
        write_counts(recorded, allowed)
    worse = above(counts, allowed)
    for path, kind, count, limit in worse:
        print(f"{path}: {count} of kind '{kind}', allowed {limit}; see check_comments.py SOURCE_DIR --list {path}")
    fewer = sum(map(sum, allowed.values())) - sum(map(sum, counts.values()))
    if fewer > 0 and not worse:
        print(f"{fewer} faults fewer than {COUNTS} allows: check_comments.py SOURCE_DIR --update keeps it so")
    print(f"{len(counts)} files, {len(worse)} counts above those allowed")
    return 1 if worse or not counts else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), *sys.argv[2:]))
