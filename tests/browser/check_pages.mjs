#!/usr/bin/env node
// Makes the pages of the commands, and tries them in a headless Chromium by pointer and keyboard, in two widths, light and dark.
//
//     npm ci --prefix tests/browser
//     cargo build -p bracketry-cli --bin bracketry
//     node tests/browser/check_pages.mjs                      # the command of BRACKETRY_COMMAND, else target/debug/bracketry
//     node tests/browser/check_pages.mjs --demo out/demo      # also the page of a demo that has run
//     node tests/browser/check_pages.mjs --screenshots DIR    # pictures of all pages
//
// The browser is that of BROWSER_PATH, else /usr/bin/chromium. Exit code 0: nothing is wrong; 1: something is; it is printed.
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import { createRequire } from "node:module";
import os from "node:os";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

import { pagesOf } from "./pages.mjs";

const require = createRequire(import.meta.url);
const { chromium } = require("playwright-core");
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const root = path.join(path.dirname(fileURLToPath(import.meta.url)), "../..");
const option = (name) => (process.argv.includes(name) ? process.argv[process.argv.indexOf(name) + 1] : undefined);
const [demo, screenshots] = [option("--demo"), option("--screenshots")];
const target = process.env.CARGO_TARGET_DIR ?? path.join(root, "target");
const command = process.env.BRACKETRY_COMMAND ?? path.join(target, "debug/bracketry");
const executablePath = process.env.BROWSER_PATH ?? "/usr/bin/chromium";
const args = "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-component-update --disable-sync";

const SIZES = [1280, 400];
const HEIGHT = 800;
/** Largest difference of a value that is read from a figure, as a part of its axis: a pixel of the shortest panel, and rounding. */
const READ = 0.01;
let wrong = 0;
const complain = (where, what) => {
  wrong += 1;
  console.log(`${where}: ${what}`);
};

async function frame(page, where, width, hasFigures) {
  const seen = await page.evaluate(() => {
    const level = (h) => Number(h.tagName[1]);
    const headings = [...document.querySelectorAll("h1, h2, h3, h4, h5, h6")];
    const wide = [...document.querySelectorAll("nav a")].filter((a) => !document.getElementById(decodeURIComponent(a.hash.slice(1))));
    return {
      scroll: document.scrollingElement.scrollWidth - innerWidth,
      jumps: headings.filter((h, k) => (k ? level(h) > level(headings[k - 1]) + 1 : level(h) !== 1)).map((h) => h.textContent),
      lost: wide.map((a) => a.textContent),
      first: document.querySelector("figure")?.getBoundingClientRect().top + scrollY,
      links: [...document.querySelectorAll("main a")].map((a) => a.getAttribute("href")),
    };
  });
  if (seen.scroll > 0) complain(where, `the page is ${seen.scroll} pixels wider than its window`);
  if (seen.jumps.length) complain(where, `headings out of order: ${seen.jumps}`);
  if (seen.lost.length) complain(where, `contents without headings: ${seen.lost}`);
  if (width === SIZES[0] && hasFigures && !(seen.first < HEIGHT - 100)) complain(where, `the first figure begins at ${seen.first} pixels`);
  return seen;
}

async function contents(page, where) {
  const details = page.locator("nav details");
  if (!(await details.evaluate((d) => d.open))) await details.locator("summary").click();
  const links = await page.locator("nav a").all();
  for (const link of [links[0], links.at(-1)]) {
    await link.focus();
    await page.keyboard.press("Enter");
    const top = await page.evaluate(() => document.querySelector(":target")?.getBoundingClientRect().top);
    if (!(top >= 0 && top < HEIGHT)) complain(where, `a link of the contents leads to ${top}`);
  }
}

async function accessible(page, where) {
  await page.evaluate(() => document.querySelectorAll("main details").forEach((d) => (d.open = true)));
  await page.evaluate(axe);
  const found = await page.evaluate(() => globalThis.axe.run(document));
  for (const { id, impact, nodes } of found.violations) {
    const line = `${id} (${impact}), ${nodes.length} times, such as ${nodes[0].html.slice(0, 160)}`;
    if (impact === "serious" || impact === "critical") complain(where, line);
    else console.log(`${where}: note: ${line}`);
  }
}

const number = (text) => Number.parseFloat(text.replace("\u2212", "-"));
/** Names and values of a readout. */
const readout = async (plot) => {
  const output = plot.locator("output");
  if (!(await output.isVisible())) return null;
  const lines = (await output.textContent()).split("\n").map((line) => line.match(/^(.*): (.*)$/).slice(1));
  return lines.map(([name, value]) => [name, number(value)]);
};

