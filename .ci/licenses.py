#!/usr/bin/env python3
"""Holds the license of every dependency against the list in deny.toml: `python3 .ci/licenses.py`.

What `cargo deny check licenses` says of the declared licenses, without another program to install.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys
import tomllib

root = pathlib.Path(__file__).resolve().parent.parent
rules = tomllib.loads((root / "deny.toml").read_text())["licenses"]
exceptions = {e["crate"]: set(e["allow"]) for e in rules.get("exceptions", [])}


def admitted(expression, allowed):
    """Whether an SPDX expression can be met by allowed licenses alone."""
    # Before SPDX expressions, a slash meant OR.
    tokens = re.findall(r"[()]|[^\s()/]+|/", expression)
    tokens = ["OR" if t == "/" else t for t in tokens]
    at = 0

    def alternatives():
        nonlocal at
        value = together()
        while at < len(tokens) and tokens[at] == "OR":
            at += 1
            value = together() or value
        return value

    def together():
        nonlocal at
        value = single()
        while at < len(tokens) and tokens[at] == "AND":
            at += 1
            value = single() and value
        return value

    def single():
        nonlocal at
        if tokens[at] == "(":
            at += 1
            value = alternatives()
            at += 1
            return value
        name = tokens[at]
        at += 1
        if at < len(tokens) and tokens[at] == "WITH":
            name += " WITH " + tokens[at + 1]
            at += 2
        return name in allowed

    return alternatives()


metadata = json.loads(
    subprocess.run(
        ["cargo", "metadata", "--format-version", "1", "--locked"], cwd=root, check=True, capture_output=True
    ).stdout
)
counts = collections.Counter()
refused = []
for package in metadata["packages"]:
    license = package["license"] or "none stated"
    counts[license] += 1
    allowed = set(rules["allow"]) | exceptions.get(package["name"], set())
    if not package["license"] or not admitted(license, allowed):
        refused.append(f"{package['name']} {package['version']}: {license}")
for license, count in counts.most_common():
    print(f"{count:4} {license}")
print(f"{sum(counts.values()):4} packages, {len(refused)} refused")
for line in refused:
    print("refused:", line)
sys.exit(bool(refused))
