// Flies the mission beside the page, so that the page answers while the simulator computes.
import init, { Dropped, Flight, drawn_scenario, plan_relays, scenarios } from "./uchain_web.js";

const STEP_US = 20_000; // The physics step at point level: the finest motion that there is to see.
const ROUND_US = 200_000;
const BUDGET_MS = 24; // The longest that the loop computes before it shows what it has.
const FIGURES_MS = 500;

let flight = null;
let files = null;
let pace = 0; // Seconds of the mission in a second; Infinity is as fast as it goes.
let owedUs = 0;
let last = 0;
let toldFigures = 0;
let isOver = false;

const tell = (is, value) => self.postMessage({ is, value });

const actions = {
  open({ recipe, dropped }) {
    // Where the new mission is refused, the one before goes on with its own files.
    const given = dropped ? new Dropped() : files;
    let next;
    try {
      for (const { path, bytes } of dropped ?? []) given.add(path, bytes);
      next = new Flight(JSON.stringify(recipe), given);
    } catch (error) {
      if (dropped) given.free();
      throw error;
    }
    if (dropped) files.free();
    files = given;
    flight?.free();
    [flight, owedUs, isOver] = [next, 0, false];
    // With the first frame, so that the page never has the setting of one mission and the frame of another.
    return { setting: JSON.parse(flight.setting()), frame: present() };
  },
  pace(value) {
    [pace, owedUs, last] = [value, 0, performance.now()];
  },
  steer({ order, speed, branch }) {
    flight.steer(order, speed, branch);
    return JSON.parse(flight.flown());
  },
  lose(drone) {
    flight.lose(drone);
    return JSON.parse(flight.flown());
  },
  draw(drawing) {
    return JSON.parse(drawn_scenario(JSON.stringify(drawing)));
  },
  plan({ recipe, margin }) {
    return JSON.parse(plan_relays(JSON.stringify(recipe), files, margin));
  },
  finish() {
    const begun = performance.now();
    // The page tells events and draws ways from what it is shown.
    while (flight.advance(5 * ROUND_US)) look();
    const seconds = (performance.now() - begun) / 1000;
    look();
    return seconds;
  },
  record() {
    const record = { csv: flight.trace_csv(), flown: JSON.parse(flight.flown()), toml: flight.scenario_toml(files) };
    return isOver ? { ...record, summary: flight.summary() } : record;
  },
};

// The mission at this moment, with what has changed of the explorers' map since it was last told.
const present = () => ({ ...JSON.parse(flight.frame()), map: JSON.parse(flight.map_changes()) });

// Shows the mission as it is.
function look() {
  const frame = present();
  isOver = frame.over;
  tell("frame", frame);
  const now = performance.now();
  if (isOver || now - toldFigures > FIGURES_MS) {
    tell("figures", JSON.parse(flight.figures()));
    toldFigures = now;
  }
}

function fly() {
  const now = performance.now();
  owedUs += Math.min(now - last, 100) * 1000 * pace;
  last = now;
  if (flight && !isOver && owedUs >= STEP_US) {
    const step = pace > 4 ? ROUND_US : STEP_US;
    while (owedUs >= STEP_US && performance.now() - now < BUDGET_MS) {
      const us = Math.min(step, Math.floor(owedUs / STEP_US) * STEP_US);
      owedUs -= us;
      if (!flight.advance(us)) break;
    }
    // A machine that cannot keep the pace flies as fast as it can.
    owedUs = Math.min(owedUs, ROUND_US);
    look();
  }
  setTimeout(fly, 12);
}

self.onmessage = ({ data: { id, act, value } }) => {
  try {
    const isReady = act === "pace" || (act === "open" ? files : flight);
    if (!isReady) throw new Error("the simulator is still loading");
    self.postMessage({ id, value: actions[act](value) });
  } catch (error) {
    self.postMessage({ id, wrong: String(error.message ?? error) });
  }
};

await init({ module_or_path: new URL("uchain_web_bg.wasm", import.meta.url) });
files = new Dropped();
tell("ready", JSON.parse(scenarios()));
fly();
