// The page: reads its data, makes the parts, and lets each follow what is selected in the others.
import { Reasons, metres, read, understood } from "./data.js";
import { News, compared } from "./news.js";
import { follow } from "./follow.js";
import { element } from "./element.js";
import * as evidence from "./evidence.js";
import { Graph } from "./graph.js";
import { List } from "./list.js";
import { marksOf } from "./marks.js";
import { coloursOf, relationColour, themeOf, whenOutsideChanges } from "./palette.js";
import { Picture } from "./picture.js";
import { Store, listed, restored, written } from "./state.js";
import { Tree } from "./tree.js";

const at = (id) => document.getElementById(id);

/** A row of the list; what holds only since a moment ago is marked. */
function described(relation, fresh) {
  const swatch = element("span.swatch");
  swatch.style.borderTopColor = relationColour(relation.predicate);
  const more = element("span.more", {}, swatch, relation.predicate.replaceAll("_", " "));
  if (relation.margin !== null) more.append(element("span", {}, `${metres(relation.margin)} to spare`));
  if (relation.unsure) more.append(element("span.tag.unsure", {}, "uncertain"));
  const row = element(`div.row${relation.unsure ? ".doubtful" : ""}${fresh ? ".fresh" : ""}`, { title: relation.text });
  row.append(element("span.says", {}, relation.text), more);
  return row;
}

/** A picture, or null where the browser has no WebGL: then the page says so, and the rest works. */
function pictureOf(model, pick) {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (probe) {
    probe.getExtension("WEBGL_lose_context")?.loseContext();
    return new Picture(at("picture"), model, pick);
  }
  at("picture").prepend(element("p.empty", {}, "This browser draws no WebGL: the picture is left out."));
  return null;
}

/** Let a list offer these texts and values; it is left alone where it does already. */
function offer(select, choices) {
  const known = [...select.options].map((one) => [one.text, one.value]);
  const wanted = choices.map(([text, value]) => [text, String(value)]);
  if (JSON.stringify(known) !== JSON.stringify(wanted)) select.replaceChildren(...wanted.map((one) => new Option(...one)));
}

class Page {
  constructor(model) {
    this.model = model;
    this.reasons = null;
    this.store = new Store();
    this.rows = [];
    this.picture = pictureOf(model, (thing) => this.select({ thing }));
    this.fresh = new Set();
    this.list = new List(
      at("rows"), (relation) => this.select({ relation: relation.index }), (one) => described(one, this.fresh.has(one.index)),
    );
    this.tree = new Tree(at("tree"), (path) => this.store.set({ path }));
    this.graph = new Graph(at("canvas"), at("drawn"), model, (what) => this.select(what));
    this.news = new News(at("news"), () => this.mint(new Set()));
    this.fill();
    this.controls();
    this.store.watch((now, before) => this.follow(now, before));
  }

  /** Select a thing or a relation; what hung on the one before goes. */
  select(what) {
    if ("relation" in what) this.store.set({ relation: what.relation, path: "" });
    else this.store.set({ thing: what.thing, relation: null, path: "" });
  }

  /** Say what there is to choose from. */
  fill() {
    const { model } = this;
    at("title").textContent = model.scene;
    const unsure = model.relations.filter((one) => one.unsure).length;
    at("summary").textContent = `${model.things.length} things, ${model.relations.length} relations, ${unsure} of them uncertain (within ${metres(model.thresholds.pose_noise)})`;
    offer(at("view"), model.views.map((one) => [one.name, one.index]));
    at("view").disabled = at("look").disabled = model.views.length === 0;
    const things = [...model.things].sort((a, b) => a.name.localeCompare(b.name));
    offer(at("thing"), [["all", ""], ...things.map((one) => [one.name, one.index])]);
    offer(at("only"), [["every kind", ""], ...model.predicates.map((one) => [one.replaceAll("_", " "), one])]);
  }

  controls() {
    const { store } = this;
    at("view").addEventListener("change", (event) => this.see(Number(event.target.value)));
    at("thing").addEventListener("change", ({ target }) => this.select({ thing: target.value === "" ? null : Number(target.value) }));
    at("only").addEventListener("change", (event) => store.set({ only: event.target.value }));
    at("search").addEventListener("input", (event) => store.set({ search: event.target.value }));
    for (const name of ["unsure", "all"]) at(name).addEventListener("change", (event) => store.set({ [name]: event.target.checked, ...(name === "all" ? { path: "" } : {}) }));
    for (const name of ["turned", "spaces"]) at(name).addEventListener("click", () => store.set({ [name]: !store.now[name] }));
    at("look").addEventListener("click", () => this.picture?.lookFrom());
    at("closer").addEventListener("click", () => this.picture?.closer());
    at("overview").addEventListener("click", () => this.picture?.overview());
    at("theme").addEventListener("click", () => store.set({ theme: themeOf(store.now) === "dark" ? "light" : "dark" }));
    at("about").addEventListener("click", () => at("licences").showModal());
    for (const tab of document.querySelectorAll(".tabs button")) tab.addEventListener("click", () => this.panel(tab.dataset.to));
    document.addEventListener("keydown", (event) => this.key(event));
    whenOutsideChanges(() => this.paint());
  }

  key(event) {
    if (at("licences").open) return;
    const { now } = this.store;
    if (event.key === "Escape") {
      if (now.path) this.store.set({ path: "" });
      else if (now.relation !== null) this.store.set({ relation: null });
      else this.store.set({ thing: null, search: "", only: "", unsure: false });
    } else if (event.key === "/" && !/^(INPUT|SELECT)$/.test(event.target.tagName)) {
      at("search").focus();
    } else return;
    event.preventDefault();
  }

