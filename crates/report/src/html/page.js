// A still image takes the place of an animation that is paused, which it is at first where less motion is preferred.
for (const button of document.querySelectorAll("figure button")) {
  const still = button.parentElement.querySelector("source");
  const set = (paused) => ([still.media, button.ariaPressed] = [paused ? "all" : "not all", paused]);
  set(matchMedia("(prefers-reduced-motion: reduce)").matches);
  button.hidden = false;
  button.addEventListener("click", () => set(button.ariaPressed !== "true"));
}
// Only what scrolls is a stop of the keyboard; the contents are folded where they stand above the text; paper shows all.
const fit = () => document.querySelectorAll(".wide, pre").forEach((box) => (box.tabIndex = box.scrollWidth > box.clientWidth ? 0 : -1));
if (matchMedia("(max-width: 69.99rem)").matches) document.querySelector("nav details").open = false;
addEventListener("beforeprint", () => document.querySelectorAll("main details").forEach((part) => (part.open = true)));
addEventListener("resize", fit);
document.addEventListener("toggle", fit, true);
fit();
