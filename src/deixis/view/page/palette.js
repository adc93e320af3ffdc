// Colours: of the picture and the graph by theme, the rest being in the style sheet.

const THEMES = {
  light: {
    back: 0xf4f5f3, thing: 0xaab4bf, surface: 0xd9d5cb, line: 0x56606b, figure: 0xd4502a, reference: 0x2268ad,
    other: 0x8a6fb3, span: 0xb3123f, space: 0x2268ad, turned: 0x2268ad, view: 0x1d7a5c, ink: "#1f2429", soft: "#6a737c",
  },
  dark: {
    back: 0x14171b, thing: 0x566170, surface: 0x2b3036, line: 0x9aa6b2, figure: 0xf07a4f, reference: 0x5aa2ea,
    other: 0xb79be0, span: 0xff5d87, space: 0x5aa2ea, turned: 0x5aa2ea, view: 0x4fc19a, ink: "#e6e9ec", soft: "#98a2ad",
  },
};

const FAMILIES = {
  "#2f8f6b": ["on_top_of", "leans_on", "affixed_on", "touches"],
  "#a8720a": ["inside", "part_in"],
  "#7d5fb5": ["above", "below"],
  "#2f78bd": ["left_of", "right_of", "in_front_of", "behind", "beside"],
  "#7f8890": ["near"],
};
const COLOURS = new Map(Object.entries(FAMILIES).flatMap(([colour, names]) => names.map((name) => [name, colour])));

/** The colour of a relation; those of a user's own rules have one together. */
export const relationColour = (predicate) => COLOURS.get(predicate) ?? "#b3477d";

const darkOutside = matchMedia("(prefers-color-scheme: dark)");

/** Whether it is light or dark now, by choice or else as everywhere. */
export const themeOf = (state) => state.theme || (darkOutside.matches ? "dark" : "light");

export const coloursOf = (state) => THEMES[themeOf(state)];

export const whenOutsideChanges = (then) => darkOutside.addEventListener("change", then);
