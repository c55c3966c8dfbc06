// Draws the strength of each drone's link over the last minutes.
"use strict";

const strips = {
  SPAN_S: 300,
  WIDTH: 300,
  HEIGHT: 44,
  // The strengths of the drones' links by number: [the station's time in s, dBm].
  seen: new Map(),

  // Takes what the station has heard before this page had its line: [number, [[ms, dBm], ...]] of each drone.
  begin(links) {
    this.seen = new Map(links.map(([node, points]) => [node, points.map(([ms, dbm]) => [ms / 1000, dbm])]));
  },

  // Keeps one strength a second, as drones say no more.
  note({ stamp, drones }) {
    const now = stamp / 1000;
    for (const { node, link, silent } of drones) {
      if (!this.seen.has(node)) this.seen.set(node, []);
      const points = this.seen.get(node);
      // A station that was restarted counts from zero again.
      if (points.length > 0 && points.at(-1)[0] > now) points.length = 0;
      if (link && !silent && !(now - points.at(-1)?.[0] < 1)) points.push([now, link.dbm]);
      while (points.length > 0 && points[0][0] < now - this.SPAN_S) points.shift();
    }
  },

  // The picture of one drone's link, newest at the right, with lines at both limits. `null` before there
  // is anything to see.
  of(node, stamp, base) {
    const points = this.seen.get(node) ?? [];
    if (points.length < 2) return null;
    const limits = base ? [base.launch_limit_dbm, base.retreat_limit_dbm] : [];
    const all = [...points.map(([, dbm]) => dbm), ...limits];
    const [low, high] = [Math.min(...all) - 2, Math.max(...all) + 2];
    const now = Math.floor(stamp / 1000);
    const x = (at) => (this.WIDTH * (1 - (now - at) / this.SPAN_S)).toFixed(1);
    const y = (dbm) => ((this.HEIGHT * (high - dbm)) / (high - low)).toFixed(1);
    const picture = svg("svg", { class: "strip", viewBox: `0 0 ${this.WIDTH} ${this.HEIGHT}`, preserveAspectRatio: "none", role: "img" });
    picture.setAttribute("aria-label", this.inWords(points, limits));
    limits.forEach((limit, n) => picture.append(svg("path", { class: n === 0 ? "launch" : "retreat", d: `M0 ${y(limit)}H${this.WIDTH}` })));
    // Where nothing was heard for 5 s the line has a gap.
    const line = points.map(([at, dbm], n) => `${n > 0 && at - points[n - 1][0] < 5 ? "L" : "M"}${x(at)} ${y(dbm)}`);
    picture.append(svg("path", { class: "strength", d: line.join("") }));
    return picture;
  },

  // In words of ten seconds, so that a screen reader is not told of each packet.
  inWords(points, [launch]) {
    const strengths = points.map(([, dbm]) => dbm);
    const weak = strengths.filter((dbm) => dbm < launch).length;
    const span = Math.round((points.at(-1)[0] - points[0][0]) / 10) * 10;
    return `Link over the last ${span} s: between ${Math.min(...strengths).toFixed(0)} and ${Math.max(...strengths).toFixed(0)} dBm, `
      + `weak for ${Math.round((100 * weak) / strengths.length / 10) * 10} % of them.`;
  },
};
