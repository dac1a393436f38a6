// The dashboard's page: which view an address means, and asking again and again while somebody looks.

import { h, say } from "./dom.js";
import { duration, count } from "./words.js";
import { overview } from "./overview.js";
import { experiment } from "./experiment.js";
import { replication } from "./replication.js";
import { individual } from "./individual.js";

const LIVE = 1500, STILL = 5000, LOST = 3000; // ms between questions
const VIEWS = [
  [/^\/$/, overview],
  [/^\/experiments\/([^/]+)$/, experiment],
  [/^\/experiments\/([^/]+)\/(\d+)(?:\/(\d+))?$/, replication],
  [/^\/experiments\/([^/]+)\/(\d+)\/(\d+)\/(\d+)$/, individual],
];
const element = (id) => document.getElementById(id);

export async function fetchJson(address) {
  const response = await fetch(address, { headers: { accept: "application/json" } });
  const answer = await response.json().catch(() => ({ error: `the answer to ${address} cannot be read` }));
  if (!response.ok) throw Object.assign(new Error(answer.error ?? response.statusText), { status: response.status });
  return answer;
}

let view = null, timer = null, asking = false, again = false;

function open(focus) {
  const found = VIEWS.map(([pattern, make]) => [location.pathname.match(pattern), make]).find(([match]) => match);
  if (!found) return;
  const [match, make] = found;
  const parts = match.slice(1).filter((part) => part !== undefined).map(decodeURIComponent);
  view = make(parts, { fetchJson, go });
  document.title = [...parts].reverse().concat("selftalk").join(" · ");
  const steps = [["selftalk", "/"], ...parts.map((part, i) => [part, "/experiments/" + parts.slice(0, i + 1).map(encodeURIComponent).join("/")])];
  element("path").replaceChildren(...steps.map(([name, href], i) =>
    h("li", {}, h("a", { href, "aria-current": i === steps.length - 1 ? "page" : null }, name))));
  element("main").replaceChildren(view.element);
  if (focus) {
    scrollTo(0, 0);
    element("main").focus();
  }
  ask();
}

export function go(address) {
  if (address !== location.pathname + location.hash) history.pushState(null, "", address);
  open(true);
}

// Asks what there is and shows it; one question at a time.
async function ask() {
  clearTimeout(timer);
  if (asking) {
    again = true;
    return;
  }
  asking = true;
  const shown = view;
  let wait = LOST;
  try {
    const now = await fetchJson("/api/overview");
    wait = now.live ? LIVE : STILL;
    status(now);
    await shown.update(now);
    document.documentElement.dataset.state = "shown";
  } catch (error) {
    if (error.status === 404) {
      shown.element.replaceChildren(h("p", { class: "bad" }, error.message), h("p", {}, h("a", { href: "/" }, "To all experiments")));
    } else {
      trouble(error);
    }
  }
  asking = false;
  if (again) {
    again = false;
    ask();
  } else if (document.visibilityState === "visible") {
    timer = setTimeout(ask, wait);
  }
}

function status(now) {
  const words = [];
  if (now.live) {
    const { workers, seconds_left: left } = now.live;
    words.push(workers.length ? count(workers.length, "worker") : "waiting for workers");
    if (left !== null) words.push(`about ${duration(left)} left`);
  } else {
    words.push("no master is running here: the file is only read");
  }
  element("status").className = now.live ? "live" : "";
  say(element("status"), words.join(" · "));
  say(element("foot"), `selftalk ${now.version} · ${now.file} · simulator ${now.fingerprint}`);
}

function trouble(error) {
  element("status").className = "lost";
  const words = error.status ? error.message : "no answer: the command has ended; `selftalk dashboard` shows its file";
  say(element("status"), words);
}

// Links within the dashboard do not load the page again; replays and all else do.
document.addEventListener("click", (event) => {
  const link = event.target.closest("a");
  const elsewhere = event.button !== 0 || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey;
  if (!link || elsewhere || link.target || link.origin !== location.origin) return;
  if (link.hash && link.pathname === location.pathname) return;
  if (!VIEWS.some(([pattern]) => pattern.test(link.pathname))) return;
  event.preventDefault();
  go(link.pathname + link.hash);
});
addEventListener("popstate", () => open(false));
document.addEventListener("visibilitychange", () => document.visibilityState === "visible" && ask());
open(false);
