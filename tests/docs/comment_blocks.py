"""Comments and names of the sources of this project, for the checks beside this file."""
import dataclasses
import pathlib
import re

LAYERS = ("core", "hal", "sim", "platform", "tests")
SOURCES = {".h", ".cc", ".js"}
TOKEN = re.compile(r'(?P<line>//[^\n]*)|(?P<block>/\*.*?\*/)'
                   r'|R"(?P<tag>\w*)\(.*?\)(?P=tag)"|"(?:\\.|[^"\\\n])*"|`(?:\\.|[^`\\])*`'
                   r"|'(?:\\.|[^'\\\n])+'|\d[\w.']*|(?P<name>[A-Za-z_]\w*)", re.S)


@dataclasses.dataclass
class Block:
    """Comment of one or several lines. line: number of its first line, from 1."""
    line: int
    text: str


def sources(root):
    """Source files of all layers, sorted, relative to root."""
    return [path.relative_to(root) for layer in LAYERS for path in sorted((root / layer).rglob("*"))
            if path.suffix in SOURCES]


def blocks(text):
    """Comment blocks of a source: neighbouring lines whose comments begin in the same column are one block."""
    found, last = [], None  # last: (line, column, marker) of the comment before
    for token in TOKEN.finditer(text):
        comment = token.group("line") or token.group("block")
        if not comment:
            continue
        line = text.count("\n", 0, token.start()) + 1
        start = text.rfind("\n", 0, token.start()) + 1
        column, alone = token.start() - start, not text[start:token.start()].strip()
        marker = re.match(r"/+\*?<?", comment).group(0)
        words = re.sub(r"^\s*/*\**<? ?", "", comment.removesuffix("*/"))
        if alone and last == (line - 1, column, marker):
            found[-1].text += "\n" + words
        else:
            found.append(Block(line, words))
        last = (line, column, marker)
    return found


def names(text):
    """Identifiers of a source's code, each as often as it stands there."""
    return [token.group("name") for token in TOKEN.finditer(text) if token.group("name")]


def as_words(name):
    """An identifier as lower-case words: as_words("BegunContactOf") is "begun contact of"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_+", " ", name).strip().lower()


def read(root, path):
    return (pathlib.Path(root) / path).read_text()
