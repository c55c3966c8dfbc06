// Draws the place and the drones on the canvas.
const MARGIN = 34; // Pixels round the place.
export const MARK = 10; // The radius of a drone's mark, pixels.
const MOST_ZOOM = 40;
const LEAST_HEIGHT = 260; // Pixels of the canvas.

export const colours = {};

// The colours of the style sheet, which are those of a light or of a dark page.
export function takeColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["rock", "floor", "wall", "centre", "ink", "paper", "head", "relay", "explorer", "unseen", "frontier", "base", "down", "good", "weak", "bad", "plan"]) {
    colours[name] = style.getPropertyValue(`--${name}`).trim();
  }
}

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.whole();
    this.pointers = new Map();
    this.listen();
  }

  show(setting) {
    this.setting = setting;
    const { outlines, centre_lines } = setting.place;
    const points = (outlines.length ? outlines : centre_lines).flat();
    const reach = (axis) => points.reduce(([a, b], at) => [Math.min(a, at[axis]), Math.max(b, at[axis])], [Infinity, -Infinity]);
    [this.xs, this.ys] = [reach(0), reach(1)];
    this.floor = path(outlines, true);
    this.lines = path(centre_lines, false);
    this.trails = setting.nodes.map(() => []);
    this.map = setting.mission === "explore" ? new TeamMap() : null;
    this.whole();
    this.shape();
  }

  // Makes the canvas as high as the place needs at this width, but for what the rest of the page needs.
  shape() {
    if (!this.setting) return;
    const span = ([a, b]) => Math.max(b - a, 1);
    const wanted = this.canvas.clientWidth * span(this.ys) / span(this.xs) + 2 * MARGIN;
    const most = Math.max(0.6 * window.innerHeight, LEAST_HEIGHT);
    this.canvas.style.height = `${Math.round(Math.min(Math.max(wanted, LEAST_HEIGHT), most))}px`;
  }

  whole() {
    [this.panned, this.follows] = [[0, 0], false];
    this.zoomTo(1);
  }

  // The metres-to-pixels transform: the whole place fits at zoom 1.
  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = window.devicePixelRatio || 1;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    }
    const span = ([a, b]) => Math.max(b - a, 1);
    const room = Math.min((width - 2 * MARGIN) / span(this.xs), (height - 2 * MARGIN - 14) / span(this.ys));
    this.scale = Math.min(room, 90) * this.zoom;
    const middle = [this.xs, this.ys].map(([a, b]) => (a + b) / 2);
    const head = this.follows && this.frame ? this.frame.drones[0] : null;
    this.centre = head ? [head.x, head.y] : [middle[0] - this.panned[0], middle[1] - this.panned[1]];
    this.size = [width, height];
    this.ratio = ratio;
  }

  pixel([x, y]) {
    return [this.size[0] / 2 + (x - this.centre[0]) * this.scale, this.size[1] / 2 - (y - this.centre[1]) * this.scale];
  }

  draw(frame, plan) {
    if (!this.setting || this.canvas.clientWidth === 0) return;
    this.frame = frame;
    this.fit();
    const g = this.context;
    g.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    g.fillStyle = colours.rock;
    g.fillRect(0, 0, ...this.size);
    this.place(g);
    if (frame) this.ways(g);
    if (plan) this.planned(g, plan);
    if (frame) {
      this.goals(g, frame);
      this.links(g, frame);
      this.drones(g, frame);
    }
    scaleBar(g, this.scale, this.size[1]);
  }

  place(g) {
    g.save();
    const [x, y] = this.pixel([0, 0]);
    g.transform(this.scale, 0, 0, -this.scale, x, y);
    g.fillStyle = this.map ? colours.unseen : colours.floor;
    g.fill(this.floor, "evenodd");
    this.map?.draw(g);
    g.lineJoin = "round";
    g.lineWidth = 2 / this.scale;
    g.strokeStyle = colours.wall;
    g.stroke(this.floor);
    g.lineWidth = 1 / this.scale;
    g.setLineDash([4 / this.scale, 5 / this.scale]);
    g.strokeStyle = colours.centre;
    g.stroke(this.lines);
    g.restore();
  }

  // Keeps what the ways and the explorers' map are drawn from, frame by frame.
  note(frame) {
    if (frame.map) this.map?.note(frame.map);
    frame.drones.forEach((drone, n) => {
      const trail = this.trails[n];
      const last = trail[trail.length - 1];
      if (!last || Math.hypot(last[0] - drone.x, last[1] - drone.y) > 0.15) trail.push([drone.x, drone.y]);
      if (trail.length > 4000) this.trails[n] = trail.filter((_, k) => k % 2 === 0);
    });
  }

  // In a chain all drones fly the head's way.
  ways(g) {
    const shown = this.setting.mission === "chain" ? this.trails.slice(0, 1) : this.trails;
    g.globalAlpha = 0.35;
    g.lineWidth = 2;
    shown.forEach((trail, n) => {
      g.strokeStyle = colours[kindOf(n, this.setting.nodes[n].role)];
      g.beginPath();
      trail.forEach((at) => g.lineTo(...this.pixel(at)));
      g.stroke();
    });
    g.globalAlpha = 1;
  }

  // Each link once, with the strength that the on-board filter of its weaker end says.
  links(g, frame) {
    for (const { from, to, dbm } of linksOf(frame)) {
      const [a, b] = [from, to].map((n) => this.pixel([frame.drones[n].x, frame.drones[n].y]));
      const grade = gradeOf(dbm, this.setting);
      g.strokeStyle = colours[grade];
      g.lineWidth = grade === "good" ? 3 : 4;
      g.setLineDash(grade === "good" ? [] : grade === "weak" ? [9, 5] : [2, 5]);
      g.beginPath();
      g.moveTo(...a);
      g.lineTo(...b);
      g.stroke();
      g.setLineDash([]);
      if (Math.hypot(a[0] - b[0], a[1] - b[1]) > 78) label(g, `${Math.round(dbm)} dBm`.replace("-", "−"), (a[0] + b[0]) / 2, (a[1] + b[1]) / 2);
    }
  }

  // The goals of explorers on their way, by their own estimates.
  goals(g, frame) {
    frame.drones.forEach(({ x, y, goal }, n) => {
      if (!goal) return;
      const [at, end] = [[x, y], goal].map((place) => this.pixel(place));
      const colour = colours[kindOf(n, this.setting.nodes[n].role)];
      g.setLineDash([2, 4]);
      stroke(g, at, end, colour, 1.25);
      g.setLineDash([]);
      stroke(g, [end[0] - 6, end[1]], [end[0] + 6, end[1]], colour, 2.5);
      stroke(g, [end[0], end[1] - 6], [end[0], end[1] + 6], colour, 2.5);
    });
  }

  // A mark that would cover another is drawn beside it, with a line to its place. The head comes first.
  drones(g, frame) {
    const placed = [];
    frame.drones.forEach((drone, n) => {
      const at = this.pixel([drone.x, drone.y]);
      const mark = this.freePlace(at, placed);
      placed.push(mark);
      if (mark !== at) stroke(g, at, mark, colours.ink, 1);
      this.mark(g, mark, drone, n);
    });
  }

  // The place nearest to this one, in steps, that no mark covers and that lies on the canvas.
  freePlace(at, placed) {
    const isOn = ([x, y]) => x >= MARK && y >= MARK && x <= this.size[0] - MARK && y <= this.size[1] - MARK;
    const isFree = ([x, y]) => placed.every((other) => Math.hypot(x - other[0], y - other[1]) >= 2 * MARK + 1);
    if (!isOn(at) || isFree(at)) return at;
    for (let far = 1; far < 60; far++) {
      for (const [x, y] of [[0, 1], [0, -1], [1, 0], [-1, 0], [1, 1], [-1, -1], [1, -1], [-1, 1]]) {
        const place = [at[0] + x * far * MARK, at[1] + y * far * MARK];
        if (isOn(place) && isFree(place)) return place;
      }
    }
    return at;
  }

  mark(g, [x, y], drone, n) {
    const { role } = this.setting.nodes[n];
    const flies = drone.z > 0.05;
    const colour = drone.lost ? colours.down : colours[kindOf(n, role)];
    g.lineWidth = 2;
    g.strokeStyle = colour;
    g.fillStyle = flies || role === "base" ? colour : colours.paper;
    if (role !== "base" && !drone.lost) {
      const nose = [x + Math.cos(drone.yaw) * (MARK + 6), y - Math.sin(drone.yaw) * (MARK + 6)];
      stroke(g, [x, y], nose, colour, 3);
    }
    g.beginPath();
    if (role === "base") g.rect(x - MARK, y - MARK, 2 * MARK, 2 * MARK);
    else g.arc(x, y, MARK, 0, 2 * Math.PI);
    g.fill();
    g.strokeStyle = flies || role === "base" ? colours.paper : colour;
    g.stroke();
    g.fillStyle = flies || role === "base" ? colours.paper : colour;
    text(g, drone.lost ? "×" : letter(n, role), x, y);
  }

  planned(g, plan) {
    const stands = plan.stands.map((stand) => this.pixel([stand.x_m, stand.y_m]));
    g.setLineDash([3, 4]);
    stands.slice(1).forEach((at, n) => stroke(g, stands[n], at, colours.plan, 2));
    g.setLineDash([]);
    stands.forEach(([x, y], n) => {
      g.fillStyle = colours.paper;
      g.strokeStyle = colours.plan;
      g.lineWidth = 2;
      g.beginPath();
      g.moveTo(x, y - MARK);
      g.lineTo(x + MARK, y);
      g.lineTo(x, y + MARK);
      g.lineTo(x - MARK, y);
      g.closePath();
      g.fill();
      g.stroke();
      g.fillStyle = colours.plan;
      text(g, n === 0 ? "B" : n === stands.length - 1 ? "H" : String(stands.length - 1 - n), x, y);
    });
  }

  // Drag moves the picture, the wheel and two fingers zoom, a double click shows the whole place.
  listen() {
    const { canvas, pointers } = this;
    const metres = (event, other) => [(event.clientX - other.clientX) / this.scale, (other.clientY - event.clientY) / this.scale];
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, event);
    });
    const gone = (event) => pointers.delete(event.pointerId);
    canvas.addEventListener("pointerup", gone);
    canvas.addEventListener("pointercancel", gone);
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before || !this.scale) return;
      const apart = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY); };
      const distance = pointers.size === 2 ? apart() : 0;
      pointers.set(event.pointerId, event);
      if (distance > 0) this.zoomBy(apart() / distance);
      else if (this.follows) this.unfollow();
      else this.panned = this.panned.map((value, axis) => value + metres(event, before)[axis]);
    });
    canvas.addEventListener("wheel", (event) => {
      // At the whole place the wheel scrolls the page on.
      const before = this.zoom;
      this.zoomBy(Math.exp(-event.deltaY / 400));
      if (this.zoom !== before) event.preventDefault();
    }, { passive: false });
    canvas.addEventListener("dblclick", () => this.whole());
    window.addEventListener("resize", () => this.shape());
  }

  zoomBy(factor) {
    this.zoomTo(Math.min(Math.max(this.zoom * factor, 1), MOST_ZOOM));
  }

  // A finger scrolls the page while the whole place is shown, and else moves the map.
  zoomTo(zoom) {
    this.zoom = zoom;
    this.canvas.style.touchAction = zoom > 1 ? "none" : "pan-y";
  }

  // Stays where it is instead of following the head.
  unfollow() {
    const middle = [this.xs, this.ys].map(([a, b]) => (a + b) / 2);
    [this.panned, this.follows] = [middle.map((value, axis) => value - this.centre[axis]), false];
  }
}

