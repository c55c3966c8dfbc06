// Shows the station's state and takes the operator's orders. The page decides nothing itself.
"use strict";

const SPEED_STEP = 0.05;
const PROGRAM = 0; // The number that stands for all programs of ROS 2; no page has it.

const at = (id) => document.getElementById(id);
let steers = false;

line.onWelcome = (message) => {
  chainMap.plan = message.plan;
  strips.begin(message.links);
  setText("map-kind", message.plan ? "Drones are drawn along the first gallery, as far as they have flown." : "No map was given: the line is the way flown.");
};

// ---- Orders -----------------------------------------------------------------------------------

// Writes an order, or says in large letters why it does not go out. Returns its number, if it does.
function order(name, more, acted) {
  return write({ do: "order", order: name, ...more }, acted, `to ${name}`);
}
function write(request, acted, name) {
  const isPilots = request.do === "order" || request.do === "survey";
  if (isPilots && !steers) {
    warn(`NOT SENT, ${name}: this page only looks on. Take over first.`);
    return null;
  }
  const why = line.writeFresh(request, acted, name);
  warn(why && `NOT SENT, ${name}: ${why}. Give it again.`);
  return why ? null : line.seq;
}
line.onLost = (lost) => {
  for (const seq of lost.keys()) gamepad.missed(seq);
  warn(`THE LINE BROKE, and it is not known whether this arrived: ${[...lost.values()].join(", ")}. See what the base orders.`);
};

const speed = () => Number(at("speed").value);

function give(name, more, acted) {
  gamepad.overrule();
  order(name, more, acted);
}

const orders = {
  wait: (acted) => give("wait", {}, acted),
  hold: (acted) => give("hold", {}, acted),
  explore: (acted) => give("explore", { speed: speed() }, acted),
  recall: (acted) => give("recall", {}, acted),
  land: (acted) => give("land", {}, acted),
  perch: (acted) => give("perch", {}, acted),
};
const branch = (way) => (acted) => order("branch", { way }, acted);

const keys = {
  w: orders.wait, t: orders.hold, " ": orders.hold, e: orders.explore, r: orders.recall,
  l: orders.land, p: orders.perch,
  1: branch("left"), 2: branch("straight"), 3: branch("right"), 0: branch("none"),
  ArrowUp: () => changeSpeed(SPEED_STEP), ArrowDown: () => changeSpeed(-SPEED_STEP),
};

function changeSpeed(by) {
  at("speed").value = (speed() + by).toFixed(2);
  showSpeed();
}
function showSpeed() {
  at("speed-text").textContent = speed().toFixed(2);
}

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") {
    event.preventDefault();
    line.orderStop();
    return;
  }
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
  // A field for numbers takes every key but Escape.
  if (event.target.type === "number") return;
  // A focused button takes the space bar, a focused slider the arrows.
  if (event.key === " " && event.target.tagName === "BUTTON") return;
  if (event.key.startsWith("Arrow") && event.target.tagName === "INPUT") return;
  const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act) return;
  event.preventDefault();
  act(event.timeStamp);
});

at("stop").onclick = () => line.orderStop();
at("give-up").onclick = (event) => write({ do: "give-up" }, event.timeStamp, "to stop waiting");
at("steer").onclick = (event) => write({ do: "steer" }, event.timeStamp, "to steer from this page");
at("speed").oninput = showSpeed;
for (const button of document.querySelectorAll("[data-order]")) button.onclick = (event) => orders[button.dataset.order](event.timeStamp);
for (const button of document.querySelectorAll("[data-way]")) button.onclick = (event) => branch(button.dataset.way)(event.timeStamp);

const survey = (event, step, more = {}) => write({ do: "survey", step, ...more }, event.timeStamp, "of the range survey");
at("survey-begin").onclick = (event) => survey(event, "begin", { node: Number(at("survey-node").value) });
at("survey-mark").onclick = (event) => survey(event, "mark", { metres: Number(at("survey-place").value) });
at("survey-end").onclick = (event) => survey(event, "end");

// ---- What is shown ----------------------------------------------------------------------------

