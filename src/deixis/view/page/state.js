// What is selected and shown, kept in the address so that it can be sent to someone.

const EMPTY = {
  thing: null, relation: null, path: "", view: 0, search: "", only: "", unsure: false,
  turned: false, spaces: false, all: false, theme: "",
};

/** One state, and those who watch it. */
export class Store {
  constructor() {
    this.now = { ...EMPTY };
    this.watchers = [];
  }

  watch(watcher) {
    this.watchers.push(watcher);
  }

  set(change) {
    const before = this.now;
    this.now = { ...before, ...change };
    for (const watcher of this.watchers) watcher(this.now, before);
  }
}

/** Write a state as the fragment of an address. */
export function written(state, model, reasons) {
  const told = new URLSearchParams();
  if (state.thing !== null) told.set("thing", model.things[state.thing].id);
  if (state.relation !== null) told.set("relation", reasons.key(model.relations[state.relation]));
  if (state.relation !== null && state.path) told.set("step", state.path);
  if (state.view) told.set("view", model.views[state.view].id);
  for (const name of ["search", "only", "theme"]) if (state[name]) told.set(name, state[name]);
  for (const name of ["unsure", "turned", "spaces", "all"]) if (state[name]) told.set(name, "1");
  return told.toString();
}

/** Read a state from the fragment of an address; what it names that is not here is left out. */
export function restored(fragment, model, reasons) {
  const told = new URLSearchParams(fragment);
  const key = told.get("relation");
  const relation = key === null ? -1 : model.relations.findIndex((one) => reasons.key(one) === key);
  const only = told.get("only") ?? "";
  const theme = told.get("theme") ?? "";
  return {
    ...EMPTY,
    thing: model.thingAt.get(told.get("thing")) ?? null,
    relation: relation < 0 ? null : relation,
    path: relation >= 0 && /^\d+(\.\d+)*$/.test(told.get("step") ?? "") ? told.get("step") : "",
    view: model.viewAt.get(told.get("view")) ?? 0,
    search: told.get("search") ?? "",
    only: model.predicates.includes(only) ? only : "",
    theme: ["light", "dark"].includes(theme) ? theme : "",
    ...Object.fromEntries(["unsure", "turned", "spaces", "all"].map((name) => [name, told.get(name) === "1"])),
  };
}

/** The relations that a state lists. */
export function listed(state, model) {
  const wanted = state.search.toLowerCase().split(/\s+/).filter(Boolean);
  return model.ranked.filter(
    (one) =>
      (one.view === null || one.view === state.view) &&
      (state.thing === null || one.things.includes(state.thing)) &&
      (!state.only || one.predicate === state.only) &&
      (!state.unsure || one.unsure) &&
      wanted.every((word) => one.folded.includes(word)),
  );
}
