#!/usr/bin/env python3
"""Lists the rings of Rust files that import each other, crate by crate. Exit code 1 where there are more than allowed.

usage: import_rings.py [ROOT] [--most N]

An arrow runs from a file to the file that declares a module it names in `use crate::…`, `use super::…` or in a path; a `pub use`
in a `lib.rs` or `mod.rs` is followed to the file behind it. Test modules are left out.
"""
import argparse
import pathlib
import re
import sys

PATH = re.compile(r"\b(crate|super(?:::super)*|self)((?:::\w+)+)")
USE = re.compile(r"\b(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);")


def tokens(text):
    """The text without comments, strings and inline test modules."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)
    text = re.sub(r'"(?:\\.|[^"\\])*"', '""', text)
    start = re.search(r"#\[cfg\(test\)\]\s*mod\s+\w+\s*\{", text)
    return text[: start.start()] if start else text


def expand(tree, prefix=()):
    """The paths of a use tree, `a::{b, c::d}` as (a, b), (a, c, d); the last of `x as y` is x."""
    tree = tree.strip()
    head, brace, rest = tree.partition("{")
    parts = tuple(p.strip() for p in head.split("::") if p.strip())
    if not brace:
        if parts:
            last = parts[-1].split(" as ")
            alias = last[1].strip() if len(last) > 1 else None
            yield prefix + parts[:-1] + (last[0].strip(),), alias
        return
    depth, entry = 0, ""
    for c in rest:
        if c == "}" and depth == 0:
            break
        depth += {"{": 1, "}": -1}.get(c, 0)
        if c == "," and depth == 0:
            yield from expand(entry, prefix + parts)
            entry = ""
        else:
            entry += c
    if entry.strip():
        yield from expand(entry, prefix + parts)


class Crate:
    """The modules of one crate and the arrows between their files."""

    def __init__(self, source):
        self.files, self.text = {}, {}
        for f in sorted(source.rglob("*.rs")):
            if re.search(r"(^|/)tests?(\.rs|/)", str(f.relative_to(source))) or f.name == "main.rs":
                continue
            parts = f.relative_to(source).with_suffix("").parts
            if parts[-1] in ("lib", "mod"):
                parts = parts[:-1]
            self.files[parts] = f
            self.text[parts] = tokens(f.read_text())
        self.exports = {}
        for module in self.files:
            for public, tree in USE.findall(self.text[module]):
                for path, alias in expand(tree):
                    if public:
                        self.exports.setdefault(module, []).append((alias or path[-1], self.absolute(module, path)))

    def absolute(self, module, path):
        """A path from the crate's root."""
        path = list(path)
        here = list(module)
        if path[0] == "crate":
            return tuple(path[1:])
        if path[0] == "self":
            return tuple(here + path[1:])
        if path[0] == "super":
            while path and path[0] == "super":
                here, path = here[:-1], path[1:]
            return tuple(here + path)
        return tuple(here + path)

    def owner(self, path, seen=()):
        """The module that defines what an absolute path names, through re-exports."""
        for k in range(len(path), -1, -1):
            module = tuple(path[:k])
            if module not in self.files:
                continue
            if k < len(path) and (module, path[k]) not in seen:
                for name, target in self.exports.get(module, []):
                    if name == path[k] and target != path:
                        found = self.owner(target + tuple(path[k + 1 :]), (*seen, (module, path[k])))
                        if found is not None:
                            return found
            return module
        return None

    def arrows(self, module):
        """The modules that a file imports."""
        named = set()
        text = self.text[module]
        for public, tree in USE.findall(text):
            if public and not public.startswith("pub("):
                continue  # Handing a child's names on is no import.
            for path, _ in expand(tree):
                if path[0] in ("crate", "super", "self"):
                    named.add(self.absolute(module, path))
                elif tuple([*module, path[0]]) in self.files:
                    named.add(tuple([*module, *path]))
        body = USE.sub("", text)
        for root, rest in PATH.findall(body):
            path = [p for p in (root + rest).split("::") if p]
            named.add(self.absolute(module, path))
        for child in re.findall(r"\b([a-z_0-9]+)::\w", body):
            if (*module, child) in self.files:
                named.add((*module, child))
        owners = {self.owner(path) for path in named}
        return {o for o in owners if o is not None and o != module}


def rings(graph):
    """Strongly connected components of more than one file (Tarjan)."""
    index, low, stack, out = {}, {}, [], []
    sys.setrecursionlimit(10_000)

    def visit(v):
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in graph[v]:
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            ring = []
            while True:
                ring.append(stack.pop())
                if ring[-1] == v:
                    break
            if len(ring) > 1:
                out.append(sorted(ring))

    for v in graph:
        if v not in index:
            visit(v)
    return out


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("root", nargs="?", default=".")
    arguments.add_argument("--most", type=int)
    options = arguments.parse_args()
    root = pathlib.Path(options.root)
    count = 0
    for folder in [root, *sorted((root / "crates").iterdir())]:
        if not (folder / "src").is_dir():
            continue
        crate = Crate(folder / "src")
        graph = {m: sorted(crate.arrows(m)) for m in crate.files}
        for ring in rings(graph):
            count += 1
            print(f"{folder.relative_to(root)}: {len(ring)} files")
            for module in ring:
                inside = ["::".join(w) or "lib" for w in graph[module] if w in ring]
                print(f"  {crate.files[module].relative_to(folder / 'src')} -> {', '.join(inside)}")
    print(f"{count} rings")
    sys.exit(options.most is not None and count > options.most)


main()
