// The numbers behind what is selected: a step's margin, rule and values, or a thing's box.
import { metres } from "./data.js";
import { element } from "./element.js";

const UNITS = { m: " m", m3: " m³", 1: "" };
const exact = ({ name, value, unit }) => `${name.replaceAll("_", " ")} ${value}${UNITS[unit]}`;

function table(rows) {
  return element("dl", {}, ...rows.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
}

/** What there is to know of a step. */
export function ofStep(step, model) {
  const said = step.args.map((one) => (one === null ? "_" : String(one))).join(", ");
  const rows = [["as a fact", step.args.length ? `${step.predicate}(${said})` : step.predicate]];
  if (step.margin !== null) {
    const noise = model.thresholds.pose_noise;
    const unsure = Math.abs(step.margin) < noise ? `, within the pose noise of ${metres(noise)}: uncertain` : "";
    rows.push(["margin", `${step.margin} m${unsure}`]);
  }
  if (step.values.length) rows.push(["measured", step.values.map(exact).join(", ")]);
  if (step.limits.length) rows.push(["compared with", step.limits.map(exact).join(", ")]);
  if (step.rule) rows.push(["rule", step.rule]);
  if (step.axiom !== null) rows.push(["axiom", String(step.axiom)]);
  return table(rows);
}

/** What there is to know of a thing. */
export function ofThing(thing, model, state, shape) {
  const size = thing.half.map((one) => metres(2 * one)).join(" × ");
  const rows = [
    ["id", thing.id],
    ["box", `${size}, centre ${thing.center.map((one) => one.toFixed(2)).join(", ")} m`],
    ["measured as", thing.model],
  ];
  if (shape?.of) rows.push(["drawn as", `${shape.points.length / 3} points of ${shape.of} points or triangles`]);
  for (const [view, index, reason] of model.withheld) {
    if (index === thing.index && view === state.view) rows.push(["no sides", reason]);
  }
  return table(rows);
}
