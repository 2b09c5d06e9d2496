#!/usr/bin/env python3
"""Writes the licenses of all crates that a crate links, with their texts: `packaging/licenses.py bracketry-cli THIRDPARTY.txt`.

Equal texts are written once, below the names of all crates that have them.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent


def linked(metadata: dict, name: str) -> list[dict]:
    """The packages that the named one links, without those of the workspace."""
    packages = {p["id"]: p for p in metadata["packages"]}
    nodes = {n["id"]: n for n in metadata["resolve"]["nodes"]}
    todo = [i for i in metadata["workspace_members"] if packages[i]["name"] == name]
    found = set(todo)
    while todo:
        for dependency in nodes[todo.pop()]["deps"]:
            normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if normal and dependency["pkg"] not in found:
                found.add(dependency["pkg"])
                todo.append(dependency["pkg"])
    others = found - set(metadata["workspace_members"])
    return sorted((packages[i] for i in others), key=lambda p: (p["name"], p["version"]))


def texts(package: dict) -> list[str]:
    """The license files beside a manifest."""
    folder = pathlib.Path(package["manifest_path"]).parent
    names = ("licen", "copying", "notice", "unlicense")
    files = sorted(f for f in folder.iterdir() if f.is_file() and f.name.lower().startswith(names))
    return [f.read_text(encoding="utf-8", errors="replace").strip() for f in files]


if __name__ == "__main__":
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    packages = linked(metadata, sys.argv[1])
    if not packages:
        sys.exit(f"{sys.argv[1]}: no such crate, or it links no others")
    lines, of = [], {}
    for package in packages:
        lines.append(f"{package['name']} {package['version']}: {package['license'] or 'see the text'}")
        for text in texts(package):
            of.setdefault(text, []).append(f"{package['name']} {package['version']}")
    for text, names in of.items():
        lines.append(f"\n{'=' * 80}\n{', '.join(names)}\n{'=' * 80}\n\n{text}")
    pathlib.Path(sys.argv[2]).write_text("\n".join(lines) + "\n", encoding="utf-8")
