// What lights up in the picture: the things, points and spaces that a step of a proof speaks of.

const AXES = ["X+", "X-", "Y+", "Y-", "Z+", "Z-"];

const NOTHING = { figure: null, reference: null, others: [], spans: [], spaces: [], turned: [] };

/** The space on one side of a thing that a step speaks of, or null. */
function spaceOf(step, model) {
  const axis = step.args.find((one) => AXES.includes(one));
  const thing = model.thingAt.get(step.args[1]);
  if (axis === undefined || thing === undefined) return null;
  const view = step.args.map((one) => model.viewAt.get(one)).find((one) => one !== undefined);
  const frame = view === undefined ? 0 : view + 1;
  return { thing, axis, frame, plane: `${model.thingAt.get(step.args[0])} ${thing} ${axis} ${frame}` };
}

function spacesBelow(step, model, reasons, found = new Map()) {
  const space = spaceOf(step, model);
  if (space) found.set(`${space.thing} ${space.axis} ${space.frame}`, space);
  if (step.kind !== "negation") {
    for (const one of step.below) spacesBelow(reasons.step(one), model, reasons, found);
  }
  return [...found.values()];
}

/** The marks of a step. */
export function ofStep(step, model, reasons) {
  const named = (one) => one.args.map((arg) => model.thingAt.get(arg)).filter((index) => index !== undefined);
  const things = named(step);
  // Of what is absent, what came closest is shown.
  if (step.kind === "negation" || things.length < 2) {
    for (const one of step.below.flatMap((number) => named(reasons.step(number)))) {
      if (!things.includes(one)) things.push(one);
    }
  }
  const [figure = null, reference = null, ...others] = things;
  const ends = reference === null ? undefined : reasons.span(figure, reference);
  const about = spaceOf(step, model);
  return {
    ...NOTHING, figure, reference, others,
    spans: ends && !about ? [ends] : [],
    spaces: (about ? [about] : spacesBelow(step, model, reasons)).map((one) => ({ ...one, plane: reasons.plane(one.plane) })),
  };
}

/** The marks of a state, `step` being the one selected, if any. */
export function marksOf(state, step, model, reasons) {
  const marks = step ? ofStep(step, model, reasons) : { ...NOTHING, figure: state.thing };
  const subject = state.thing ?? marks.reference ?? marks.figure;
  if (subject !== null && state.turned) marks.turned = [{ thing: subject, frame: state.view + 1 }];
  if (subject !== null && state.spaces) {
    const own = AXES.map((axis) => ({ thing: subject, axis, frame: state.view + 1 }));
    marks.spaces = [...marks.spaces, ...own];
  }
  return marks;
}
