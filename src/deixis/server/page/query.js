// The query page: YASGUI on this server's endpoint, with examples. A query in the address, #query=..., is run.
"use strict";

// What is asked stays here: the completers for classes and properties would ask a server elsewhere.
Yasgui.Yasqe.defaults.autocompleters = ["variables"];
Yasgui.Yasqe.defaults.resizeable = true;

async function start() {
  const told = await (await fetch("/page/examples.json")).json();
  const prefixes = Object.entries(told.prefixes).map(([name, iri]) => `PREFIX ${name}: <${iri}>\n`).join("");
  const written = (query) => prefixes + query;

  const yasgui = new Yasgui(document.getElementById("yasgui"), {
    requestConfig: { endpoint: new URL("/sparql", location.href).href, method: "POST" },
    copyEndpointOnNewTab: true,
    persistenceId: "deixis",
    yasqe: { value: written(told.examples[0].query) },
  });

  const show = (query) => {
    const tab = yasgui.getTab();
    tab.setQuery(query);
    return tab.getYasqe().query();
  };

  const examples = document.getElementById("examples");
  for (const example of told.examples) {
    const option = document.createElement("option");
    option.textContent = example.title;
    option.value = written(example.query);
    examples.append(option);
  }
  examples.addEventListener("change", () => examples.value && show(examples.value));

  const served = await (await fetch("/scenes")).json();
  for (const { id } of served.scenes) {
    const link = document.createElement("a");
    link.href = `/scenes/${encodeURIComponent(id)}/view`;
    link.textContent = `See ${id}`;
    document.getElementById("scenes").append(link, " ");
  }

  const asked = new URLSearchParams(location.hash.slice(1)).get("query");
  if (asked) await show(asked);
}

start();
