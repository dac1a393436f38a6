// Learning curves, kept up to date with what is new only, and their mean and spread over replications.

export class Curves {
  constructor(name) {
    this.name = name;
    this.stride = 1;
    this.replications = new Map();
  }

  // Fetches what `condition` (from the overview) has beyond what is here; true if there was anything.
  async refresh(condition, fetchJson) {
    const last = (number) => this.replications.get(number)?.at(-1)?.generation ?? -1;
    if (condition.replications.some((r) => last(r.number) >= r.generations)) this.replications.clear(); // another file
    const behind = condition.replications.filter((r) => last(r.number) + 1 < r.generations);
    if (behind.length === 0) return false;
    const since = Math.max(Math.min(...behind.map((r) => last(r.number))), 0);
    const fresh = await fetchJson(`/api/experiments/${encodeURIComponent(this.name)}/curves?since=${since}`);
    this.stride = fresh.stride;
    for (const curve of fresh.replications) {
      const points = curve.generation.map((generation, i) => ({
        generation, best: curve.best[i], mean: curve.mean[i], successes: curve.successes[i], optimal: curve.optimal[i],
      }));
      const kept = (this.replications.get(curve.number) ?? [])
        .filter((point) => point.generation < since && point.generation % this.stride === 0);
      this.replications.set(curve.number, kept.concat(points));
    }
    return true;
  }

  line(number, value) {
    return (this.replications.get(number) ?? []).map((point) => [point.generation, value(point)]);
  }

  // Over the replications that have come so far: mean, lowest and highest, standard deviation; `whole` while all have.
  summary(value) {
    const sums = new Map();
    for (const points of this.replications.values()) {
      for (const point of points) {
        if (point.generation % this.stride !== 0) continue;
        const values = sums.get(point.generation);
        if (values) values.push(value(point));
        else sums.set(point.generation, [value(point)]);
      }
    }
    const all = [...this.replications.values()].filter((points) => points.length > 0).length;
    return [...sums.entries()].sort((a, b) => a[0] - b[0]).map(([generation, values]) => {
      const mean = values.reduce((sum, v) => sum + v, 0) / values.length;
      const squares = values.reduce((sum, v) => sum + (v - mean) ** 2, 0);
      const deviation = values.length > 1 ? Math.sqrt(squares / (values.length - 1)) : 0;
      return { generation, mean, deviation, low: Math.min(...values), high: Math.max(...values), n: values.length, whole: values.length === all };
    });
  }
}

// The ways to show how replications differ.
export const SPREADS = {
  range: { name: "lowest to highest", of: (p) => [p.low, p.high] },
  deviation: { name: "standard deviation", of: (p) => [Math.max(p.mean - p.deviation, 0), Math.min(p.mean + p.deviation, 1)] },
};

// A condition's mean and spread as a chart's series.
export function summarised(name, colour, curves, value, spread) {
  const points = curves.summary(value);
  return {
    name, colour,
    points: points.map((p) => [p.generation, p.mean]),
    band: points.map((p) => [p.generation, ...SPREADS[spread].of(p)]),
    // Beyond it, replications are still missing.
    ahead: points.findLast((p) => p.whole)?.generation,
  };
}

// What is drawn of each generation, all of it between 0 and 1.
export const measures = (trials) => [
  { title: "Fitness of the best", key: "best", value: (p) => p.best },
  { title: "Mean fitness", key: "mean", value: (p) => p.mean },
  { title: "Success of the best", note: `share of ${trials ?? "its"} trials`, key: "successes", value: (p) => p.successes / (trials ?? 1), percent: true },
];
