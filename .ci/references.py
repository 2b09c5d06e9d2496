#!/usr/bin/env python3
"""Checks that every citation of a document, record, model, or comment in `crates/*/src`, such as "Chow 1939", has an entry in docs/references.md: `python3 .ci/references.py`.

An entry is a line that starts with "- " and contains the names before the year, and the year. In comments, a year may also follow a title or a journal
("Chow, Mathematische Annalen 117, 1939"); the entry then has the year and its first author among the names. Exit code 1 with each citation that has none.
"""

import re
import subprocess
import sys
import unicodedata
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = "docs/references.md"
NAME = r"(?:(?:[Vv]an|[Dd]e|[Dd]er|Di) )*[A-ZÀ-Ž][\w’'-]*\w"
YEAR = r"(?:18|19|20)\d\d\b(?![-\d]|\.\d)"
# Names, the last possibly with "and others" or "'s condition", and years, the first possibly in parentheses.
CITATION = re.compile(rf"\b((?:{NAME}(?:, and |, | and | & |–))*{NAME})(?:['’]s(?: [a-z]+){{1,2}}| and others| et al\.)?,? \(?({YEAR}(?:(?:, | and ){YEAR})*)")
# A year that ends a title, or the volume of a journal.
DETACHED = re.compile(rf"(?:, |\()({YEAR})")
CODE = re.compile(r"`[^`]*`")
COMMENT = re.compile(r"(?:^|\s)//[/!]?(?:\s(.*))?$")


def plain(text: str) -> str:
    """The text without accents, in lower case."""
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c)).lower()


@cache
def entry_lines(entries: str) -> list[str]:
    """The entries of a list, plain."""
    return [plain(line) for line in entries.splitlines() if line.startswith("- ")]


def one_line(text: str) -> str:
    """The text without breaks; comments of a model file are read as one line."""
    return re.sub(r"\s+", " ", re.sub(r"\n# ?", " ", text))


def citations(text: str) -> list[tuple[tuple[str, ...], str]]:
    """Names and years that a text cites."""
    return [
        (tuple(re.sub(r"['’]s$", "", name) for name in re.findall(NAME, names)), year)
        for names, years in CITATION.findall(one_line(text))
        for year in re.findall(YEAR, years)
    ]


def comments(source: str) -> list[str]:
    """The comments of a Rust file with a year, those on consecutive lines as one, without code in backticks."""
    found, joined = [], False
    for line in source.splitlines():
        match = COMMENT.search(line)
        whole = bool(match) and line.lstrip().startswith("//")
        if match and whole and joined:
            found[-1] += "\n" + (match[1] or "")
        elif match:
            found.append(match[1] or "")
        joined = whole
    return [CODE.sub("`", comment) for comment in found if re.search(YEAR, comment)]


def detached(text: str) -> list[tuple[list[str], str]]:
    """Years that follow a title or a journal, with all names before them in the same parentheses."""
    line = one_line(text)
    attached = {m.start(2) + y.start() for m in CITATION.finditer(line) for y in re.finditer(YEAR, m[2])}
    found = []
    for match in DETACHED.finditer(line):
        names = re.findall(NAME, re.split(r"\(|; ", line[max(0, match.start() - 300) : match.start()])[-1])
        if match.start(1) not in attached and names:
            found.append((names, match[1]))
    return found


def has(line: str, word: str) -> bool:
    """Whether an entry has a name or year, as a word of its own."""
    return re.search(rf"(?<![\w–]){re.escape(plain(word))}(?![\w–])", line) is not None


def missing(text: str, entries: str) -> list[str]:
    """The citations of a text that no entry has."""
    lines = entry_lines(entries)
    found = {(names, year) for names, year in citations(text) if not any(all(has(line, word) for word in (*names, year)) for line in lines)}
    return [f"{', '.join(names)} {year}" for names, year in sorted(found)]


def missing_in_comments(source: str, entries: str) -> list[str]:
    """The citations in the comments of a Rust file that no entry has."""
    lines = entry_lines(entries)
    found = []
    for comment in comments(source):
        found += missing(comment, entries)
        for names, year in detached(comment):
            if not any(has(line, year) and any(has(re.split(r" and |, ", line)[0], name) for name in names) for line in lines):
                found.append(f"{names[0]} … {year}")
    return found


if __name__ == "__main__":
    listed = subprocess.run(["git", "ls-files", "README.md", "docs/*.md", "models/*.toml", "crates/*/src/*.rs"], cwd=ROOT, capture_output=True, text=True, check=True)
    entries = (ROOT / LIST).read_text(encoding="utf-8")
    found = [
        f"{name}: {citation} has no entry in {LIST}"
        for name in listed.stdout.splitlines() if name != LIST
        for citation in (missing_in_comments if name.endswith(".rs") else missing)((ROOT / name).read_text(encoding="utf-8"), entries)
    ]
    print("\n".join(found) or f"references: every citation has an entry in {LIST}")
    sys.exit(bool(found))
