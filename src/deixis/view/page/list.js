// The relations in a list of which only what is seen is in the document; arrow keys go through it.

const TALL = 46; // pixels of a row, as in the style sheet
const SPARE = 6; // rows beyond what is seen

export class List {
  constructor(host, choose, describe) {
    this.host = host;
    this.choose = choose;
    this.describe = describe;
    this.rows = [];
    this.at = -1;
    this.inner = document.createElement("div");
    this.inner.setAttribute("role", "presentation");
    host.append(this.inner);
    host.addEventListener("scroll", () => this.draw(), { passive: true });
    host.addEventListener("click", (event) => {
      const row = event.target.closest("[data-at]");
      if (row) this.choose(this.rows[Number(row.dataset.at)]);
    });
    host.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(host);
  }

  key(event) {
    const page = Math.max(1, Math.floor(this.host.clientHeight / TALL) - 1);
    const to = {
      ArrowDown: this.at + 1, ArrowUp: this.at - 1, PageDown: this.at + page, PageUp: this.at - page, Home: 0, End: this.rows.length - 1,
    }[event.key];
    if (to === undefined || this.rows.length === 0) return;
    event.preventDefault();
    this.choose(this.rows[Math.min(Math.max(to, 0), this.rows.length - 1)]);
  }

  /** Show these rows, one of them selected, which is scrolled to unless the list is to stay where it is. */
  show(rows, selected, still = false) {
    const moved = rows !== this.rows || rows[this.at] !== selected;
    if (rows !== this.rows) this.inner.replaceChildren();
    this.rows = rows;
    this.at = selected ? rows.indexOf(selected) : -1;
    this.inner.style.height = `${rows.length * TALL}px`;
    if (moved && !still && this.at >= 0) this.reveal();
    this.draw();
  }

  reveal() {
    const top = this.at * TALL;
    if (top < this.host.scrollTop) this.host.scrollTop = top;
    else if (top + TALL > this.host.scrollTop + this.host.clientHeight) this.host.scrollTop = top + TALL - this.host.clientHeight;
  }

  draw() {
    const first = Math.max(0, Math.floor(this.host.scrollTop / TALL) - SPARE);
    const last = Math.min(this.rows.length, Math.ceil((this.host.scrollTop + this.host.clientHeight) / TALL) + SPARE);
    const drawn = new Map();
    for (const element of [...this.inner.children]) {
      const at = Number(element.dataset.at);
      if (at < first || at >= last) element.remove();
      else drawn.set(at, element);
    }
    // What stays is left where it is: a click whose row is exchanged under the pointer would be lost.
    let next = this.inner.firstElementChild;
    for (let at = first; at < last; at += 1) {
      const element = drawn.get(at) ?? this.inner.insertBefore(this.row(at), next);
      element.setAttribute("aria-selected", String(at === this.at));
      next = element.nextElementSibling;
    }
    const seen = this.at >= first && this.at < last;
    if (seen) this.host.setAttribute("aria-activedescendant", `row-${this.at}`);
    else this.host.removeAttribute("aria-activedescendant");
  }

  row(at) {
    const element = this.describe(this.rows[at]);
    element.id = `row-${at}`;
    element.dataset.at = at;
    element.setAttribute("role", "option");
    element.setAttribute("aria-setsize", this.rows.length);
    element.setAttribute("aria-posinset", at + 1);
    element.style.top = `${at * TALL}px`;
    return element;
  }
}
