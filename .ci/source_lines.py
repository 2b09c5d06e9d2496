#!/usr/bin/env python3
"""Counts the lines of library source: Rust files under src folders, without blank lines, comments, documentation and tests.

usage: source_lines.py [ROOT]
"""
import pathlib
import re
import sys

TEST_FILE = re.compile(r"(^|/)(tests|test_\w+|\w+_tests)\.rs$|/tests/")


def code_lines(text):
    """Lines that hold code, without inline test modules."""
    lines, depth, skipping, pending = 0, 0, None, False
    in_comment = False
    for raw in text.splitlines():
        line = raw.strip()
        if in_comment:
            in_comment = "*/" not in line
            continue
        if not line or line.startswith("//"):
            continue
        if line.startswith("/*"):
            in_comment = "*/" not in line
            continue
        if skipping is None and line.startswith("#[cfg(test)]"):
            pending = True
            continue
        before = depth
        depth += line.count("{") - line.count("}")
        if pending:
            pending = False
            if line.startswith(("mod ", "pub mod ")) and depth > before:
                skipping = before
            continue
        if skipping is not None:
            if depth <= skipping:
                skipping = None
            continue
        lines += 1
    return lines


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    total = 0
    for crate in [root, *sorted((root / "crates").iterdir())]:
        source = crate / "src"
        if not source.is_dir():
            continue
        files = [f for f in sorted(source.rglob("*.rs")) if not TEST_FILE.search("/" + str(f.relative_to(crate)))]
        lines = sum(code_lines(f.read_text()) for f in files)
        total += lines
        print(f"{crate.relative_to(root) if crate != root else 'src'!s:24}{len(files):5} files{lines:8} lines")
    print(f"{'total':24}{'':11}{total:8} lines")


main()
