// The listed relations as a graph: laid out as seen from above, or around the thing that is selected.
import cytoscape from "cytoscape";
import { relationColour } from "./palette.js";

export const MOST = 60; // relations drawn: more are neither read nor drawn at once

const styles = (colours) => [
  { selector: "node", style: {
    label: "data(name)", "font-size": 10, color: colours.ink, "background-color": hex(colours.thing), width: 16, height: 16,
    "text-valign": "bottom", "text-margin-y": 3, "text-wrap": "wrap", "text-max-width": 90,
    "text-background-color": hex(colours.back), "text-background-opacity": 0.8, "min-zoomed-font-size": 6,
  } },
  { selector: "node[?surface]", style: { shape: "rectangle", "background-color": hex(colours.surface), "border-width": 1, "border-color": hex(colours.line) } },
  { selector: "edge", style: {
    width: 1.4, "line-color": "data(colour)", "target-arrow-color": "data(colour)", "target-arrow-shape": "triangle",
    "arrow-scale": 0.7, "curve-style": "bezier", opacity: 0.75,
  } },
  { selector: "edge[?unsure]", style: { "line-style": "dashed", "line-dash-pattern": [5, 4] } },
  { selector: "node.figure", style: { "background-color": hex(colours.figure), width: 22, height: 22, "font-weight": "bold" } },
  { selector: "node.reference", style: { "background-color": hex(colours.reference), width: 22, height: 22, "font-weight": "bold" } },
  { selector: "edge.fresh", style: { "underlay-color": hex(colours.view), "underlay-opacity": 0.35, "underlay-padding": 4 } },
  { selector: "edge.faint, node.faint", style: { opacity: 0.25 } },
  { selector: "edge.chosen", style: { width: 3.5, opacity: 1, label: "data(says)", "font-size": 10, color: colours.ink,
    "text-background-color": hex(colours.back), "text-background-opacity": 0.9, "text-rotation": "autorotate", "z-index": 9 } },
];

const hex = (number) => `#${number.toString(16).padStart(6, "0")}`;

export class Graph {
  constructor(host, note, model, choose) {
    this.note = note;
    this.model = model;
    this.fresh = new Set();
    this.cy = cytoscape({ container: host, minZoom: 0.1, maxZoom: 3, boxSelectionEnabled: false, autounselectify: true });
    this.cy.on("tap", "node", (event) => choose({ thing: event.target.data("index") }));
    this.cy.on("tap", "edge", (event) => choose({ relation: event.target.data("index") }));
    new ResizeObserver(() => { this.cy.resize(); this.cy.fit(undefined, 24); }).observe(host);
  }

  paint(colours) {
    this.cy.style(styles(colours));
  }

  /** Draw these relations, as many as can be read; all of them in sight unless the graph is to stay where it is. */
  show(rows, thing, still = false) {
    const drawn = rows.filter((one) => one.things.length >= 2).slice(0, MOST);
    const things = [...new Set(drawn.flatMap((one) => one.things.slice(0, 2)))];
    if (thing !== null && !things.includes(thing)) things.push(thing);
    this.note.textContent = rows.length > drawn.length ? `${drawn.length} of ${rows.length} relations drawn: select a thing or filter` : "";
    const places = this.places(things, thing);
    const nodes = things.map((index) => {
      const { name, surface } = this.model.things[index];
      return { data: { id: `n${index}`, index, name, surface }, position: places.get(index) };
    });
    const edges = drawn.map((one) => ({ classes: this.fresh.has(one.index) ? "fresh" : "", data: {
      id: `e${one.index}`, index: one.index, source: `n${one.things[0]}`, target: `n${one.things[1]}`,
      colour: relationColour(one.predicate), unsure: one.unsure, says: one.predicate.replaceAll("_", " "),
    } }));
    this.cy.batch(() => {
      this.cy.elements().remove();
      this.cy.add([...nodes, ...edges]);
    });
    if (!still) this.cy.fit(undefined, 24);
  }

  /** Mark these relations as new; without any, none. */
  mint(fresh) {
    this.fresh = fresh;
    if (fresh.size === 0) this.cy.edges().removeClass("fresh");
  }

  /** Mark what is selected. */
  mark(relation, marks) {
    this.cy.batch(() => {
      this.cy.elements().removeClass("figure reference chosen faint");
      if (relation !== null) {
        this.cy.edges().addClass("faint");
        this.cy.$id(`e${relation}`).removeClass("faint").addClass("chosen");
      }
      if (marks.figure !== null) this.cy.$id(`n${marks.figure}`).addClass("figure");
      if (marks.reference !== null) this.cy.$id(`n${marks.reference}`).addClass("reference");
    });
  }

  places(things, thing) {
    if (thing !== null) {
      const others = things.filter((one) => one !== thing);
      const radius = Math.max(110, others.length * 9);
      const around = others.map((one, at) => {
        const angle = (2 * Math.PI * at) / others.length;
        return [one, { x: 1.6 * radius * Math.cos(angle), y: radius * Math.sin(angle) }];
      });
      return new Map([[thing, { x: 0, y: 0 }], ...around]);
    }
    return apart(things.map((one) => this.model.things[one]));
  }
}

/** Places of things as seen from above, moved apart until their names can be read. */
function apart(things) {
  const wide = Math.max(1, ...things.map((one) => Math.hypot(one.center[0], one.center[1])));
  const scale = (60 * Math.sqrt(things.length + 1)) / wide;
  // Two above each other start a little apart, always in the same way.
  const spots = things.map((one, at) => ({
    index: one.index, x: scale * one.center[0] + Math.cos(at), y: -scale * one.center[1] + Math.sin(at),
  }));
  for (let round = 0; round < 60; round += 1) {
    for (let i = 0; i < spots.length; i += 1) {
      for (let j = 0; j < i; j += 1) {
        const [dx, dy] = [spots[i].x - spots[j].x, 1.6 * (spots[i].y - spots[j].y)];
        const gap = Math.hypot(dx, dy) || 1;
        const push = Math.max(0, 90 - gap) / (4 * gap);
        spots[i].x += push * dx;
        spots[j].x -= push * dx;
        spots[i].y += push * dy;
        spots[j].y -= push * dy;
      }
    }
  }
  return new Map(spots.map(({ index, x, y }) => [index, { x, y }]));
}
