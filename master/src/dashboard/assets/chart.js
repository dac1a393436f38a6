// A chart of lines and bands between 0 and 1 over generations. Pointer or arrow keys read values off it.

import { h, svg, attribute } from "./dom.js";
import { percent, short } from "./words.js";

const HEIGHT = 210, LEFT = 44, RIGHT = 10, TOP = 8, BOTTOM = 34;

// Round distances between ticks: 1, 2 or 5 times a power of ten.
function step(span, most) {
  const rough = Math.max(span / most, 1), power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
}

const path = (points) => points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

export class Chart {
  // `pick` is called with a generation that was chosen.
  constructor({ title, note, percent: inPercent, pick }) {
    this.title = title;
    this.format = inPercent ? percent : short;
    this.pick = pick;
    this.series = [];
    this.last = 1;
    this.at = null;
    this.mark = null;
    this.svg = svg("svg", { height: HEIGHT, tabindex: "0", role: "img", "aria-label": title });
    this.says = h("ul", { class: "says" });
    this.element = h("figure", { class: pick ? "chart picks" : "chart" },
      h("figcaption", {}, title, note ? h("small", {}, ` (${note})`) : null), this.svg, this.says);
    this.svg.addEventListener("pointermove", (event) => this.read(this.generation(event)));
    this.svg.addEventListener("pointerleave", () => this.read(null));
    this.svg.addEventListener("blur", () => this.read(null));
    this.svg.addEventListener("click", (event) => this.pick?.(this.generation(event)));
    this.svg.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(this.svg);
  }

  // Series: name, colour (0 to 7), points [x, y], and if wanted band [x, low, high], ahead (dashed beyond), thin, soft.
  set(series, mark = null) {
    this.series = series;
    this.mark = mark;
    this.last = Math.max(1, ...series.map((s) => s.points.at(-1)?.[0] ?? 0));
    // All generations at which there is something to read.
    this.stops = [...new Set(series.flatMap((s) => s.points.map(([x]) => x)))].sort((a, b) => a - b);
    this.draw();
  }

  key(event) {
    const now = this.stops.indexOf(this.at), end = this.stops.length - 1;
    const to = { ArrowLeft: now < 0 ? end : now - 1, ArrowRight: now < 0 ? 0 : now + 1, Home: 0, End: end }[event.key];
    if (to !== undefined && end >= 0) {
      event.preventDefault();
      this.read(this.stops[Math.min(Math.max(to, 0), end)]);
    } else if (event.key === "Enter" && this.at !== null) {
      this.pick?.(this.at);
    } else if (event.key === "Escape") {
      this.read(null);
    }
  }

  // The generation nearest to the pointer.
  generation(event) {
    const box = this.svg.getBoundingClientRect();
    const x = ((event.clientX - box.left - LEFT) / Math.max(box.width - LEFT - RIGHT, 1)) * this.last;
    return (this.stops ?? []).reduce((best, stop) => (best === null || Math.abs(stop - x) < Math.abs(best - x) ? stop : best), null);
  }

  read(generation) {
    if (this.at === generation) return;
    this.at = generation;
    this.drawCursor();
  }

  x(generation) { return LEFT + (generation / this.last) * Math.max(this.width - LEFT - RIGHT, 1); }
  y(value) { return TOP + (1 - value) * (HEIGHT - TOP - BOTTOM); }