function table(file) {
  const [header, ...rows] = fs.readFileSync(file, "utf8").trim().split("\n").map((line) => line.split(","));
  return { header, rows: rows.map((row) => row.map(Number)) };
}

/** Compares what a figure says with the table beside it; `columns` gives the name in the figure of some columns, which are drawn as lines,
 * and the factor to its unit. */
function compare(where, said, { file, columns }) {
  const { header, rows } = table(file);
  const [[, t]] = said;
  const next = rows.findIndex((row) => row[0] >= t);
  const [a, b] = [rows[Math.max(0, next - 1)], rows[next === -1 ? rows.length - 1 : next]];
  for (const [column, [name, factor]] of Object.entries(columns)) {
    const k = header.indexOf(column);
    const values = rows.map((row) => factor * row[k]);
    const expected = factor * (b[0] > a[0] ? a[k] + ((b[k] - a[k]) * (t - a[0])) / (b[0] - a[0]) : b[k]);
    const value = said.find(([known]) => known === name)?.[1];
    const range = Math.max(...values) - Math.min(...values);
    // The time is read to a pixel, too.
    const slope = b[0] > a[0] ? Math.abs((factor * (b[k] - a[k])) / (b[0] - a[0])) * 2e-3 * (rows.at(-1)[0] - rows[0][0]) : 0;
    if (!(Math.abs(value - expected) <= READ * range + slope)) complain(where, `${name} = ${value} at ${t}, but ${expected} in the table`);
  }
}

async function values(page, where, data) {
  const plot = page.locator(".plot").first();
  await plot.scrollIntoViewIfNeeded();
  if (await plot.locator("rect[pointer-events]").count()) return marks(page, where, plot);
  const panel = await plot.locator("g[data-box]").first().evaluate((g) => {
    // What the browser draws there, not what the page computes.
    const [seen, axis] = [g.getScreenCTM(), g.dataset.x.split(" ").map(Number)];
    const [left, top, right, bottom] = g.dataset.box.split(" ").map(Number);
    return { x: seen.e + left * seen.a, y: seen.f + top * seen.d, width: (right - left) * seen.a, height: (bottom - top) * seen.d, axis };
  });
  const inside = Math.min(panel.x + 0.37 * panel.width, page.viewportSize().width - 40);
  await page.mouse.move(inside, panel.y + panel.height / 2);
  const pointed = await readout(plot);
  if (!pointed || pointed.length < 2 || pointed.some(([, v]) => !Number.isFinite(v))) complain(where, `the pointer shows ${pointed}`);
  else if (data) compare(`${where}, by pointer`, pointed, data);
  const expected = panel.axis[0] + ((inside - panel.x) / panel.width) * (panel.axis[1] - panel.axis[0]);
  if (!(Math.abs(pointed?.[0][1] - expected) <= 2e-3 * (panel.axis[1] - panel.axis[0]))) complain(where, `${pointed?.[0]} where the pointer is at ${expected}`);
  const box = await plot.locator("output").boundingBox();
  if (!(box && box.x >= 0 && box.x + box.width <= page.viewportSize().width)) complain(where, `the values stand at ${JSON.stringify(box)}`);
  await page.mouse.move(1, 1);
  if (await readout(plot)) complain(where, "the value stays when the pointer is gone");
  await plot.focus();
  for (const key of ["Home", "Shift+ArrowRight", "Shift+ArrowRight", "Shift+ArrowRight", "ArrowRight"]) await page.keyboard.press(key);
  const typed = await readout(plot);
  if (!typed || typed.length < 2 || typed.some(([, v]) => !Number.isFinite(v))) complain(where, `the keyboard shows ${typed}`);
  else if (data) compare(`${where}, by keyboard`, typed, data);
  await page.keyboard.press("Escape");
  if (await readout(plot)) complain(where, "Escape leaves the value");
  console.log(`${where}: ${pointed?.length} values by pointer, ${typed?.length} by keyboard`);
}

