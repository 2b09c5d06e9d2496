#!/usr/bin/env python3
"""Looks at the main job's report in a real headless browser.

    pip install playwright                              # the driver; a browser comes with the system or playwright install chromium
    python tests/browser/check_report.py out/demo/report.html --screenshot page.png

The browser is that of the environment variable BROWSER_PATH, else chromium, chromium-browser, google-chrome or firefox of the
PATH, else playwright's own. Exit code 0: the report is whole; 1: something is wrong with it; 3: no browser, nothing was looked at.
"""

import argparse
import os
import pathlib
import shutil
import sys

NAMES = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "firefox"]

# What the page is made of, as the browser sees it.
LOOK = r"""() => {
  // What is folded belongs to it.
  document.querySelectorAll('details').forEach(part => { part.open = true; });
  return {
  images: [...document.images].map(i => ({alt: i.alt, complete: i.complete, width: i.naturalWidth, height: i.naturalHeight})),
  drawings: [...document.querySelectorAll('figure svg')].map(s => {
    const box = s.getBoundingClientRect();
    return {width: box.width, height: box.height, marks: s.querySelectorAll('path, polyline, polygon, rect, circle, line').length};
  }),
  formulas: [...document.querySelectorAll('math')].map(m => m.getBoundingClientRect().width),
  headings: [...document.querySelectorAll('h2')].map(h => h.innerText).filter(title => /^\d+\. /.test(title)),
  text: document.body.innerText,
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  };
}"""


def browser_of(playwright):
    """A headless browser, or None."""
    path = os.environ.get("BROWSER_PATH") or next(filter(None, map(shutil.which, NAMES)), None)
    kind = playwright.firefox if path and "firefox" in path else playwright.chromium
    try:
        arguments = ["--no-sandbox"] if kind is playwright.chromium else []
        return kind.launch(executable_path=path, args=arguments)
    except Exception as error:
        print(f"no browser: {error}", file=sys.stderr)
        return None


def complaints(page_path, screenshot):
    """What is wrong with the page; None if no browser could look at it."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = browser_of(playwright)
        if browser is None:
            return None
        page = browser.new_page(viewport={"width": 1000, "height": 900})
        wrong = []
        page.on("console", lambda m: m.type in ("error", "warning") and wrong.append(f"console: {m.text}"))
        page.on("pageerror", lambda e: wrong.append(f"script: {e}"))
        address = page_path.resolve().as_uri()

        def requested(request):
            if request.url != address and not request.url.startswith("data:"):
                wrong.append(f"request of {request.url}")

        page.on("request", requested)
        page.goto(address)
        page.wait_for_load_state("load")
        seen = page.evaluate(LOOK)
        wrong += [f"image without content: {i}" for i in seen["images"] if not (i["complete"] and i["width"] and i["height"])]
        wrong += [f"empty drawing: {d}" for d in seen["drawings"] if d["width"] < 100 or d["height"] < 50 or d["marks"] < 3]
        wrong += ["a formula has no width" for width in seen["formulas"] if width <= 0]
        if len(seen["headings"]) != 6:
            wrong.append(f"{len(seen['headings'])} chapters: {seen['headings']}")
        if len(seen["images"]) < 2 or len(seen["drawings"]) < 8 or len(seen["formulas"]) < 20:
            wrong.append(f"{len(seen['images'])} animations, {len(seen['drawings'])} figures, {len(seen['formulas'])} formulas")
        if len(seen["text"]) < 3000:
            wrong.append(f"only {len(seen['text'])} characters of text")
        if seen["overflow"] > 0:
            wrong.append(f"the page is {seen['overflow']} pixels wider than its window")
        if screenshot:
            page.screenshot(path=screenshot, full_page=True)
        counts = f"{len(seen['images'])} animations, {len(seen['drawings'])} figures, {len(seen['formulas'])} formulas"
        print(f"{page_path}: {counts}, {len(seen['text'])} characters of text, by {browser.browser_type.name} {browser.version}")
        browser.close()
        return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=pathlib.Path, nargs="?", default=pathlib.Path("out/demo/report.html"))
    parser.add_argument("--screenshot", help="PNG of the whole page")
    options = parser.parse_args()
    try:
        wrong = complaints(options.page, options.screenshot)
    except ImportError:
        print("no browser: playwright is not installed (pip install playwright)", file=sys.stderr)
        return 3
    if wrong is None:
        return 3
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
