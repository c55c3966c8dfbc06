// The canvas on which a cave is drawn: what it shows, and what fingers and the mouse do on it.
import { MARK, colours, label, scaleBar, stroke, text } from "./draw.js";
import { distance } from "./sketch.js";

const FINGER = 16; // Pixels by which a tap may miss.
const STILL = 6; // Pixels that a tap may move.
const [LEAST_SCALE, MOST_SCALE] = [4, 80]; // Pixels a metre.

export class Board {
  // `changed` is called when the drawing has changed.
  constructor(canvas, sketch, changed) {
    Object.assign(this, { canvas, sketch, changed, wrong: [], centre: [0, 0], scale: 0, pointers: new Map(), press: null, hover: null });
    this.context = canvas.getContext("2d");
    this.listen();
  }

  get size() {
    return [this.canvas.clientWidth, this.canvas.clientHeight];
  }

  pixel([x, y]) {
    const [width, height] = this.size;
    return [width / 2 + (x - this.centre[0]) * this.scale, height / 2 - (y - this.centre[1]) * this.scale];
  }

  // The place under a pointer, metres.
  place({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect();
    const [width, height] = this.size;
    return [this.centre[0] + (clientX - box.left - width / 2) / this.scale, this.centre[1] - (clientY - box.top - height / 2) / this.scale];
  }

  isOff(at) {
    const [x, y] = this.pixel(at);
    return !(x >= 0 && y >= 0 && x <= this.size[0] && y <= this.size[1]);
  }

  meant(place) {
    return this.sketch.meant(place, FINGER / this.scale);
  }

  // Zooms, so that what is at this place stays there.
  zoom(factor, place = this.centre) {
    const before = this.scale;
    this.scale = Math.min(Math.max(before * factor, LEAST_SCALE), MOST_SCALE);
    this.centre = this.centre.map((value, axis) => place[axis] + (value - place[axis]) * before / this.scale);
  }

  showAll() {
    const [width, height] = this.size;
    const { corners } = this.sketch;
    const reach = (axis) => corners.map((at) => at[axis]);
    const [xs, ys] = [0, 1].map((axis) => [Math.min(0, ...reach(axis)), Math.max(0, ...reach(axis))]);
    const room = Math.min(width / (xs[1] - xs[0] + 8), height / (ys[1] - ys[0] + 8));
    this.centre = [xs, ys].map(([a, b]) => (a + b) / 2);
    this.scale = Math.min(Math.max(room, LEAST_SCALE), Math.max(width / 36, 14));
  }

  // ---- What it shows ------------------------------------------------------------------------

  draw() {
    const { canvas, context: g } = this;
    const [width, height] = this.size;
    if (width === 0) return;
    if (this.scale === 0) this.showAll();
    const ratio = window.devicePixelRatio || 1;
    const pixels = [width, height].map((each) => Math.round(each * ratio));
    if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) [canvas.width, canvas.height] = pixels;
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.fillStyle = colours.rock;
    g.fillRect(0, 0, width, height);
    this.galleries(g);
    this.grid(g);
    this.marks(g);
    const drawn = this.next(g);
    this.lengths(g, drawn ? [drawn] : []);
    scaleBar(g, this.scale, height);
  }

  // The free space: straight walls, sharp outer corners, and ends half a width beyond the last corner.
  galleries(g) {
    const way = new Path2D();
    for (const corners of this.sketch.galleries) corners.forEach((at, n) => way[n ? "lineTo" : "moveTo"](...this.pixel(at)));
    const wide = this.sketch.width * this.scale;
    Object.assign(g, { lineJoin: "miter", lineCap: "square" });
    for (const [colour, lineWidth] of [[colours.wall, wide + 4], [colours.floor, wide]]) {
      Object.assign(g, { strokeStyle: colour, lineWidth });
      g.stroke(way);
    }
    Object.assign(g, { lineCap: "butt", strokeStyle: colours.centre, lineWidth: 1.5 });
    g.stroke(way);
  }

  // A line each metre where there is room, and a stronger one every five metres.
  grid(g) {
    const [width, height] = this.size;
    const step = this.scale >= 10 ? 1 : 5;
    this.size.forEach((size, axis) => {
      const half = size / 2 / this.scale;
      for (let metres = Math.ceil((this.centre[axis] - half) / step) * step; metres < this.centre[axis] + half; metres += step) {
        const [x, y] = this.pixel([metres, metres]);
        g.globalAlpha = metres % 5 === 0 ? 0.35 : 0.12;
        stroke(g, axis ? [0, y] : [x, 0], axis ? [width, y] : [x, height], colours.ink, 1);
      }
    });
    g.globalAlpha = 1;
  }