function text(tag, words, className = "") {
  const element = document.createElement(tag);
  element.textContent = words;
  if (className) element.className = className;
  return element;
}

// A screen reader reads what changes: what stays the same is not written again.
function setText(id, words) {
  if (at(id).textContent !== words) at(id).textContent = words;
}
function setList(id, items) {
  const list = document.createElement("ul");
  list.append(...items);
  if (at(id).innerHTML !== list.innerHTML) at(id).replaceChildren(...list.childNodes);
}

const minutes = (s) => (s >= 120 ? `${Math.floor(s / 60)} min` : `${Math.round(s)} s`);
const classOf = { good: "good", weak: "weak", "too weak": "bad" };
const arrow = { rising: "↗ rising", steady: "→ steady", falling: "↘ falling", unknown: "" };
const capital = (words) => words.charAt(0).toUpperCase() + words.slice(1);

function droneItem(drone, { stamp, base }) {
  const item = document.createElement("li");
  item.dataset.node = drone.node;
  item.append(text("strong", `${capital(drone.name)}: ${drone.state}`));
  if (drone.fault) item.append(text("div", capital(drone.fault), "bad"));
  const facts = text("div", "", "facts");
  if (drone.link) {
    const { to, dbm, grade, trend } = drone.link;
    facts.append(text("span", `Link to ${to}: ${dbm.toFixed(0)} dBm, ${grade} ${arrow[trend]}`, classOf[grade] ?? ""));
  } else facts.append(text("span", "No link towards the base"));
  facts.append(text("span", `${drone.odometer_m.toFixed(1)} m flown`));
  if (drone.endurance_s !== null) {
    const spare = Math.max(0, drone.turns_back_s);
    const turns = drone.airborne ? `, turns back in ${minutes(spare)}` : "";
    facts.append(text("span", `Battery for ${minutes(drone.endurance_s)}${turns}`, drone.airborne && spare < 60 ? "bad" : ""));
  }
  else if (drone.battery_v !== null) facts.append(text("span", `Battery ${drone.battery_v.toFixed(2)} V`));
  else facts.append(text("span", "Battery unknown"));
  if (drone.silent) facts.append(text("span", `Silent for ${minutes(drone.age_s)}`, "bad"));
  item.append(facts);
  const strip = strips.of(drone.node, stamp, base);
  if (strip) item.append(strip);
  return item;
}