/** A figure of bars or tiles says what is under the pointer, and steps through them by keyboard. */
async function marks(page, where, plot) {
  // The first line; in a map its place follows.
  const said = async () => ((await plot.locator("output").isVisible()) ? (await plot.locator("output").textContent()).split("\n")[0] : null);
  const all = await plot.locator("rect[pointer-events]").all();
  const titles = await Promise.all(all.map((mark) => mark.textContent()));
  const place = await all[0].boundingBox();
  await page.mouse.move(place.x + place.width / 2, place.y + place.height / 2);
  if ((await said()) !== titles[0]) complain(where, `the pointer shows ${await said()} in place of ${titles[0]}`);
  await page.mouse.move(1, 1);
  await plot.focus();
  for (const k of [0, 1]) {
    await page.keyboard.press("ArrowRight");
    if ((await said()) !== titles[k]) complain(where, `the keyboard shows ${await said()} in place of ${titles[k]}`);
  }
  await page.keyboard.press("Escape");
  console.log(`${where}: ${titles.length} values in the first figure`);
}

/** Every figure shows something by keyboard. */
async function allFigures(page, where) {
  for (const plot of await page.locator(".plot").all()) {
    await plot.focus();
    await page.keyboard.press("ArrowRight");
    if (!(await plot.locator("output").isVisible())) complain(where, `no value in ${await plot.getAttribute("aria-label")}`);
    await page.keyboard.press("Escape");
  }
}

async function animations(page, where, isCalm) {
  for (const button of await page.locator("figure button").all()) {
    const shown = () => button.evaluate((b) => b.parentElement.querySelector("img").currentSrc.slice(0, 14));
    const pressed = () => button.getAttribute("aria-pressed");
    const expect = async (paused, what) => {
      await page.waitForTimeout(50);
      const [source, state] = [await shown(), await pressed()];
      if (source !== (paused ? "data:image/png" : "data:image/gif") || state !== String(paused)) complain(where, `${what}: ${source}, pressed ${state}`);
    };
    await button.scrollIntoViewIfNeeded();
    await expect(isCalm, "at first");
    await button.click();
    await expect(!isCalm, "after a click");
    await button.focus();
    await page.keyboard.press("Space");
    await expect(isCalm, "after the space key");
  }
}

const out = fs.mkdtempSync(path.join(os.tmpdir(), "bracketry-pages-"));
const profile = fs.mkdtempSync(path.join(os.tmpdir(), "bracketry-profile-"));
const pages = pagesOf(root, out, (list, codes = [0]) => {
  try {
    execFileSync(command, list, { cwd: out, stdio: ["ignore", "ignore", "pipe"] });
  } catch (error) {
    if (!codes.includes(error.status)) throw error;
  }
});
if (demo) pages.push({ name: "demo", file: path.resolve(demo, "report.html") });
const context = await chromium.launchPersistentContext(profile, { executablePath, headless: true, args: args.split(" ") });
for (const { name, file, data, hasFigures = true } of pages) {
  for (const width of SIZES)
    for (const scheme of ["light", "dark"]) {
      const where = `${name}, ${width} pixels, ${scheme}`;
      const page = await context.newPage();
      page.on("pageerror", (error) => complain(where, `script: ${error.message}`));
      page.on("console", (message) => ["error", "warning"].includes(message.type()) && complain(where, `console: ${message.text()}`));
      const address = pathToFileURL(file).href;
      page.on("request", (request) => request.url() === address || request.url().startsWith("data:") || complain(where, `request of ${request.url()}`));
      await page.setViewportSize({ width, height: HEIGHT });
      const isCalm = scheme === "dark";
      await page.emulateMedia({ colorScheme: scheme, reducedMotion: isCalm ? "reduce" : "no-preference" });
      await page.goto(address);
      const seen = await frame(page, where, width, hasFigures);
      for (const link of seen.links) if (!fs.existsSync(path.join(path.dirname(file), link))) complain(where, `no file ${link}`);
      if (screenshots) await page.screenshot({ path: path.join(screenshots, `${name}_${width}_${scheme}.png`) });
      if (hasFigures) await values(page, where, data);
      await contents(page, where);
      await accessible(page, where);
      if (screenshots) await page.screenshot({ path: path.join(screenshots, `${name}_${width}_${scheme}_whole.png`), fullPage: true });
      if ((await frame(page, `${where}, unfolded`, 0)).scroll > 0) complain(where, "too wide where unfolded");
      await allFigures(page, where);
      await animations(page, where, isCalm);
      await page.close();
    }
}
await context.close();
for (const dir of [out, profile]) fs.rmSync(dir, { recursive: true, force: true });
console.log(wrong ? `${wrong} faults` : `${pages.length} pages: nothing is wrong`);
process.exit(wrong ? 1 : 0);
