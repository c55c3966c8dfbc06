// Flies the head by a gamepad. While the right shoulder button is held the head flies as the stick
// says. When it is let go, or the gamepad is unplugged, the head stops and hovers.
"use strict";

// The standard layout: https://www.w3.org/TR/gamepad/#remapping
const SHOULDER = 5;
const FORWARD = 1; // The left stick's vertical axis, negative away from the pilot.
const STICK_MS = 100;
// For so long a hold is tried again; the station takes a page of which it sees nothing for gone then,
// and the head hovers without it.
const HOLD_MS = 1500;

const gamepad = {
  // The speed that the stick says; null while the button is not held.
  stick: null,
  // When the stick began to say so, and when it was read last.
  changed: 0,
  read: performance.now(),
  // What the station was told of it, and by which request; undefined where it does not know it.
  told: null,
  seq: null,
  // An order by key or button takes the head from the gamepad, until its button is let go.
  isOverruled: false,

  // Reads the stick. What it says is an act of this moment: where it did not go out, or was refused,
  // it goes out again as it is then.
  look() {
    const [before, now] = [this.read, performance.now()];
    this.read = now;
    const pad = navigator.getGamepads().find((pad) => pad?.buttons[SHOULDER]?.pressed);
    if (this.isOverruled) {
      this.isOverruled = Boolean(pad);
      return;
    }
    const steps = pad ? Math.round((-pad.axes[FORWARD] * at("speed").max) / SPEED_STEP) : 0;
    const stick = pad ? steps * SPEED_STEP : null;
    if (stick !== this.stick) [this.stick, this.changed] = [stick, now];
    const isOver = stick === null && now - this.changed > HOLD_MS;
    if (isOver || !steers) this.told = stick;
    if (stick === this.told) return;
    this.seq = stick === null ? order("hold", {}, before) : order("explore", { speed: stick }, before);
    this.told = this.seq === null ? undefined : stick;
  },

  // An order by key or button is given instead.
  overrule() {
    if (this.stick !== null) this.isOverruled = true;
    [this.stick, this.told, this.seq] = [null, null, null];
  },

  // The request of this number was refused, or lost with its line.
  missed(seq) {
    if (seq !== null && seq === this.seq) [this.told, this.seq] = [undefined, null];
  },
};
setInterval(() => gamepad.look(), STICK_MS);
