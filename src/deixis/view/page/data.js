// The data of the page: JSON in its own elements, deflated where it is large, and what is found in it by name.

/** Read a data element. */
export const read = (id) => unpacked(JSON.parse(document.getElementById(id).textContent));

/** Return data as they are, or inflated where they were deflated. */
export const unpacked = async (told) => (typeof told === "string" ? JSON.parse(await inflated(told)) : told);

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Response(stream).text();
}

// What people care for most comes first, before all the relations of a user's own rules.
const ORDER = [
  "on_top_of", "leans_on", "affixed_on", "inside", "part_in", "left_of", "right_of", "in_front_of", "behind", "beside", "above",
  "below", "near",
];

/** Things, views and relations, named and counted. */
export function understood(now) {
  const things = now.things.map(([id, name, surface, model, center, half, yaw, normal], index) => ({
    index, id, name, surface: surface === 1, model, center, half, yaw, normal,
  }));
  const noise = now.thresholds.pose_noise;
  const relations = now.relations.map(([predicate, of, view, margin, step, text], index) => ({
    index, predicate, things: of, view, margin, step,
    text: text.charAt(0).toUpperCase() + text.slice(1),
    folded: `${text} ${predicate} ${predicate.replaceAll("_", " ")} ${of.map((one) => things[one].id).join(" ")}`.toLowerCase(),
    unsure: margin !== null && margin < noise,
  }));
  const views = now.views.map((one, index) => ({ ...one, index, name: one.label || one.id }));
  const rank = (one) => (ORDER.indexOf(one.predicate) < 0 ? -1 : ORDER.indexOf(one.predicate));
  return {
    ...now, things, relations, views,
    ranked: [...relations].sort((a, b) => rank(a) - rank(b) || a.index - b.index),
    thingAt: new Map(things.map((one) => [one.id, one.index])),
    viewAt: new Map(views.map((one) => [one.id, one.index])),
    predicates: [...new Set(relations.map((one) => one.predicate))].sort((a, b) => ORDER.indexOf(a) - ORDER.indexOf(b)),
  };
}

const KINDS = ["rule", "fact", "comparison", "negation", "conjunction"];

/** Steps of proofs, made from their tables when asked for. */
export class Reasons {
  constructor(later) {
    this.tables = later;
    this.known = new Map();
  }

  step(number) {
    if (!this.known.has(number)) {
      const { words, rules, steps } = this.tables;
      const [kind, predicate, args, text, margin, axiom, rule, shown, below, values = [], limits = [], sight = null] = steps[number];
      const named = (some) => some.map(([name, value, unit]) => ({ name: words[name], value, unit }));
      this.known.set(number, {
        number, margin, axiom, below, sight,
        values: named(values),
        limits: named(limits),
        kind: KINDS[kind],
        predicate: words[predicate],
        args: args.map((one) => (one === null ? null : Array.isArray(one) ? one[0] : words[one])),
        text: words[text],
        rule: rule === null ? null : rules[rule].join(":"),
        shown: shown === 1,
      });
    }
    return this.known.get(number);
  }

  /** The nearest steps below one that a person needs, or simply all. */
  below(step, all) {
    if (all) return step.below.map((one) => this.step(one));
    return step.below.map((one) => this.step(one)).flatMap((one) => (one.shown ? [one] : this.below(one, false)));
  }

  /** What a relation is called by in an address: its predicate and arguments. */
  key(relation) {
    const { predicate, args } = this.step(relation.step);
    return [predicate, ...args].map((one) => encodeURIComponent(String(one))).join(",");
  }

  /** What lights up for a step: of a leaf its own, else those of the leaves it rests on, save what is absent. */
  sights(step, found = new Map()) {
    if (step.sight !== null) found.set(step.sight, this.tables.sights[step.sight]);
    else for (const one of step.below.map((number) => this.step(number))) if (one.kind !== "negation") this.sights(one, found);
    return found;
  }
}

/** Metres as people say them. */
export function metres(value) {
  const size = Math.abs(value);
  if (size < 0.0005) return "0 cm";
  return size < 1 ? `${+(value * 100).toPrecision(2)} cm` : `${+value.toFixed(2)} m`;
}
