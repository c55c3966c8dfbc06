// Draws the chain on its map: the plan of the place, or a straight line as long as the way flown.
"use strict";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = 26; // Pixels round the map, for half a mark and its name.
const HIGHEST = 420; // Pixels; a map that would be taller is drawn narrower.
const LOWEST = 106; // Pixels; a flatter map has room for three rows of marks all the same.
const FOOT = 18; // Pixels below the map, for the scale bar.
const MARK = 11; // The radius of a drone's mark in pixels.
const APART = 2 * MARK + 4; // The least distance of two marks, across or along, with their outlines.

// Where a mark may be drawn whose place is taken, nearest first: steps of half a mark, across and along.
const ASIDE = Array.from({ length: 81 * 41 }, (_, n) => [n % 81 - 40, Math.floor(n / 81) - 20])
  .map(([across, along]) => [(across * APART) / 2, (along * APART) / 2])
  .sort((a, b) => Math.hypot(...a) - Math.hypot(...b));

const chainMap = {
  plan: null,
  // What the drawn plan was made for: it is drawn anew when the width or the line changes.
  drawn: "",
  pixel: null,

  show(status) {
    this.fit(status.map);
    this.drones(status);
    const words = mapWords(status);
    const map = document.getElementById("map");
    if (map.getAttribute("aria-label") !== words) map.setAttribute("aria-label", words);
  },

  // Chooses the scale and draws what does not move.
  fit(line) {
    const map = document.getElementById("map");
    const width = map.clientWidth;
    // The style sheet may want it lower.
    const highest = Math.min(HIGHEST, parseFloat(getComputedStyle(map).maxHeight) || HIGHEST);
    const key = JSON.stringify([width, highest, line, this.plan !== null]);
    if (width === 0 || key === this.drawn) return;
    this.drawn = key;
    const lines = this.plan ? this.plan.lines.map((each) => each.points) : [[line.base, line.end]];
    const outlines = this.plan ? this.plan.outlines : [];
    const all = [...lines, ...outlines].flat();
    const [xs, ys] = [all.map(([x]) => x), all.map(([, y]) => y)];
    const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
    const most = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
    const [left, right, bottom, top] = [least(xs), most(xs), least(ys), most(ys)];
    const room = [width - 2 * MARGIN, highest - 2 * MARGIN - FOOT];
    const scale = Math.min(room[0] / Math.max(right - left, 1), room[1] / Math.max(top - bottom, 1));
    const spare = (room[0] - (right - left) * scale) / 2;
    const needed = (top - bottom) * scale + 2 * MARGIN;
    this.size = [width, Math.max(needed, LOWEST)];
    const above = MARGIN + (this.size[1] - needed) / 2;
    this.pixel = ([x, y]) => [MARGIN + spare + (x - left) * scale, above + (top - y) * scale];
    const height = this.size[1] + FOOT;
    map.setAttribute("viewBox", `0 0 ${width} ${height}`);
    map.style.height = `${height}px`;
    const still = svg("g", {});
    const path = (points, end) => `M${points.map((point) => this.pixel(point).map((v) => v.toFixed(1))).join("L")}${end}`;
    still.append(svg("path", { class: "floor", d: outlines.map((each) => path(each, "Z")).join("") }));
    still.append(svg("path", { class: "centre", d: lines.map((each) => path(each, "")).join("") }));
    still.append(...scaleBar(scale, height));
    map.replaceChildren(still, svg("g", { id: "map-links" }), svg("g", { id: "map-drones" }));
  },

  drones(status) {
    if (!this.pixel) return;
    const base = { node: status.base?.node ?? null, at: status.map.base };
    const placeOf = (node) => status.drones.find((drone) => drone.node === node) ?? (node === base.node ? base : null);
    const links = status.drones.flatMap((drone) => {
      const to = drone.link && placeOf(drone.link.to);
      if (!to) return [];
      const [[x1, y1], [x2, y2]] = [this.pixel(drone.at), this.pixel(to.at)];
      const grade = drone.silent ? "unknown" : drone.link.grade.replace(" ", "-");
      return [svg("line", { x1, y1, x2, y2, class: `link ${grade}` })];
    });
    document.getElementById("map-links").replaceChildren(...links);
    const marks = [{ at: base.at, name: "B", kind: "base" }, ...status.drones.map((drone) => ({
      at: drone.at,
      name: drone.node === 0 ? "H" : String(drone.node),
      kind: drone.fault || drone.silent ? "drone bad" : drone.airborne ? "drone airborne" : "drone",
    }))];
    const places = this.apart(marks.map(({ at }) => this.pixel(at)));
    const leaders = marks.flatMap(({ at }, n) => this.leader(this.pixel(at), places[n]));
    document.getElementById("map-drones").replaceChildren(...leaders, ...marks.map(({ name, kind }, n) => this.mark(places[n], name, kind)));
  },

  // The places at which marks are drawn, so that none covers another: at its own place, or at the nearest
  // one that is free. The first marks have the first choice.
  apart(places) {
    const taken = [];
    const isFree = ([x, y]) => taken.every(([a, b]) => Math.max(Math.abs(x - a), Math.abs(y - b)) >= APART);
    const [right, bottom] = this.size.map((length) => length - MARGIN / 2);
    const isOn = ([x, y]) => x >= MARGIN / 2 && x <= right && y >= MARGIN / 2 && y <= bottom;
    for (const [x, y] of places) {
      const beside = ([across, along]) => [x + across, y + along];
      const found = ASIDE.find((step) => isFree(beside(step)) && isOn(beside(step)));
      taken.push(beside(found ?? ASIDE[0]));
    }
    return taken;
  },

  // A line from a drone's place to its mark, if that is drawn beside it.
  leader([x1, y1], [x2, y2]) {
    return x1 === x2 && y1 === y2 ? [] : [svg("line", { class: "leader", x1, y1, x2, y2 })];
  },

  mark([x, y], name, kind) {
    const group = svg("g", { class: `mark ${kind}`, transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})` });
    const square = { x: -MARK, y: -MARK, width: 2 * MARK, height: 2 * MARK };
    group.append(kind === "base" ? svg("rect", square) : svg("circle", { r: MARK }));
    const label = svg("text", { "text-anchor": "middle", y: 4 });
    label.textContent = name;
    group.append(label);
    return group;
  },
};

function svg(tag, attributes) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

// A bar of 1, 2 or 5 times a power of ten metres, at most 120 pixels long.
function scaleBar(scale, height) {
  const power = 10 ** Math.floor(Math.log10(120 / scale));
  const metres = [5, 2, 1].find((times) => times * power * scale <= 120) * power;
  const [x, y] = [MARGIN, height - 8];
  const label = svg("text", { x: x + metres * scale + 6, y: y + 4 });
  label.textContent = `${metres} m`;
  return [svg("path", { class: "scale", d: `M${x} ${y - 4}v4h${metres * scale}v-4` }), label];
}

// The map in words, in whole metres, so that it changes no more often than it must.
function mapWords({ drones, base }) {
  const each = drones.map((drone) =>
    `${drone.name} ${Math.round(drone.way_m)} m from the base${drone.silent ? ", silent" : ""}`);
  const first = base ? `The base is node ${base.node}. ` : "";
  return `Map of the chain. ${first}${each.length ? `${each.join("; ")}.` : "No drone is heard."}`;
}
