// Draws the chain on its map: the plan of the place, or a straight line as long as the way flown.
"use strict";

const SVG = "http://www.w3.org/2000/svg";
const MARGIN = 26; // Pixels round the map, for half a mark and its name.
const HIGHEST = 420; // Pixels; a map that would be taller is drawn narrower.
const MARK = 11; // The radius of a drone's mark in pixels.

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
    const key = JSON.stringify([width, line, this.plan !== null]);
    if (width === 0 || key === this.drawn) return;
    this.drawn = key;
    const lines = this.plan ? this.plan.lines.map((each) => each.points) : [[line.base, line.end]];
    const outlines = this.plan ? this.plan.outlines : [];
    const all = [...lines, ...outlines].flat();
    const [xs, ys] = [all.map(([x]) => x), all.map(([, y]) => y)];
    const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
    const most = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
    const [left, right, bottom, top] = [least(xs), most(xs), least(ys), most(ys)];
    const room = [width - 2 * MARGIN, HIGHEST - 2 * MARGIN];
    const scale = Math.min(room[0] / Math.max(right - left, 1), room[1] / Math.max(top - bottom, 1));
    const spare = (room[0] - (right - left) * scale) / 2;
    this.pixel = ([x, y]) => [MARGIN + spare + (x - left) * scale, MARGIN + (top - y) * scale];
    const height = (top - bottom) * scale + 2 * MARGIN + 18;
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
    const marks = status.drones.map((drone) => this.mark(drone.at, drone.node === 0 ? "H" : String(drone.node),
      drone.fault || drone.silent ? "drone bad" : drone.airborne ? "drone airborne" : "drone"));
    // The head comes last, so that it is seen where drones stand at one place.
    document.getElementById("map-drones").replaceChildren(this.mark(base.at, "B", "base"), ...marks.reverse());
  },

  mark(at, name, kind) {
    const [x, y] = this.pixel(at);
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
