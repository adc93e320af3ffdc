// Follows the scene on the server that the page came from: hears that something changed, and fetches what is shown then.
import { unpacked } from "./data.js";

const AGAIN = 3000; // milliseconds until the next try
const LONGEST = 60_000; // the same where it fails again and again
const SIGNS = { live: "live", lost: "connection lost, trying again", gone: "this scene was removed" };

const pause = (time) => new Promise((done) => { setTimeout(done, time); });

/** Resolve when no button is held: what is under the pointer is not exchanged between its two halves of a click. */
function released() {
  let held = false;
  let waiting = [];
  const up = () => {
    held = false;
    // The click comes after this.
    setTimeout(() => { for (const go of waiting.splice(0)) go(); });
  };
  addEventListener("pointerdown", () => { held = true; }, true);
  for (const name of ["pointerup", "pointercancel"]) addEventListener(name, up, true);
  addEventListener("blur", ({ target }) => { if (target === window) up(); });
  return () => (held ? new Promise((done) => { waiting.push(done); }) : Promise.resolve());
}

/** Follow what happens after an event: `take` is given the data of what is shown, and `sign` says how it stands. */
export function follow(event, take, sign) {
  const still = released();
  let last = event;
  let shown = event;
  let stale = false;
  let busy = false;

  const say = (state) => {
    sign.hidden = false;
    sign.dataset.state = state;
    if (sign.textContent !== SIGNS[state]) sign.textContent = SIGNS[state];
  };

  /** Fetch what is shown now, again and again while more has happened. */
  const renew = async () => {
    stale = true;
    if (busy) return;
    busy = true;
    let wait = AGAIN;
    while (stale) {
      stale = false;
      try {
        const reply = await fetch("view/data", { cache: "no-store" });
        if (reply.status === 404) break;
        if (!reply.ok) {
          // It is there, and has no time.
          await pause(wait);
          wait = Math.min(2 * wait, LONGEST);
          stale = true;
          continue;
        }
        wait = AGAIN;
        const told = await reply.json();
        const [now, later] = await Promise.all([unpacked(told.now), unpacked(told.later)]);
        await still();
        if (now.event !== shown) take(now, later);
        shown = now.event;
      } catch {
        say("lost");
        await pause(AGAIN);
        stale = true;
        continue;
      }
      if (sign.dataset.state === "lost" && source.readyState === EventSource.OPEN) say("live");
    }
    busy = false;
  };

  let source = null;
  const listen = () => {
    source = new EventSource(`changes?since=${encodeURIComponent(last)}`);
    source.addEventListener("open", () => say("live"));
    for (const kind of ["changes", "reload"]) {
      source.addEventListener(kind, ({ lastEventId }) => {
        last = lastEventId;
        renew();
      });
    }
    source.addEventListener("gone", () => say("gone"));
    source.addEventListener("error", () => {
      if (sign.dataset.state !== "gone") say("lost");
      // Where the server refuses, the browser gives up; it may be there again later.
      if (source.readyState === EventSource.CLOSED) setTimeout(listen, AGAIN);
    });
  };
  listen();
}