  panel(name) {
    document.body.dataset.panel = name;
    for (const tab of document.querySelectorAll(".tabs button")) tab.setAttribute("aria-pressed", String(tab.dataset.to === name));
  }

  /** Look from another view: a relation of the view before has no place in it. */
  see(view) {
    const { relation } = this.store.now;
    const kept = relation !== null && this.model.relations[relation].view === null;
    this.store.set({ view, ...(kept ? {} : { relation: null, path: "" }) });
  }

  paint() {
    document.documentElement.dataset.theme = themeOf(this.store.now);
    at("theme").textContent = themeOf(this.store.now) === "dark" ? "Light" : "Dark";
    const colours = coloursOf(this.store.now);
    this.picture?.build(colours, this.reasons?.tables.shapes);
    this.graph.paint(colours);
  }

  /** Let every part follow the state; `still` leaves lists and graph where they are scrolled to. */
  follow(now, before, still = false) {
    const changed = (...names) => before === null || names.some((name) => now[name] !== before[name]);
    if (changed("theme")) this.paint();
    if (changed("theme", "view")) this.picture?.stand(now.view);
    if (changed("thing", "view", "only", "search", "unsure")) {
      this.rows = listed(now, this.model);
      at("count").textContent = this.rows.length === this.model.relations.length ? `${this.rows.length}` : `${this.rows.length} of ${this.model.relations.length}`;
      this.graph.show(this.rows, now.thing, still);
    }
    this.list.show(this.rows, now.relation === null ? null : this.model.relations[now.relation], still);
    const step = this.explain(now);
    const marks = marksOf(now, step, this.model, this.reasons);
    this.picture?.light(marks);
    this.graph.mark(now.relation, marks);
    this.hint(now, marks, step);
    for (const name of ["view", "only", "search"]) if (at(name).value !== String(now[name])) at(name).value = now[name];
    at("thing").value = now.thing ?? "";
    for (const name of ["unsure", "all"]) at(name).checked = now[name];
    for (const name of ["turned", "spaces"]) at(name).setAttribute("aria-pressed", String(now[name]));
    this.address(now);
  }

  /** Show the explanation of what is selected; return the step that is. */
  explain(now) {
    if (now.relation === null || !this.reasons) {
      const thing = now.thing === null ? null : this.model.things[now.thing];
      this.tree.empty(thing ? `${this.rows.length} relations of the ${thing.name}: select one to see why it holds.` : "Select a relation to see why it holds, or a thing to see its relations.");
      at("evidence").replaceChildren(...(thing ? [evidence.ofThing(thing, this.model, now, this.reasons?.tables.shapes[thing.index])] : []));
      return null;
    }
    const root = this.reasons.step(this.model.relations[now.relation].step);
    this.tree.show(root, now.path, this.reasons, now.all, this.model.thresholds.pose_noise);
    const step = Tree.at(root, now.path, this.reasons, now.all) ?? root;
    at("evidence").replaceChildren(evidence.ofStep(step, this.model));
    return step;
  }

  hint(now, marks, step) {
    const said = [];
    if (step) said.push(step.text);
    for (const role of ["figure", "reference"]) {
      if (marks[role] !== null) said.push(element(`span.${role}`, {}, this.model.things[marks[role]].name));
    }
    at("hint").replaceChildren(...said.flatMap((one, number) => (number ? [" · ", one] : [one])));
  }

  /** Keep the state in the address; a page inside another's text has none. */
  address(now) {
    if (!this.reasons || location.protocol === "about:") return;
    const fragment = written(now, this.model, this.reasons);
    if (fragment !== location.hash.slice(1)) history.replaceState(null, "", fragment ? `#${fragment}` : location.pathname + location.search);
  }

  restore() {
    this.store.now = restored(location.hash.slice(1), this.model, this.reasons);
    this.follow(this.store.now, null);
  }

  /** Take over what holds now; what is selected and seen stays so as far as it is still there. */
  take(model, reasons) {
    const [before, known] = [this.model, this.reasons];
    const kept = written(this.store.now, before, known);
    const found = compared([before, known], [model, reasons], before.views[this.store.now.view]?.id);
    [this.model, this.reasons, this.graph.model] = [model, reasons, model];
    this.fill();
    this.picture?.take(model);
    this.mint(new Set(found.gained.map((one) => one.index)));
    const now = restored(kept, model, reasons);
    if (now.path && Tree.at(reasons.step(model.relations[now.relation].step), now.path, reasons, now.all) === null) now.path = "";
    this.store.now = now;
    this.follow(now, null, true);
    this.news.tell(found);
    document.documentElement.dataset.event = model.event;
  }

  /** Mark relations as new. */
  mint(fresh) {
    this.fresh = fresh;
    this.graph.mint(fresh);
    if (fresh.size === 0) for (const row of document.querySelectorAll(".row.fresh")) row.classList.remove("fresh");
  }

  /** Take in what came later: explanations and shapes. */
  know(reasons) {
    this.reasons = reasons;
    this.restore();
    window.addEventListener("hashchange", () => this.restore());
  }
}

async function start() {
  const model = understood(await read("now"));
  const page = new Page(model);
  page.follow(page.store.now, null);
  page.picture?.fit();
  page.picture?.overview();
  page.know(new Reasons(await read("later")));
  document.documentElement.dataset.ready = "yes";
  // Only what a server sent follows a scene; a file asks for nothing.
  if (model.event && location.protocol.startsWith("http")) {
    document.documentElement.dataset.event = model.event;
    follow(model.event, (now, later) => page.take(understood(now), new Reasons(later)), at("live"));
  }
}

start();