  marks(g) {
    const { legs, corners } = this.sketch;
    g.setLineDash([7, 5]);
    for (const { gallery, n, from, to } of legs) {
      if (this.wrong.some(([a, b]) => a === gallery && b === n)) stroke(g, this.pixel(from), this.pixel(to), colours.bad, 5);
    }
    g.setLineDash([]);
    corners.slice(1).forEach((at) => this.dot(g, at, 4, colours.ink));
    if (corners.length === 0) return;
    const [x, y] = this.pixel(corners[0]);
    g.fillStyle = colours.base;
    g.fillRect(x - MARK, y - MARK, 2 * MARK, 2 * MARK);
    g.fillStyle = colours.paper;
    text(g, "B", x, y);
  }

  // Shows the pen, and the leg that is being drawn or the place at which a tap would put the pen; returns the leg.
  next(g) {
    const { pen } = this.sketch;
    if (!pen) return null;
    this.ring(g, pen, MARK + 5);
    const at = this.press?.isDrawing ? this.press.at : this.press ? null : this.hover;
    const meant = at && !this.press ? this.meant(at) : null;
    if (meant) this.ring(g, meant, MARK);
    if (!at || meant) return null;
    g.setLineDash([8, 5]);
    stroke(g, this.pixel(pen), this.pixel(at), colours.head, 3);
    g.setLineDash([]);
    return { from: pen, to: at };
  }

  // The length of each leg beside it, but where it would cover another one. That of the leg that is being drawn
  // comes first.
  lengths(g, drawn) {
    const placed = [];
    const long = this.sketch.legs.filter(({ from, to }) => distance(from, to) * this.scale > 44);
    for (const { from, to } of [...drawn, ...long]) {
      const [x, y] = this.beside(from, to);
      if (placed.some((other) => Math.abs(other[0] - x) < 50 && Math.abs(other[1] - y) < 20)) continue;
      placed.push([x, y]);
      label(g, `${distance(from, to).toFixed(1)} m`, x, y);
    }
  }

  // The pixel beside the middle of a leg at which a label covers neither the leg nor its gallery.
  beside(from, to) {
    const [a, b] = [this.pixel(from), this.pixel(to)];
    const long = Math.max(distance(a, b), 1);
    const [x, y] = [(a[1] - b[1]) / long, (b[0] - a[0]) / long];
    const off = this.sketch.width * this.scale / 2 + 12 + 14 * Math.abs(x);
    return [(a[0] + b[0]) / 2 + x * off, (a[1] + b[1]) / 2 + y * off];
  }

  dot(g, at, radius, colour) {
    g.fillStyle = colour;
    g.beginPath();
    g.arc(...this.pixel(at), radius, 0, 2 * Math.PI);
    g.fill();
  }

  ring(g, at, radius) {
    Object.assign(g, { strokeStyle: colours.head, lineWidth: 3 });
    g.beginPath();
    g.arc(...this.pixel(at), radius, 0, 2 * Math.PI);
    g.stroke();
  }

  // ---- What the user does on it -------------------------------------------------------------

  listen() {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => {
      this.pointers.delete(event.pointerId);
      this.press = null;
    });
    canvas.addEventListener("pointerleave", () => { this.hover = null; });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY / 400), this.place(event));
    }, { passive: false });
  }

  down(event) {
    if (event.button !== 0) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, event);
    // Two fingers move and zoom the view.
    if (this.pointers.size > 1) this.press = null;
    else this.press = { from: event, at: this.place(event), meant: this.meant(this.place(event)), isDrawing: false, corner: null };
    if (this.press && !this.press.meant) this.press.isDrawing = true;
  }

  moved(event) {
    if (event.pointerType === "mouse") this.hover = this.place(event);
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    if (this.pointers.size === 2) return this.pinched(event);
    const { press } = this;
    if (!press) return;
    press.at = this.place(event);
    const far = distance([event.clientX, event.clientY], [press.from.clientX, press.from.clientY]) > STILL;
    if (far && press.meant && !press.corner && !press.isDrawing) this.pull(press);
    if (press.corner) press.corner = this.sketch.move(press.corner, press.at);
  }

  // A corner that is pulled moves; from a place between two corners, a branch is drawn.
  pull(press) {
    if (this.sketch.isCorner(press.meant)) {
      this.sketch.keep();
      press.corner = press.meant;
    } else {
      this.sketch.pen = press.meant;
      press.isDrawing = true;
    }
  }

  pinched(event) {
    const middle = () => {
      const [a, b] = [...this.pointers.values()];
      const apart = Math.max(distance([a.clientX, a.clientY], [b.clientX, b.clientY]), 1);
      return { apart, at: { clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2 } };
    };
    const before = middle();
    const held = this.place(before.at);
    this.pointers.set(event.pointerId, event);
    const now = middle();
    this.zoom(now.apart / before.apart, held);
    const slid = this.place(now.at);
    this.centre = this.centre.map((value, axis) => value + held[axis] - slid[axis]);
  }

  up(event) {
    this.pointers.delete(event.pointerId);
    const { press } = this;
    this.press = null;
    if (!press) return;
    if (press.isDrawing) this.sketch.add(this.place(event));
    else if (!press.corner) this.sketch.pen = press.meant;
    this.changed();
  }
}
