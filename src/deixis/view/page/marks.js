// What lights up in the picture: the things, points, planes and spaces that a step of a proof speaks of.

const AXES = ["X+", "X-", "Y+", "Y-", "Z+", "Z-"];
const MANY = 3; // planes that can be told apart

const NOTHING = { figure: null, reference: null, others: [], spans: [], planes: [], spaces: [], turned: [], unsure: false };

/** The spaces on one side of a thing that a step and those below it speak of, by name. */
function spacesOf(step, model, reasons, found = new Map()) {
  const axis = step.args.find((one) => AXES.includes(one));
  const thing = model.thingAt.get(step.args[1]);
  if (axis !== undefined && thing !== undefined) {
    const view = step.args.map((one) => model.viewAt.get(one)).find((one) => one !== undefined);
    const frame = view === undefined ? 0 : view + 1;
    found.set(`${thing} ${axis} ${frame}`, { thing, axis, frame });
  } else {
    for (const one of step.below.map((number) => reasons.step(number))) {
      if (one.kind !== "negation") spacesOf(one, model, reasons, found);
    }
  }
  return found;
}

/** The marks of a step. */
function ofStep(step, model, reasons) {
  const placed = (names) => names.map((one) => model.thingAt.get(one)).filter((index) => index !== undefined);
  const sights = [...reasons.sights(step).values()];
  const own = placed(step.args);
  // Of what is absent, what came closest is shown.
  const more = own.length < 2 || step.kind === "negation" ? sights.flatMap(([names]) => placed(names)) : [];
  const [figure = null, reference = null, ...others] = [...new Set([...own, ...more])];
  const planes = sights.filter(([, , plane]) => plane !== null);
  return {
    ...NOTHING, figure, reference, others,
    unsure: step.margin !== null && Math.abs(step.margin) < model.thresholds.pose_noise,
    spans: sights.filter(([, points]) => points !== null).map(([, points]) => points),
    planes: planes.length <= MANY ? planes.map(([names, , plane]) => ({ plane, thing: model.thingAt.get(names[1]) })) : [],
    spaces: [...spacesOf(step, model, reasons).values()],
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
