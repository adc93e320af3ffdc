// A proof as a tree of sentences: arrow keys open, close and walk it; what is selected lights up in the picture.
import { metres } from "./data.js";
import { element } from "./element.js";

/** What a step says, whatever it rests on. */
const named = (step) => JSON.stringify([step.predicate, step.args]);

export class Tree {
  constructor(host, choose) {
    this.host = host;
    this.choose = choose;
    this.closed = new Set();
    host.addEventListener("click", (event) => {
      const item = event.target.closest("[role=treeitem]");
      if (!item) return;
      if (event.target.closest(".twist")) this.toggle(item);
      else this.choose(item.dataset.path);
    });
    host.addEventListener("keydown", (event) => this.key(event));
  }

  /** Show the proof of a relation; `path` tells which step is selected, as 0.2 for the third below the first. */
  show(root, path, reasons, all, noise) {
    let focused = false;
    if (this.root !== root || this.all !== all) {
      // The same conclusion drawn anew: what was folded stays so, and who was there is there again.
      const again = Boolean(this.root) && this.all === all && named(this.root) === named(root);
      const folded = again ? [...this.host.querySelectorAll('[aria-expanded="false"]')].map((one) => one.dataset.path) : [];
      const scrolled = again ? this.host.scrollTop : 0;
      focused = again && this.host.contains(document.activeElement);
      this.root = root;
      this.all = all;
      this.reasons = reasons;
      this.noise = noise;
      this.closed.clear();
      this.host.replaceChildren(this.item(root, "", 1));
      for (const item of this.host.querySelectorAll("[aria-expanded]")) if (folded.includes(item.dataset.path)) this.toggle(item, false);
      this.host.scrollTop = scrolled;
    }
    for (const item of this.host.querySelectorAll("[role=treeitem]")) {
      const selected = item.dataset.path === path;
      item.setAttribute("aria-selected", String(selected));
      item.tabIndex = selected ? 0 : -1;
      if (selected && focused) item.focus({ preventScroll: true });
    }
  }

  empty(text) {
    this.root = null;
    this.host.replaceChildren(element("p.empty", {}, text));
  }

  /** The step at a path; null where there is none. */
  static at(root, path, reasons, all) {
    let step = root;
    for (const number of path ? path.split(".") : []) {
      step = reasons.below(step, all)[Number(number)];
      if (!step) return null;
    }
    return step;
  }

  item(step, path, level) {
    const below = this.reasons.below(step, this.all);
    const unsure = step.margin !== null && Math.abs(step.margin) < this.noise;
    const item = element("div.step", { role: "treeitem", "aria-level": level, "data-path": path });
    const line = element("div.line");
    line.append(element(below.length ? "span.twist" : "span.dot", { "aria-hidden": "true" }));
    const words = element("span.words", {}, step.text);
    if (step.axiom !== null && step.kind === "rule") words.append(" ", element("span.tag", {}, `axiom ${step.axiom}`));
    if (unsure) words.append(" ", element("span.tag.unsure", {}, `uncertain, ${metres(step.margin)}`));
    line.append(words);
    item.append(line);
    if (below.length) {
      item.setAttribute("aria-expanded", "true");
      const group = element("div.group", { role: "group" });
      if (step.kind === "negation") group.append(element("p.near", {}, "what comes closest to refuting it:"));
      group.append(...below.map((one, at) => this.item(one, path === "" ? `${at}` : `${path}.${at}`, level + 1)));
      item.append(group);
    }
    return item;
  }

  toggle(item, open = item.getAttribute("aria-expanded") === "false") {
    if (item.hasAttribute("aria-expanded")) item.setAttribute("aria-expanded", String(open));
  }

  key(event) {
    const item = event.target.closest("[role=treeitem]");
    if (!item) return;
    const seen = [...this.host.querySelectorAll("[role=treeitem]")].filter(
      (one) => !one.parentElement.closest('[aria-expanded="false"]'),
    );
    const at = seen.indexOf(item);
    const open = item.getAttribute("aria-expanded");
    let to = null;
    if (event.key === "ArrowDown") to = seen[at + 1];
    else if (event.key === "ArrowUp") to = seen[at - 1];
    else if (event.key === "Home") to = seen[0];
    else if (event.key === "End") to = seen.at(-1);
    else if (event.key === "ArrowRight" && open === "false") this.toggle(item, true);
    else if (event.key === "ArrowRight") to = open ? seen[at + 1] : null;
    else if (event.key === "ArrowLeft" && open === "true") this.toggle(item, false);
    else if (event.key === "ArrowLeft") to = item.parentElement.closest("[role=treeitem]");
    else if (event.key === "Enter" || event.key === " ") to = item;
    else return;
    event.preventDefault();
    event.stopPropagation();
    if (!to) return;
    this.choose(to.dataset.path);
    this.host.querySelector('[aria-selected="true"]')?.focus();
  }
}
