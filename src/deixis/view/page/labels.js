// Names beside things: text elements over the picture, the more important ones first, none over another.
import { Vector3 } from "three";

const FEW = 40; // things that are all named
const GAP = 3; // pixels

export class Labels {
  constructor(host, model) {
    this.layer = document.createElement("div");
    this.layer.className = "labels";
    this.layer.setAttribute("aria-hidden", "true");
    host.append(this.layer);
    this.model = model;
    this.elements = new Map();
    this.lit = [];
    this.over = null;
    this.view = 0;
    this.point = new Vector3();
  }

  /** Take over another model: names may be others. */
  take(model) {
    this.model = model;
    this.elements.clear();
    this.layer.replaceChildren();
    this.over = null;
  }

  light(marks) {
    const roles = { figure: marks.figure, reference: marks.reference };
    this.roles = new Map(Object.entries(roles).filter(([, one]) => one !== null).map(([role, one]) => [one, role]));
    this.lit = [marks.figure, marks.reference, ...marks.others].filter((one) => one !== null);
  }

  stand(view) {
    this.view = view;
  }

  /** Take note of what the pointer is over; tell whether that is new. */
  hover(thing) {
    const changed = thing !== this.over;
    this.over = thing;
    return changed;
  }

  element(key, text) {
    if (!this.elements.has(key)) {
      const element = document.createElement("span");
      element.textContent = text;
      this.layer.append(element);
      this.elements.set(key, { element, wide: element.offsetWidth, tall: element.offsetHeight });
    }
    return this.elements.get(key);
  }

  place(camera, wide, tall) {
    const { things, views } = this.model;
    const some = [...this.lit, ...(this.over === null ? [] : [this.over])];
    const all = things.length <= FEW ? things.filter((one) => !one.surface).map((one) => one.index) : [];
    const wanted = [...new Set([...some, ...all])].map((index) => {
      const { name, center, half, surface } = things[index];
      return [index, name, surface ? center : [center[0], center[1], center[2] + half[2]], this.roles?.get(index) ?? ""];
    });
    for (const one of views) wanted.push([`view ${one.index}`, one.name, one.position, one.index === this.view ? "view" : "view faint"]);
    const taken = [];
    const kept = new Set();
    for (const [key, text, position, role] of wanted) {
      const at = this.point.set(...position).project(camera);
      if (at.z > 1 || Math.abs(at.x) > 1 || Math.abs(at.y) > 1) continue;
      const label = this.element(key, text);
      const left = Math.round(((at.x + 1) / 2) * wide - label.wide / 2);
      const top = Math.round(((1 - at.y) / 2) * tall - label.tall - 4);
      const area = [left - GAP, top, left + label.wide + GAP, top + label.tall];
      if (taken.some((one) => area[0] < one[2] && one[0] < area[2] && area[1] < one[3] && one[1] < area[3])) continue;
      taken.push(area);
      kept.add(key);
      label.element.className = role;
      label.element.style.transform = `translate(${left}px, ${top}px)`;
      label.element.hidden = false;
    }
    for (const [key, { element }] of this.elements) if (!kept.has(key)) element.hidden = true;
  }
}
