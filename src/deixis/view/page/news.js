// What was gained and lost when a scene changed: said in a few lines for some seconds.
import { element } from "./element.js";

const LINES = 5; // said of one change
const SECONDS = 8;

/** What holds now and did not, and the reverse, as far as it concerns a view; of two models with their reasons. */
export function compared([before, known], [after, reasons], view) {
  const named = (model, told) => new Map(
    model.relations.filter((one) => one.view === null || model.views[one.view].id === view).map((one) => [told.key(one), one]),
  );
  const [old, now] = [named(before, known), named(after, reasons)];
  const only = (some, others) => [...some].filter(([key]) => !others.has(key)).map(([, one]) => one);
  return { gained: only(now, old), lost: only(old, now) };
}

export class News {
  /** `over` is called when what was told is no news any more. */
  constructor(host, over) {
    this.host = host;
    this.over = over;
    this.timer = null;
  }

  tell({ gained, lost }) {
    const lines = [
      ...gained.map((one) => element("p.gained", {}, one.text)), ...lost.map((one) => element("p.lost", {}, one.text)),
    ];
    if (lines.length === 0) return;
    const more = lines.length - LINES;
    this.host.replaceChildren(...lines.slice(0, LINES), ...(more > 0 ? [element("p", {}, `and ${more} more`)] : []));
    this.host.hidden = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.host.hidden = true;
      this.host.replaceChildren();
      this.over();
    }, 1000 * SECONDS);
  }
}
