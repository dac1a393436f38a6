// One condition: the curves of its replications, how each stands, its settings.

import { h, table, tiles } from "./dom.js";
import { fitness, count, time, path, state } from "./words.js";
import { Curves, SPREADS, measures, summarised } from "./curves.js";
import { Chart } from "./chart.js";

export function experiment([name], { fetchJson }) {
  const facts = h("div", {}), charts = h("div", { class: "charts" }), list = h("div", {}), note = h("p", { class: "soft" });
  const each = h("input", { type: "checkbox", checked: true, onchange: () => draw() });
  const spread = h("select", { onchange: () => draw() }, ...Object.entries(SPREADS).map(([key, { name }]) => h("option", { value: key }, name)));
  const settings = h("pre", {});
  const element = h("div", { class: "view" }, h("h1", {}, name), facts, note,
    h("section", { "aria-labelledby": "curves" },
      h("div", { class: "head" }, h("h2", { id: "curves" }, "Learning curves"),
        h("span", { class: "legend end soft" }, h("label", {}, each, " each replication"), h("label", {}, "shaded: ", spread))), charts),
    h("section", { "aria-labelledby": "replications" }, h("h2", { id: "replications" }, "Replications"), list),
    h("details", { class: "panel", ontoggle: show }, h("summary", {}, "The experiment file, complete"), settings));
  const curves = new Curves(name);
  let condition = null, drawn = null, listed = "";

  async function show() {
    if (settings.textContent) return;
    const response = await fetch(`/api/experiments/${encodeURIComponent(name)}/settings`);
    settings.textContent = await response.text();
  }

  function draw() {
    drawn ??= measures(condition.trials).map((measure) => ({ measure, chart: new Chart(measure) }));
    if (charts.children.length === 0) charts.append(...drawn.map(({ chart }) => chart.element));
    for (const { measure, chart } of drawn) {
      const lines = each.checked
        ? condition.replications.map((r) => ({ name: String(r.number), colour: 0, thin: true, points: curves.line(r.number, measure.value) }))
        : [];
      chart.set([...lines, summarised("mean", 0, curves, measure.value, spread.value)]);
    }
  }

  async function update(now) {
    condition = now.experiments.find((other) => other.name === name);
    if (!condition) throw Object.assign(new Error(`there is no experiment ${name} in ${now.file}`), { status: 404 });
    const sum = condition.replications.reduce((sum, r) => sum + r.generations, 0);
    const planned = condition.replications.reduce((sum, r) => sum + (r.state === "finished" ? r.generations : condition.generations), 0);
    const best = condition.replications.reduce((best, r) => Math.max(best, r.best_fitness ?? 0), 0);
    facts.replaceChildren(tiles([
      ["State", state(condition.state)],
      ["Generations", sum.toLocaleString("en"), `of ${planned.toLocaleString("en")}`],
      ["Best now", fitness(best)],
      ["Population", String(condition.population), condition.trials ? count(condition.trials, "trial") + " each" : null],
      ["Begun", time(condition.created_at).slice(0, 10), time(condition.created_at).slice(11)],
    ]));
    note.textContent = condition.foreign ? `No replays: ${condition.foreign}.` : "";
    if ((await curves.refresh(condition, fetchJson)) || drawn === null) draw();
    const text = JSON.stringify(condition.replications);
    if (text === listed || list.contains(document.activeElement) && listed) return;
    listed = text;
    list.replaceChildren(table("How each replication stands; the last generation's best individual", [
      ["replication", (r) => h("a", { href: path(name, r.number) }, String(r.number))],
      ["state", (r) => h("span", { class: `tag ${r.state}` }, state(r.state))],
      ["generations", (r) => `${r.generations} of ${condition.generations}`, true],
      ["best fitness", (r) => fitness(r.best_fitness), true], ["mean fitness", (r) => fitness(r.mean_fitness), true],
      ["successes", (r) => (r.best_successes === null ? "" : `${r.best_successes} of ${condition.trials ?? "?"}`), true],
      ["first optimal", (r) => (r.first_optimal === null ? "" : h("a", { href: path(name, r.number, r.first_optimal) }, `generation ${r.first_optimal}`))],
    ], condition.replications));
  }

  return { element, update };
}