// The map that explorers have drawn together, a pixel of a picture for each cell.
class TeamMap {
  note({ corner, side, columns, rows, cells, grounds }) {
    if (!this.canvas) {
      [this.corner, this.side] = [corner, side];
      this.canvas = new OffscreenCanvas(columns, rows);
      this.context = this.canvas.getContext("2d");
      this.known = new Map();
    }
    cells.forEach((cell, n) => {
      this.known.set(cell, grounds[n]);
      this.paint(cell, grounds[n]);
    });
  }

  paint(cell, ground) {
    const { width } = this.canvas;
    const at = [cell % width, Math.floor(cell / width), 1, 1];
    this.context.fillStyle = { free: colours.floor, frontier: colours.frontier, wall: colours.wall }[ground];
    if (ground === "unknown") this.context.clearRect(...at); else this.context.fillRect(...at);
  }

  draw(g) {
    if (!this.canvas) return;
    if (this.floor !== colours.floor) {
      // The page has become light or dark since.
      this.floor = colours.floor;
      for (const [cell, ground] of this.known) this.paint(cell, ground);
    }
    const { width, height } = this.canvas;
    g.imageSmoothingEnabled = false;
    g.drawImage(this.canvas, this.corner[0], this.corner[1], width * this.side, height * this.side);
  }
}

