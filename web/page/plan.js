// The answer to the question how many relays a place needs, as the page shows it.
import { element } from "./dom.js";

// The elements of an answer: its lead, its table and its other sentences.
export function answered({ plan: { stands, links }, text }) {
  const [lead, , ...rest] = text.split("\n\n").flatMap((block, n) => (n === 1 ? [block] : block.split("\n"))).filter(Boolean);
  const name = (n) => (n === 0 ? "base" : n === stands.length - 1 ? "head" : `relay ${stands.length - 1 - n}`);
  const cell = (words) => element("td", { textContent: words });
  const line = (stand, n) => element("tr", {}, cell(name(n)), cell(stand.along_m.toFixed(1)), cell(n ? links[n - 1].length_m.toFixed(1) : ""),
    cell(n ? links[n - 1].strength_dbm.toFixed(1).replace("-", "−") : ""), cell(stand.station ?? ""));
  const heads = ["", "way, m", "link, m", "dBm", "place"].map((textContent) => element("th", { textContent }));
  const table = element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...stands.map(line)));
  return [
    element("p", { className: "lead", textContent: `${lead}.` }), element("div", { className: "table" }, table),
    ...rest.map((textContent) => element("p", { textContent: `${textContent}.` })),
  ];
}
