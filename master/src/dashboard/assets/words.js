// How numbers and times are said.

export const fitness = (value) => (value === null || value === undefined ? "" : value.toFixed(4));
export const short = (value) => (value === null || value === undefined ? "" : value.toFixed(3));
export const percent = (share) => `${(100 * share).toFixed(0)} %`;
export const count = (number, one, many = `${one}s`) => `${number.toLocaleString("en")} ${number === 1 ? one : many}`;

export function rate(value) {
  if (value === null || value === undefined) return "…";
  return value >= 100 ? value.toFixed(0) : value.toFixed(1);
}

export function duration(seconds) {
  if (seconds === null || seconds === undefined) return "…";
  if (seconds < 90) return `${Math.max(Math.round(seconds), 0)} s`;
  const minutes = Math.ceil(seconds / 60);
  if (minutes < 60) return `${minutes} min`;
  const hours = Math.floor(minutes / 60);
  if (hours < 48) return `${hours} h ${minutes % 60} min`;
  return `${Math.floor(hours / 24)} d ${hours % 24} h`;
}

export const ago = (seconds) => (seconds < 1 ? "now" : `${duration(seconds)} ago`);
// 2026-01-31T12:00:00Z as 2026-01-31 12:00 UTC.
export const time = (text) => (text ? `${text.slice(0, 10)} ${text.slice(11, 16)} UTC` : "");

export const path = (...parts) => "/experiments/" + parts.map(encodeURIComponent).join("/");
export const state = (name) => (name === "unfinished" ? "not finished" : name);