function path(lines, isClosed) {
  const found = new Path2D();
  for (const line of lines) {
    line.forEach((at, n) => (n ? found.lineTo(...at) : found.moveTo(...at)));
    if (isClosed) found.closePath();
  }
  return found;
}

// A bar of a round number of metres at the lower left, on a canvas of this height in pixels.
export function scaleBar(g, scale, height) {
  const metres = [0.5, 1, 2, 5, 10, 20, 50, 100, 200].find((each) => each * scale >= 60) ?? 500;
  const [x, y] = [14, height - 12];
  stroke(g, [x, y], [x + metres * scale, y], colours.ink, 2);
  g.fillStyle = colours.ink;
  g.textAlign = "left";
  g.font = "12px system-ui, sans-serif";
  g.textBaseline = "alphabetic";
  g.fillText(`${metres} m`, x, y - 6);
}

export function stroke(g, from, to, colour, width) {
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.beginPath();
  g.moveTo(...from);
  g.lineTo(...to);
  g.stroke();
}

export function text(g, words, x, y) {
  g.font = "bold 12px system-ui, sans-serif";
  g.textAlign = "center";
  g.textBaseline = "middle";
  g.fillText(words, x, y + 0.5);
}

export function label(g, words, x, y) {
  g.font = "12px system-ui, sans-serif";
  g.textAlign = "center";
  g.textBaseline = "middle";
  const width = g.measureText(words).width + 8;
  g.fillStyle = colours.paper;
  g.globalAlpha = 0.85;
  g.fillRect(x - width / 2, y - 9, width, 18);
  g.globalAlpha = 1;
  g.fillStyle = colours.ink;
  g.fillText(words, x, y + 0.5);
}

export const letter = (n, role) => (role === "base" ? "B" : role === "head" && n === 0 ? "H" : String(n));
export const kindOf = (n, role) => (role === "drone" || (role === "head" && n > 0) ? "explorer" : role);

// Where a strength stands between the limits: good above the launch limit, bad below the retreat limit.
export const gradeOf = (dbm, { launch_dbm, retreat_dbm }) =>
  dbm >= launch_dbm ? "good" : dbm >= retreat_dbm ? "weak" : "bad";

export function linksOf({ drones }) {
  const found = new Map();
  drones.forEach((drone, n) => {
    for (const link of [drone.front, drone.back]) {
      if (!link || link.dbm === null || drone.lost || !drones[link.peer]) continue;
      const [from, to] = [Math.min(n, link.peer), Math.max(n, link.peer)];
      const known = found.get(`${from} ${to}`);
      if (!known || known.dbm > link.dbm) found.set(`${from} ${to}`, { from, to, dbm: link.dbm });
    }
  });
  return [...found.values()];
}
