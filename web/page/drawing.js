// The panel in which the user draws a cave.
import { Board } from "./board.js";
import { at } from "./dom.js";
import { Sketch } from "./sketch.js";

const OTHERS = ["flight", "side", "more"]; // Parts of the page in whose place the panel stands.

const capital = (words) => words[0].toUpperCase() + words.slice(1);

export class Panel {
  // `check` answers with the scenario of a drawing or its mistake, `fly` flies the text of a scenario, and `pause` is
  // called with whether the panel is open.
  constructor({ check, fly, pause }) {
    Object.assign(this, { check, fly, pause, sketch: new Sketch(), turn: 0 });
    this.board = new Board(at("sketch"), this.sketch, () => this.tell());
    this.listen();
  }

  get isOpen() {
    return !at("drawing").hidden;
  }

  show(isOpen) {
    if (this.isOpen === isOpen) return;
    at("drawing").hidden = !isOpen;
    for (const id of OTHERS) at(id).hidden = isOpen;
    this.pause(isOpen);
    if (isOpen) this.tell();
  }

  draw() {
    this.board.draw();
  }

  // Says how the drawing stands, and returns its scenario, or what is wrong with it.
  async tell() {
    const { sketch, board } = this;
    const turn = ++this.turn;
    at("undo").disabled = sketch.earlier.length === 0;
    for (const id of ["back", "clear"]) at(id).disabled = sketch.galleries.length === 0;
    at("gallery-width-now").value = `${sketch.width.toFixed(1)} m`;
    const answer = sketch.legs.length ? await this.check({ width_m: sketch.width, galleries: sketch.galleries }) : {};
    // The drawing may have changed meanwhile.
    if (turn !== this.turn) return answer;
    const { mistake } = answer;
    board.wrong = mistake?.legs ?? [];
    at("sketch-words").className = mistake ? "bad" : "";
    at("sketch-words").textContent = mistake ? `${capital(mistake.line)}.` : this.hint();
    at("sketch").ariaLabel = `Your drawing: ${this.amount()}`;
    return answer;
  }

  amount() {
    const { length, legs } = this.sketch;
    return `${length.toFixed(1)} m of galleries in ${legs.length} ${legs.length === 1 ? "leg" : "legs"}`;
  }

  hint() {
    const { galleries, legs } = this.sketch;
    if (galleries.length === 0) return "Tap where the mouth of the cave is: the base stands there.";
    if (legs.length === 0) return "Tap the next corner of the gallery.";
    return `${this.amount()}. Tap the next corner, or tap a gallery to begin a branch there; drag a corner to move it.`;
  }

  // Draws a leg by numbers, for those who draw without a pointer.
  addLeg() {
    const { sketch, board } = this;
    const [length, degrees] = ["leg-length", "leg-way"].map((id) => Number(at(id).value));
    const way = degrees * Math.PI / 180;
    if (!sketch.pen) sketch.add([0, 0]);
    sketch.add([sketch.pen[0] + length * Math.cos(way), sketch.pen[1] + length * Math.sin(way)]);
    if (board.isOff(sketch.pen)) board.showAll();
  }

  listen() {
    const { sketch, board } = this;
    const click = (id, action) => at(id).addEventListener("click", action);
    const change = (id, action) => click(id, () => {
      action();
      this.tell();
    });
    click("draw", () => {
      this.show(true);
      at("drawing").scrollIntoView({ block: "nearest" });
    });
    click("close-drawing", () => this.show(false));
    change("undo", () => sketch.undo());
    change("back", () => sketch.back());
    change("clear", () => sketch.clear());
    change("add-leg", () => this.addLeg());
    click("nearer", () => board.zoom(1.4));
    click("farther", () => board.zoom(1 / 1.4));
    click("all-of-it", () => board.showAll());
    click("fly-it", async () => {
      const { text } = await this.tell();
      if (text) await this.fly(text);
    });
    at("gallery-width").addEventListener("input", () => {
      sketch.width = Number(at("gallery-width").value);
      this.tell();
    });
  }
}
