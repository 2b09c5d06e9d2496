"use strict";
// Values of figures under the pointer and by arrow keys, from what the figures say of themselves (crates/plot/src/reading.rs).
const numbers = (text) => text.trim().split(/[ ,]+/).map(Number);
const written = (value, range) => {
  const digits = Math.ceil(3 - Math.log10(range || 1));
  const text = digits < 0 || digits > 6 ? value.toPrecision(4) : value.toFixed(digits);
  return text.replace(/-/g, "\u2212");
};
// "x [m]" as name and unit; a number alone has the unit 1.
const parts = (title) => {
  const [, name, unit] = title.match(/^(.*?)\s*(?:\[([^\]]*)\])?$/);
  return [name, !unit || unit === "1" ? "" : unit === "°" ? unit : " " + unit];
};
// The point of a curve at x: on a line, of several the one nearest to y, else the last; of a cloud the nearest.
const at = (curve, x, y) => {
  let found = null;
  for (const points of curve.lines)
    for (let k = 2; k < points.length; k += 2) {
      const [a, b, c, d] = points.slice(k - 2, k + 2);
      if (x < Math.min(a, c) || x > Math.max(a, c)) continue;
      const value = a === c ? d : b + ((d - b) * (x - a)) / (c - a);
      if (!found || y === undefined || Math.abs(value - y) < Math.abs(found[1] - y)) found = [x, value];
    }
  const far = ([u, v]) => Math.hypot(u - x, y === undefined ? 0 : v - y);
  return curve.dots.reduce((best, dot) => (best && far(best) <= far(dot) ? best : dot), found);
};
const panelsOf = (svg) =>
  [...svg.querySelectorAll("g[data-box]")].map((g) => {
    const curves = new Map();
    for (const element of svg.querySelectorAll(`[data-curve][data-panel="${g.dataset.panel}"]`)) {
      const { curve, name, shift, points } = element.dataset;
      const known = curves.get(curve) || { name, lines: [], dots: [] };
      const list = numbers(points || element.getAttribute("points")).map((v, k) => (k % 2 ? v : v - (shift || 0)));
      if (points) for (let k = 0; k < list.length; k += 2) known.dots.push(list.slice(k, k + 2));
      else known.lines.push(list);
      curves.set(curve, known);
    }
    const { box, x, y, title, xTitle } = g.dataset;
    return { box: numbers(box), x: numbers(x), y: numbers(y), title: parts(title), xTitle: parts(xTitle), curves: [...curves.values()] };
  });
for (const plot of document.querySelectorAll(".plot")) {
  const svg = plot.querySelector("svg");
  const marks = [...svg.querySelectorAll("rect[pointer-events]")];
  const [panels, view] = [panelsOf(svg), svg.viewBox.baseVal];
  const output = plot.appendChild(document.createElement("output"));
  const cursor = svg.appendChild(document.createElementNS(svg.namespaceURI, "path"));
  cursor.setAttribute("class", "cursor");
  let [step, place] = [0, -1];
  const hide = () => ([output.hidden, cursor.style.display] = [true, "none"]);
  hide();
  const show = (lines, path, x, y) => {
    [output.hidden, cursor.style.display, output.textContent, output.style.left] = [false, "", lines.join("\n"), 0];
    cursor.setAttribute("d", path);
    const [seen, frame] = [svg.getScreenCTM(), plot.getBoundingClientRect()];
    const [across, down] = [x * seen.a + seen.e - frame.left + plot.scrollLeft, y * seen.d + seen.f - frame.top];
    if (across < plot.scrollLeft || across > plot.scrollLeft + plot.clientWidth) plot.scrollLeft = across - plot.clientWidth / 2;
    // Beside the cursor, in what is seen of the figure.
    const beside = across + (x > view.width / 2 ? -12 - output.offsetWidth : 12);
    const last = plot.scrollLeft + plot.clientWidth - output.offsetWidth;
    output.style.left = Math.max(plot.scrollLeft, Math.min(beside, last)) + "px";
    output.style.top = Math.max(0, Math.min(down + 8, svg.clientHeight - output.offsetHeight)) + "px";
  };
  const across = (p, u) => p.x[0] + ((u - p.box[0]) / (p.box[2] - p.box[0])) * (p.x[1] - p.x[0]);
  const up = (p, v) => p.y[0] + ((p.box[3] - v) / (p.box[3] - p.box[1])) * (p.y[1] - p.y[0]);
  const say = ([name, unit], value, [low, high]) => `${name}: ${written(value, high - low)}${unit}`;
  const panelAt = (x, y) => panels.find(({ box }) => box[0] <= x && x <= box[2] && box[1] <= y && y <= box[3]);
  // What a mark says, in a map with its place.
  const showMark = (mark, x, y) => {
    const box = mark.getBBox();
    [x, y] = [x ?? box.x + box.width / 2, y ?? box.y + box.height / 2];
    const panel = panelAt(x, y);
    const place = panel ? [say(panel.xTitle, across(panel, x), panel.x), say(panel.title, up(panel, y), panel.y)] : [];
    show([mark.textContent, ...place], `M${box.x} ${box.y}h${box.width}v${box.height}h${-box.width}z`, x, y);
  };
  // Panels above each other have the same horizontal axis.
  const showAt = (panel, x, y) => {
    const lines = [say(panel.xTitle, across(panel, x), panel.x)];
    let path = "";
    for (const p of panels.filter((p) => p.box[0] === panel.box[0] && p.xTitle[0] === panel.xTitle[0])) {
      path += `M${x} ${p.box[1]}V${p.box[3]}`;
      for (const curve of p.curves) {
        const found = at(curve, x, p === panel ? y : undefined);
        const name = panels.length === 1 && curve.name ? curve.name : [p.title[0], curve.name].filter(Boolean).join(", ");
        const place = found && found[0] !== x ? `, at ${written(across(p, found[0]), p.x[1] - p.x[0])}${p.xTitle[1]}` : "";
        if (found) lines.push(say([name, p.title[1]], up(p, found[1]), p.y) + place);
      }
      if (!p.curves.length && p === panel) lines.push(say(p.title, up(p, y ?? (p.box[1] + p.box[3]) / 2), p.y));
    }
    show(lines, path, x, y ?? panel.box[1]);
  };
  const point = (event) => {
    const seen = svg.getScreenCTM();
    const [x, y] = [(event.clientX - seen.e) / seen.a, (event.clientY - seen.f) / seen.d];
    if (marks.includes(event.target)) return showMark(event.target, x, y);
    const panel = panelAt(x, y);
    if (!panel) return hide();
    step = (x - panel.box[0]) / (panel.box[2] - panel.box[0]);
    showAt(panel, x, y);
  };
  for (const kind of ["pointermove", "pointerdown"]) plot.addEventListener(kind, point);
  for (const kind of ["pointerleave", "blur"]) plot.addEventListener(kind, hide);
  plot.addEventListener("keydown", (event) => {
    const move = { ArrowLeft: -1, ArrowRight: 1, Home: -Infinity, End: Infinity }[event.key];
    if (event.key === "Escape") hide();
    if (move === undefined || !(marks.length || panels.length)) return;
    event.preventDefault();
    if (marks.length) return showMark(marks[(place = Math.max(0, Math.min(marks.length - 1, place + move)))]);
    step = Math.max(0, Math.min(1, step + (move * (event.shiftKey ? 10 : 1)) / 100));
    showAt(panels[0], panels[0].box[0] + step * (panels[0].box[2] - panels[0].box[0]));
  });
}
