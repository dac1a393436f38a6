// One replication: its curves, and the individuals of a generation, by default the last.

import { h, attribute, say, table, tiles } from "./dom.js";
import { fitness, count, duration, path, state } from "./words.js";
import { Curves } from "./curves.js";
import { Chart } from "./chart.js";

export function replication([name, number, generation], { fetchJson, go }) {
  const chosen = generation === undefined ? null : Number(generation);
  const facts = h("div", {}), charts = h("div", { class: "charts" }), heading = h("h2", { id: "individuals" }), list = h("div", {});
  const foreign = h("p", { class: "soft" });
  const input = h("input", { type: "number", min: "0", step: "1", id: "generation", inputmode: "numeric" });
  const links = { first: "first", before: "previous", after: "next", last: "follow the last" };
  const steps = Object.fromEntries(Object.entries(links).map(([key, words]) => [key, h("a", { class: "button" }, words)]));
  const form = h("form", { onsubmit: (event) => { event.preventDefault(); to(input.value); } },
    h("label", { for: "generation" }, "generation"), input, h("button", {}, "go"), steps.first, steps.before, steps.after, steps.last);
  const element = h("div", { class: "view" }, h("h1", {}, `${name}, replication ${number}`), facts, charts,
    h("section", { "aria-labelledby": "individuals" }, h("div", { class: "head" }, heading), form, foreign, list));
  const curves = new Curves(name), to = (generation) => generation !== "" && generation !== null && go(path(name, number, generation));
  let drawn = null, shown = null;

  function draw(condition, mark) {
    if (drawn === null) {
      drawn = [new Chart({ title: "Fitness", note: "choose a generation", pick: to }),
        new Chart({ title: "Success", note: condition.trials ? `share of ${condition.trials} trials, and of individuals` : null, percent: true, pick: to })];
      charts.append(...drawn.map((chart) => chart.element));
    }
    const line = (value) => curves.line(Number(number), value);
    drawn[0].set([{ name: "best", colour: 0, points: line((p) => p.best) }, { name: "mean", colour: 1, points: line((p) => p.mean) }], mark);
    drawn[1].set([
      { name: "trials of the best", colour: 0, points: line((p) => p.successes / (condition.trials ?? 1)) },
      { name: "individuals that always succeed", colour: 2, points: line((p) => p.optimal / condition.population) }], mark);
  }

  function link(step, generation, there) {
    attribute(step, "href", there ? path(name, number, ...generation) : null);
    attribute(step, "aria-disabled", there ? null : "true");
  }

  async function update(now) {
    const condition = now.experiments.find((other) => other.name === name);
    const own = condition?.replications.find((other) => other.number === Number(number));
    if (!own) throw Object.assign(new Error(`there is no replication ${number} of ${name} in ${now.file}`), { status: 404 });
    const last = own.generations - 1, at = chosen ?? last;
    facts.replaceChildren(tiles([
      ["State", state(own.state)], ["Generations", String(own.generations), own.state === "finished" ? null : `of ${condition.generations}`],
      ["Best now", fitness(own.best_fitness), own.best_successes === null ? null : `${own.best_successes} of ${condition.trials ?? "?"} trials`],
      ["First optimal", own.first_optimal === null ? "none yet" : `generation ${own.first_optimal}`],
    ]));
    if ((await curves.refresh({ ...condition, replications: condition.replications }, fetchJson)) || drawn === null) draw(condition, chosen);
    if (last < 0) {
      say(heading, "No generation is complete yet");
      return;
    }
    attribute(input, "max", last);
    if (document.activeElement !== input && shown !== at) input.value = at;
    link(steps.first, [0], at > 0);
    link(steps.before, [at - 1], at > 0);
    link(steps.after, [at + 1], at < last);
    link(steps.last, [], chosen !== null);
    // The table stays as it is while somebody is in it.
    if (shown === at || (shown !== null && list.contains(document.activeElement))) return;
    const answer = await fetchJson(`/api${path(name, number, at)}`);
    shown = at;
    say(heading, `Individuals of generation ${at}${chosen === null && own.state === "running" ? ", the last" : ""}`);
    say(foreign, answer.foreign ? `No replays: ${answer.foreign}.` : "");
    list.replaceChildren(individuals(name, number, answer));
  }

  return { element, update };
}

// The link that plays an individual, or why there is none.
export function replay(address, foreign, main) {
  return foreign
    ? h("span", { "aria-disabled": "true", title: `No replay: ${foreign}` }, "no replay")
    : h("a", { href: `${address}/replay`, class: main ? "button main" : null }, main ? "Replay its trials" : "replay");
}

function individuals(name, number, answer) {
  const of = (generation, individual) => path(name, number, generation, individual);
  const caption = `${count(answer.individuals.length, "individual")} by rank, ${count(answer.distinct_genotypes, "distinct genotype")}; mean fitness ` +
    `${fitness(answer.mean_fitness)}, ${answer.optimal_individuals} that always succeed; took ${duration(answer.wall_ms / 1000)}`;
  return table(caption, [
    ["rank", (i) => String(i.rank), true],
    ["individual", (i) => h("a", { href: of(i.generation, i.individual), title: "its trials, ancestors and children" }, `${i.individual}`), true],
    ["fitness", (i) => (i.failure ? h("span", { class: "bad", title: i.failure }, "given up") : fitness(i.fitness)), true],
    ["successes", (i) => `${i.successes}/${answer.trials ?? "?"}`, true],
    ["origin", (i) => i.origin, false, true],
    ["parent", (i) => (i.parent === null ? "" : h("a", { href: of(i.generation - 1, i.parent) }, String(i.parent))), true, true],
    ["bits flipped", (i) => (i.origin === "varied" ? i.flips : ""), true, true],
    ["", (i) => h("span", {}, h("span", { class: "wide" }, h("a", { href: of(i.generation, i.individual) + "#lineage" }, "lineage"), " · "), replay(of(i.generation, i.individual), answer.foreign))],
  ], answer.individuals);
}