// The flight's clock.
function flightWords(flight) {
  if (!flight) return "No drone has taken off.";
  const s = Math.floor(flight.lasts_s);
  const clock = `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
  return flight.is_over ? `The flight lasted ${clock}.` : `In flight for ${clock}`;
}

function answerItem(answer) {
  const name = capital(answer.name);
  return answer.answered_s === null
    ? text("li", `${name}: NO ANSWER`, "bad")
    : text("li", `${name}: stopped, said after ${answer.answered_s.toFixed(1)} s`, "good");
}

function showStop(stopped) {
  at("stopping").hidden = !stopped;
  if (!stopped) return;
  const state = {
    repeating: "Stop is being sent until every drone has answered.",
    answered: "Every drone has answered.",
    "given up": "You no longer wait for the answers that are missing. Press STOP to send it again.",
  };
  setText("stop-state", state[stopped.sending]);
  const base = { name: "the base", answered_s: stopped.base_s };
  setList("answers", [base, ...stopped.drones].map(answerItem));
  at("give-up").hidden = stopped.sending !== "repeating";
}

function surveyWords(found) {
  if (!found) return "";
  const soFar = `With ${found.name}, last ${found.place_m.toFixed(1)} m from the base: ${found.samples} samples. `;
  if (!found.proposal) return `${soFar}Limits are proposed from 30 samples on; there is one a second.`;
  const { launch_dbm, retreat_dbm, reach_m, reached_limit } = found.proposal;
  const reach = reached_limit
    ? `A link is that strong up to ${reach_m.toFixed(1)} m.`
    : `The link was never that weak: it reaches farther than ${reach_m.toFixed(1)} m.`;
  return `${soFar}Proposed limits: launch ${launch_dbm} dBm, retreat ${retreat_dbm} dBm. ${reach}`;
}

function show(status) {
  steers = status.steering === PAGE;
  at("not-steering").hidden = steers;
  setText("who-steers", status.steering === null
    ? "NOBODY STEERS: the station says nothing to the base, and the head hovers. This page only looks on; it may stop."
    : status.steering === PROGRAM
      ? "A program steers, by ROS 2. This page only looks on; it may stop."
      : "Another page steers. This page only looks on; it may stop.");
  if (status.refused?.page === PAGE) gamepad.missed(status.refused.seq);
  setText("refused", status.refused?.text ?? "");
  at("refused").hidden = !status.refused;
  for (const button of at("orders").querySelectorAll("button, input")) button.disabled = !steers;
  at("advice").className = status.advice.urgent ? "urgent" : "";
  setText("advice", status.advice.text);
  sound(status.advice);
  setText("task", status.task ?? "nothing yet");
  setText("base", status.base ? `Base, node ${status.base.node}: ${status.base.radio}.${status.base.recalled ? " A drone must come home." : ""}` : "");
  setText("flight", flightWords(status.flight));
  strips.note(status);
  setList("drones", status.drones.map((drone) => droneItem(drone, status)));
  chainMap.show(status);
  setList("notices", status.notices.map((notice) => text("li", notice)).reverse());
  at("before").hidden = status.checks.length === 0 || status.stop !== null;
  setList("checks", status.checks.map(({ good, text: words }) =>
    text("li", `${good ? "OK" : "NOT YET"}: ${words}`, good ? "good" : "weak")));
  at("survey").hidden = (status.checks.length === 0 || status.stop !== null) && !status.survey;
  for (const field of at("survey").querySelectorAll("button, input")) field.disabled = !steers;
  setText("survey-state", surveyWords(status.survey));
  showStop(status.stop);
  showLine();
}
line.onState = show;

// Two tones say that the advice has become urgent, or another urgent one has taken its place.
let audio = null;
let alarm = "";
for (const gesture of ["keydown", "pointerdown"])
  document.addEventListener(gesture, () => (audio ??= new AudioContext()), { once: true });
function sound(advice) {
  const before = alarm;
  // Numbers that count on are no other advice.
  alarm = advice.urgent ? advice.text.replace(/\d+/g, "") : "";
  if (!alarm || alarm === before || !audio || !at("sound").checked) return;
  for (const [hertz, start] of [[880, 0], [660, 0.25]]) {
    const tone = new OscillatorNode(audio, { frequency: hertz });
    tone.connect(new GainNode(audio, { gain: 0.3 })).connect(audio.destination);
    tone.start(audio.currentTime + start);
    tone.stop(audio.currentTime + start + 0.2);
  }
}

// What did not go out, until something does, or for ten seconds.
let warned = null;
function warn(words) {
  clearTimeout(warned);
  setText("warning", words);
  at("warning").hidden = !words;
  if (words) warned = setTimeout(() => warn(""), 10000);
}

function lineInWords() {
  if (!line.isOpen() || line.age() > STALE_MS) return "NO STATION: what is shown is old, and no order goes out. The page connects anew.";
  if (line.lag() > STALE_MS) return `THE STATION DOES NOT HEAR THIS PAGE, for ${(line.lag() / 1000).toFixed(0)} s. Orders are refused.`;
  if (line.state.steering === null) return "NOBODY STEERS: the station says nothing to the base.";
  if (!line.state.hears_base) return "THE BASE DOES NOT ANSWER.";
  return "";
}
function showLine() {
  const trouble = lineInWords();
  setText("link", trouble || "The base answers.");
  at("link").className = trouble ? "bad" : "good";
  at("unheard").hidden = line.stop === null;
  if (line.stop !== null) setText("unheard", `THE STOP HAS NOT ARRIVED at the ${line.stopIsHeard
    ? "base: the station sends it again and again." : "station: the page sends it again and again."} Take the motors for running.`);
}

setInterval(showLine, BEAT_MS);
showSpeed();
line.begin();
