// One individual: its trials, its ancestors back to generation 0, its children.

import { h, bar, table, tiles } from "./dom.js";
import { fitness, short, count, path } from "./words.js";
import { Chart } from "./chart.js";
import { replay } from "./replication.js";

const STEP = 0.05; // s

export function individual([name, number, generation, id], { fetchJson, go }) {
  const element = h("div", { class: "view" }, h("h1", {}, `${name}/${number}/${generation}/${id}`));
  const of = (generation, individual) => path(name, number, generation, individual);
  let shown = false;

  async function update() {
    // What is committed never changes.
    if (shown) return;
    const answer = await fetchJson(`/api${of(generation, id)}`);
    shown = true;
    const total = answer.trials.length;
    const parent = answer.parent === null ? "a founder" : h("a", { href: of(answer.generation - 1, answer.parent) }, String(answer.parent));
    element.append(
      tiles([
        ["Fitness", fitness(answer.fitness), `rank ${answer.rank}`], ["Successes", String(answer.successes), `of ${count(total, "trial")}`],
        ["Origin", answer.origin, answer.origin === "varied" ? `${count(answer.flips, "bit")} flipped` : null],
        ["Parent", parent, answer.parent === null ? null : `generation ${answer.generation - 1}`],
      ]),
      h("div", { class: "buttons" },
        answer.foreign ? h("span", { class: "soft" }, `No replay: ${answer.foreign}.`) : replay(of(generation, id), null, true),
        h("a", { class: "button", href: path(name, number, generation) }, `generation ${generation}`)),
      answer.failure ? h("p", { class: "bad" }, `Its evaluation was given up: ${answer.failure}.`) : "",
      answer.individual === answer.evaluated_as ? "" : h("p", { class: "soft" }, "The same genotype as ",
        h("a", { href: of(generation, answer.evaluated_as) }, `individual ${answer.evaluated_as}`), ", under which it was evaluated."),
      h("section", { "aria-labelledby": "trials" }, h("h2", { id: "trials" }, "Trials"), trials(answer, of(generation, id))),
      lineage(answer, of, go),
      h("section", { "aria-labelledby": "children" }, h("h2", { id: "children" }, "Children"), children(answer, of)),
      answer.flipped.length === 0 ? "" : h("details", { class: "panel" },
        h("summary", {}, `The ${count(answer.flipped.length, "bit")} in which it differs from its parent`), h("pre", {}, answer.flipped.join(" "))));
    if (location.hash === "#lineage") document.getElementById("lineage").scrollIntoView();
  }

  return { element, update };
}

// The trials by behaviour, each a link into the replay.
function trials(answer, address) {
  const behaviours = [...new Set(answer.trials.map((trial) => trial.behaviour))];
  return h("div", { class: "trials" }, ...behaviours.map((behaviour, colour) => {
    const own = answer.trials.filter((trial) => trial.behaviour === behaviour);
    const reached = own.filter((trial) => trial.success).length;
    return h("div", { class: `panel c${colour}` }, h("h3", {}, `${behaviour ?? "trials"} `, h("small", { class: "soft" }, `${reached} of ${own.length}`)),
      h("ul", {}, ...own.map((trial) => {
        const full = bar();
        full.set(trial.score ?? 0);
        const words = trial.success ? h("span", { class: "good", title: `after ${(trial.steps * STEP).toFixed(2)} s it ended` }, "✓ goal") : h("span", { class: "soft" }, "failed");
        const link = answer.foreign ? String(trial.trial) : h("a", { href: `${address}/replay#trial=${trial.trial}&play`, title: `replay trial ${trial.trial}` }, String(trial.trial));
        return h("li", { class: trial.success ? null : "failed" }, link, full.element, h("span", { class: "n" }, short(trial.score) || "none"), words);
      })));
  }));
}

// The ancestors: a curve of all, and a table without the stretches in which genes were only copied.
function lineage(answer, of, go) {
  const line = [...answer.lineage].reverse();
  const chart = new Chart({ title: "Fitness of its ancestors", note: "each in its own generation's positions; choose one", pick: (generation) => {
    const ancestor = line[generation];
    if (ancestor) go(of(ancestor.generation, ancestor.individual));
  } });
  chart.set([{ name: "fitness", colour: 0, points: line.map((a) => [a.generation, a.fitness]) },
    { name: "successes", colour: 2, soft: true, points: line.map((a) => [a.generation, a.successes / Math.max(answer.trials.length, 1)]) }]);
  const rows = [];
  for (const ancestor of answer.lineage) {
    const copied = ancestor.origin !== "founder" && ancestor.flips === 0 && ancestor.generation !== answer.generation;
    if (!copied) rows.push({ ...ancestor, copies: 0 });
    else if (rows.at(-1).from !== undefined) Object.assign(rows.at(-1), { from: ancestor.generation, copies: rows.at(-1).copies + 1 });
    else rows.push({ ...ancestor, from: ancestor.generation, copies: 1 });
  }
  const varied = answer.lineage.filter((a) => a.flips > 0).length;
  const when = (a) => (a.copies > 1 ? `${a.from} to ${a.generation}` : String(a.generation));
  return h("section", { "aria-labelledby": "lineage" }, h("h2", { id: "lineage" }, "Lineage, back to generation 0"), chart.element,
    h("details", { open: rows.length <= 60 }, h("summary", {}, `${count(rows.length, "step")}: ${count(varied, "ancestor")} with flipped bits, copies drawn together`),
      table("The individual and its ancestors, the latest first", [
        ["generation", when, true],
        ["individual", (a) => h("a", { href: of(a.generation, a.individual) }, String(a.individual)), true],
        ["rank", (a) => a.rank, true, true], ["fitness", (a) => fitness(a.fitness), true],
        ["successes", (a) => `${a.successes}/${answer.trials.length}`, true, true],
        ["came about", (a) => (a.copies > 1 ? `copied ${a.copies} times` : a.origin === "varied" ? `${count(a.flips, "bit")} flipped` : a.origin === "elite" ? "copied" : "founder")],
        ["", (a) => replay(of(a.generation, a.individual), answer.foreign)],
      ], rows)));
}

function children(answer, of) {
  if (answer.generation + 1 >= answer.generations) return h("p", { class: "soft" }, "It is in the last generation so far.");
  if (answer.children.length === 0) return h("p", { class: "soft" }, `None: it was not among the parents of generation ${answer.generation + 1}.`);
  return h("ul", { class: "buttons" }, ...answer.children.map((child) => h("li", {}, h("a", { class: "button", href: of(answer.generation + 1, child) }, String(child)))));
}