  draw() {
    this.width = Math.round(this.svg.clientWidth) || 360;
    attribute(this.svg, "viewBox", `0 0 ${this.width} ${HEIGHT}`);
    const place = ([x, y]) => [this.x(x), this.y(y)];
    const parts = [];
    for (const value of [0, 0.25, 0.5, 0.75, 1]) {
      const y = this.y(value);
      parts.push(svg("line", { class: "tick", x1: LEFT, x2: this.width - RIGHT, y1: y, y2: y }),
        svg("text", { x: LEFT - 7, y: y + 4, "text-anchor": "end" }, this.format === percent ? percent(value) : String(value)));
    }
    const apart = step(this.last, Math.max(Math.floor(this.width / 90), 2));
    for (let x = 0; x <= this.last; x += apart) {
      parts.push(svg("text", { x: this.x(x), y: HEIGHT - BOTTOM + 16, "text-anchor": "middle" }, String(x)));
    }
    parts.push(svg("text", { x: this.width - RIGHT, y: HEIGHT - 3, "text-anchor": "end" }, "generation"));
    for (const s of this.series.filter((s) => s.band?.length > 1)) {
      const up = s.band.map(([x, , high]) => place([x, high])), down = s.band.map(([x, low]) => place([x, low])).reverse();
      parts.push(svg("path", { class: `band c${s.colour}`, d: `${path(up.concat(down))}Z` }));
    }
    for (const s of this.series) {
      const kind = `line c${s.colour}${s.thin ? " thin" : ""}${s.soft ? " soft" : ""}`;
      const until = s.ahead ?? Infinity;
      const sure = s.points.filter(([x]) => x <= until), ahead = s.points.filter(([x]) => x >= until);
      if (sure.length > 1) parts.push(svg("path", { class: kind, d: path(sure.map(place)), "data-points": s.points.length }));
      if (ahead.length > 1) parts.push(svg("path", { class: `${kind} ahead`, d: path(ahead.map(place)) }));
      if (s.points.length === 1) {
        const [x, y] = place(s.points[0]);
        parts.push(svg("circle", { class: `dot c${s.colour}`, cx: x, cy: y, r: 2.5, "data-points": 1 }));
      }
    }
    if (this.mark !== null) {
      parts.push(svg("line", { class: "mark", x1: this.x(this.mark), x2: this.x(this.mark), y1: TOP, y2: HEIGHT - BOTTOM }));
    }
    this.cursor = svg("g", {});
    this.svg.replaceChildren(...parts, this.cursor);
    const ends = this.series.filter((s) => !s.thin && s.points.length > 0).map((s) =>
      `${s.name} from ${this.format(s.points[0][1])} to ${this.format(s.points.at(-1)[1])} at generation ${s.points.at(-1)[0]}`);
    attribute(this.svg, "aria-label", `${this.title}. ${ends.length ? ends.join("; ") : "nothing yet"}. Arrow keys read values.`);
    this.drawCursor();
  }

  drawCursor() {
    if (!this.cursor) return;
    // What is pointed at or chosen; otherwise the last of each series.
    const generation = this.at ?? this.mark;
    const index = (s) => (generation === null ? s.points.length - 1 : s.points.findIndex(([x]) => x === generation));
    const shown = this.series.filter((s) => !s.thin).map((s) => ({ s, i: index(s) })).filter(({ i }) => i >= 0);
    const marks = this.at === null ? [] : [svg("line", { class: "cursor", x1: this.x(this.at), x2: this.x(this.at), y1: TOP, y2: HEIGHT - BOTTOM })];
    for (const { s, i } of this.at === null ? [] : shown) {
      marks.push(svg("circle", { class: `dot c${s.colour}`, cx: this.x(generation), cy: this.y(s.points[i][1]), r: 3.5 }));
    }
    this.cursor.replaceChildren(...marks);
    const words = shown.map(({ s, i }) => {
      const band = s.band?.[i];
      const spread = band && band[1] !== band[2] ? ` (${this.format(band[1])} to ${this.format(band[2])})` : "";
      return h("li", { class: `c${s.colour}` }, h("span", { class: "swatch" }), `${s.name} `, h("b", {}, this.format(s.points[i][1])), spread);
    });
    if (words.length) words.unshift(h("li", {}, generation === null ? "last" : "generation ", generation === null ? "" : h("b", {}, String(generation))));
    // Read aloud when somebody asked, not with every generation that lands.
    attribute(this.says, "aria-live", this.at === null ? "off" : "polite");
    this.says.replaceChildren(...words);
  }
}
