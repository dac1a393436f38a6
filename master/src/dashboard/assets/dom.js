// Making and updating elements. Text is always set as text.

const SVG = "http://www.w3.org/2000/svg";

function dress(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

export const h = (tag, attributes, ...children) => dress(document.createElement(tag), attributes, children);
export const svg = (tag, attributes, ...children) => dress(document.createElementNS(SVG, tag), attributes, children);

// Sets text only when it changes: readers of the screen are not disturbed, and nothing is laid out again.
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

export function attribute(element, name, value) {
  if (value === null || value === undefined) element.removeAttribute(name);
  else if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

// Brings the children of `parent` into line with `items`, keeping those that stay, so that focus stays with them.
export function keyed(parent, items, key, create, update) {
  const there = new Map([...parent.children].map((child) => [child.dataset.key, child]));
  items.forEach((item, at) => {
    const name = String(key(item));
    let child = there.get(name);
    if (!child) {
      child = create(item);
      child.dataset.key = name;
    }
    there.delete(name);
    update?.(child, item);
    if (parent.children[at] !== child) parent.insertBefore(child, parent.children[at] ?? null);
  });
  for (const child of there.values()) child.remove();
}

// A table with a caption; columns are [heading, cell, numeric, wide]: wide ones are for wide screens.
export function table(caption, columns, rows, marked) {
  const kind = (numeric, wide) => [numeric && "n", wide && "wide"].filter(Boolean).join(" ") || null;
  const cells = (row) => columns.map(([, cell, numeric, wide], at) => {
    const content = cell(row);
    const tag = at === 0 ? "th" : "td";
    return h(tag, { scope: at === 0 ? "row" : null, class: kind(numeric, wide) }, content ?? "");
  });
  const heads = columns.map(([name, , numeric, wide]) => h("th", { scope: "col", class: kind(numeric, wide) }, name));
  const body = rows.map((row) => h("tr", { "aria-current": marked?.(row) ? "true" : null }, ...cells(row)));
  return h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": caption },
    h("table", {}, h("caption", {}, caption), h("thead", {}, h("tr", {}, ...heads)), h("tbody", {}, ...body)));
}

// A bar that is full to a share; drawn, as the policy of the pages allows no styles in the markup.
export function bar() {
  const full = svg("rect", { height: 6, width: 0 });
  const element = svg("svg", { class: "bar", viewBox: "0 0 100 6", preserveAspectRatio: "none", "aria-hidden": "true" }, full);
  return { element, set: (share) => attribute(full, "width", (100 * Math.min(Math.max(share, 0), 1)).toFixed(2)) };
}

// Tiles of facts: [name, value, small print].
export function tiles(facts) {
  return h("dl", { class: "tiles" }, ...facts.map(([name, value, small]) =>
    h("div", {}, h("dt", {}, name), h("dd", {}, value, small ? h("small", {}, ` ${small}`) : null))));
}
