// Elements of the document. What they say is always text, never markup.

/** Make an element: its tag and classes as in "span.name", its attributes, and what is in it. */
export function element(kind, attributes = {}, ...inside) {
  const [tag, ...classes] = kind.split(".");
  const made = document.createElement(tag);
  if (classes.length) made.className = classes.join(" ");
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...inside);
  return made;
}
