// Everything at a glance: replications, learning curves by condition, workers.

import { h, say, attribute, keyed, table, bar, tiles } from "./dom.js";
import { short, count, rate, duration, ago, time, path, state } from "./words.js";
import { Curves, SPREADS, measures, summarised } from "./curves.js";
import { Chart } from "./chart.js";

export function overview(_, { fetchJson }) {
  const title = h("h1", {}, "…"), facts = h("div", {}), grid = h("div", { class: "panel conditions" }), legend = h("div", { class: "legend" });
  const charts = h("div", { class: "charts" }), workers = h("div", { class: "stack" });
  const spread = h("select", { onchange: () => draw() }, ...Object.entries(SPREADS).map(([key, { name }]) => h("option", { value: key }, name)));
  const element = h("div", { class: "view" },
    title, facts,
    h("section", { "aria-labelledby": "replications" }, h("h2", { id: "replications" }, "Replications"), grid),
    h("section", { "aria-labelledby": "curves" },
      h("div", { class: "head" }, h("h2", { id: "curves" }, "Learning curves"),
        h("label", { class: "soft end" }, "mean over replications, shaded: ", spread)), legend, charts),
    h("section", { "aria-labelledby": "workers" }, h("h2", { id: "workers" }, "Workers"), workers));
  const curves = new Map(), hidden = new Set();
  let now = null, drawn = null, earlier = null;

  function draw() {
    const shown = now.experiments.map((condition, i) => [condition, i]).filter(([condition]) => !hidden.has(condition.name));
    const trials = new Set(now.experiments.map((condition) => condition.trials));
    // Conditions with other trials share the chart of shares.
    drawn ??= measures(trials.size === 1 ? [...trials][0] : null).map((measure) => ({ measure, chart: new Chart(measure) }));
    if (charts.children.length === 0) charts.append(...drawn.map(({ chart }) => chart.element));
    for (const { measure, chart } of drawn) {
      chart.set(shown.map(([condition, i]) => {
        const own = measures(condition.trials).find((other) => other.key === measure.key);
        return summarised(condition.name, i % 8, curves.get(condition.name), own.value, spread.value);
      }));
    }
  }

  async function update(fresh) {
    now = fresh;
    say(title, now.file);
    facts.replaceChildren(now.live ? tiles(live(now.live)) : tiles(still(now)));
    keyed(grid, now.experiments, (condition) => condition.name, condition, updateCondition);
    keyed(legend, now.experiments.length > 1 ? now.experiments : [], (condition) => condition.name, (condition) => {
      const colour = now.experiments.indexOf(condition) % 8;
      return h("button", { type: "button", class: `c${colour}`, onclick: () => toggle(condition.name) }, h("span", { class: "swatch" }), condition.name);
    }, (button, condition) => attribute(button, "aria-pressed", !hidden.has(condition.name)));
    let changed = drawn === null;
    for (const condition of now.experiments) {
      if (!curves.has(condition.name)) curves.set(condition.name, new Curves(condition.name));
      changed = (await curves.get(condition.name).refresh(condition, fetchJson)) || changed;
    }
    if (changed) draw();
    await updateWorkers();
  }

  function toggle(name) {
    hidden.has(name) ? hidden.delete(name) : hidden.add(name);
    for (const button of legend.children) attribute(button, "aria-pressed", !hidden.has(button.dataset.key));
    draw();
  }

  function condition(condition) {
    const colour = now.experiments.indexOf(condition) % 8;
    return h("div", { class: `condition c${colour}` },
      h("div", { class: "head" }, h("h3", {}, h("span", { class: "swatch" }), h("a", { href: path(condition.name) }, condition.name)),
        h("span", { class: "tag" }), h("span", { class: "soft" })),
      h("ol", { class: "cells", "aria-label": `replications of ${condition.name}` }));
  }

  function updateCondition(part, condition) {
    const [, tag, words] = part.firstElementChild.children;
    attribute(tag, "class", `tag ${condition.state}`);
    say(tag, state(condition.state));
    const finished = condition.replications.filter((r) => r.state === "finished").length;
    say(words, `${finished} of ${count(condition.replications.length, "replication")} finished · ${condition.generations} generations`);
    keyed(part.lastElementChild, condition.replications, (r) => r.number, (r) => {
      const full = bar();
      const cell = h("li", {}, h("a", { class: "cell", href: path(condition.name, r.number) },
        h("span", { class: "row" }, h("span", { class: "number" }, String(r.number)), h("span", { class: "soft" })), full.element,
        h("span", { class: "row" }, h("span", {}), h("span", {}))));
      cell.fill = full.set;
      return cell;
    }, (cell, r) => {
      const link = cell.firstElementChild, [top, , bottom] = link.children;
      const of = r.state === "finished" ? r.generations : condition.generations;
      const successes = r.best_successes === null ? "" : `${r.best_successes}/${condition.trials ?? "?"}`;
      attribute(link, "class", `cell ${r.state}`);
      say(top.lastElementChild, r.state === "finished" ? "done" : `${r.generations}/${of}`);
      say(bottom.firstElementChild, short(r.best_fitness));
      say(bottom.lastElementChild, successes);
      cell.fill(of ? r.generations / of : 0);
      const best = r.best_fitness === null ? "" : `, best fitness ${short(r.best_fitness)}, ${successes} trials`;
      attribute(link, "aria-label", `replication ${r.number}: ${state(r.state)}, ${r.generations} of ${of} generations${best}`);
      attribute(link, "title", link.getAttribute("aria-label"));
    });
  }

  async function updateWorkers() {
    if (now.live) {
      workers.replaceChildren(now.live.workers.length === 0
        ? h("p", { class: "panel soft" }, "No worker is connected: `selftalk-worker --master …` joins.")
        : table("Connected workers, and when each was last heard", [
          ["worker", (w) => w.name], ["machine", (w) => w.host, false, true], ["slots", (w) => w.slots, true],
          ["trials a second", (w) => rate(w.trials_per_second), true], ["trials", (w) => w.trials.toLocaleString("en"), true, true],
          ["units in hand", (w) => w.units, true, true],
          ["last word", (w) => h("span", { class: w.silent_seconds > 5 ? "bad" : null }, ago(w.silent_seconds))],
        ], now.live.workers));
      return;
    }
    if (earlier) return;
    earlier = await fetchJson("/api/workers");
    workers.replaceChildren(
      h("p", { class: "soft" }, "No master is running in this process. A master shows its workers, their rate and the time left on its own dashboard."),
      table(`Workers that took part${earlier.length >= 200 ? ", the last 200" : ""}, the latest first`, [
        ["worker", (w) => w.name], ["machine", (w) => w.host], ["release", (w) => w.version], ["slots", (w) => w.slots, true],
        ["joined", (w) => time(w.joined_at)], ["left", (w) => time(w.left_at) || "not noted"],
      ], earlier));
  }

  return { element, update };
}

function live(live) {
  return [
    ["Time left", live.seconds_left === null ? "…" : duration(live.seconds_left), "about"],
    ["Generations a minute", rate(live.generations_per_minute)],
    ["Trials a second", rate(live.trials_per_second)],
    ["Workers", String(live.workers.length), count(live.slots, "slot")],
    ["Units waiting", live.units_waiting.toLocaleString("en"), `${live.units_leased.toLocaleString("en")} in hand`],
  ];
}

function still(now) {
  const replications = now.experiments.flatMap((condition) => condition.replications);
  const finished = replications.filter((r) => r.state === "finished").length;
  return [
    ["Experiments", String(now.experiments.length)],
    ["Replications", String(replications.length), `${finished} finished`],
    ["Generations", replications.reduce((sum, r) => sum + r.generations, 0).toLocaleString("en")],
  ];
}
