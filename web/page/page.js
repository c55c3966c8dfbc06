// The page: what the user does goes to the simulator in the worker, and what it shows comes from there.
import { at, element } from "./dom.js";
import { View, gradeOf, kindOf, letter, takeColours } from "./draw.js";
import { Panel } from "./drawing.js";
import { figureList } from "./figures.js";
import { entries, isScenario, ofDrop, ofInput } from "./files.js";
import { read, write } from "./link.js";
import { answered } from "./plan.js";
import { STATES } from "./states.js";
import { ABOUT, clock, dbm, mapWords, orderWords } from "./words.js";

const SPEED = { forward: 0.3, back: -0.3 }; // m/s of the head.
const WORDS_MS = 200; // Words are read more slowly than pictures.
const LEAST_DBM = -300; // The lowest limit that a scenario may have.

const worker = new Worker("worker.js", { type: "module" });
const waiting = new Map();
const view = new View(at("map"));
const page = { recipe: {}, dropped: [], offered: [], setting: null, frame: null, plan: null, paused: false, branch: "", held: null, states: [], figures: {}, told: 0 };

worker.onmessage = ({ data: { id, is, value, wrong } }) => {
  if (id === undefined) return said[is](value);
  const { resolve, reject } = waiting.get(id);
  waiting.delete(id);
  return wrong === undefined ? resolve(value) : reject(new Error(wrong));
};
worker.onerror = ({ message }) => complain(`The simulator has ended: ${message ?? "reload the page"}`);

function ask(act, value) {
  const id = ask.next++;
  return new Promise((resolve, reject) => {
    waiting.set(id, { resolve, reject });
    worker.postMessage({ id, act, value });
  });
}
ask.next = 1;

const said = {
  async ready(scenarios) {
    const option = ({ name, title }) => new Option(`${name}: ${title}`, name);
    at("scenario").append(...scenarios.map(option));
    try {
      const { recipe, dropped } = await read(location.hash);
      await open(recipe, dropped);
    } catch (error) {
      complain(error.message);
      await open({}, []).catch((again) => complain(again.message));
    }
  },
  frame(frame) {
    // A frame of the mission before may come while the page opens the next one.
    if (frame.drones.length !== page.setting?.nodes.length) return;
    page.frame = frame;
    view.note(frame);
    events(frame);
    const now = performance.now();
    if (frame.over || now - page.told > WORDS_MS) {
      page.told = now;
      tellFrame(frame);
    }
  },
  figures: tellFigures,
};

function complain(words) {
  at("wrong").textContent = words;
  at("wrong").hidden = !words;
}

// Does what the user wants, and says why it cannot be done.
const doing = (action) => async (event) => {
  try {
    complain("");
    await action(event);
  } catch (error) {
    complain(error.message);
  }
};

// ---- A mission begins ----------------------------------------------------------------------

async function open(recipe, dropped = page.dropped) {
  const { setting, frame } = await ask("open", { recipe, dropped: dropped === page.dropped ? undefined : dropped });
  if (dropped !== page.dropped && dropped !== page.offered) offer(dropped);
  Object.assign(page, { recipe, dropped, setting, frame, plan: null, states: [], branch: "", held: null });
  at("events").replaceChildren();
  at("answer").replaceChildren();
  at("hide-plan").hidden = true;
  view.show(setting);
  view.note(frame);
  rows();
  controls();
  branches();
  tellFigures({});
  tellFrame(frame);
  await setPace();
  await keepLink(recipe);
}

function controls() {
  const { setting, recipe } = page;
  at("seed").value = setting.seed;
  const isOwn = Boolean(recipe.map || recipe.text);
  at("own").hidden = !isOwn;
  at("own").textContent = `your own: ${setting.title || setting.name}`;
  at("scenario").value = isOwn ? "" : setting.name;
  const values = { loss: setting.packet_loss * 100, launch: setting.launch_dbm, relays: setting.relays };
  for (const [id, value] of Object.entries(values)) {
    at(id).value = value;
    slid(id, value);
  }
  const isChain = setting.mission === "chain";
  for (const id of ["launch", "relays"]) at(id).disabled = !isChain;
  for (const part of document.querySelectorAll(".of-chain")) part.hidden = !isChain;
  at("about").textContent = ABOUT[setting.mission];
  const { route } = setting.place;
  if (recipe.map && page.offered === page.dropped) at("entry").value = recipe.map;
  at("stations").replaceChildren(...(route?.stations ?? []).map((name) => new Option(name)));
  at("route-words").textContent = route
    ? `${route.length_m} m from ${route.from} to ${route.to}: ${route.ended}. ${route.warnings.slice(0, 4).join(" ")}` : "";
}

const SLIDERS = { loss: (value) => `${Math.round(value)} %`, launch: (value) => dbm(value), relays: String };

// Says the value, which may lie outside of what the slider reaches.
function slid(id, value) {
  at(`${id}-now`).value = SLIDERS[id](value);
}

const without = (recipe, ...keys) => Object.fromEntries(Object.entries(recipe).filter(([key]) => !keys.includes(key)));

const keyed = (text) => [text.slice(0, text.indexOf("=")), text.slice(text.indexOf("=") + 1)];

// The mission with the value of the slider that was moved; the others cannot show every value exactly.
function changed(id) {
  const { setting } = page;
  const recipe = without(page.recipe, "pilot", "loss");
  const value = Number(at(id).value);
  if (id === "relays") return { ...recipe, relays: value };
  const set = new Map((recipe.set ?? []).map(keyed));
  if (id === "loss") set.set("radio.packet_loss", value / 100);
  if (id === "launch") {
    set.set("launch.limit_dbm", value);
    set.set("retreat.limit_dbm", Math.max(value - (setting.launch_dbm - setting.retreat_dbm), LEAST_DBM));
  }
  return { ...recipe, set: [...set].map(([key, value]) => `${key}=${value}`) };
}

const setPace = () => {
  at("pause").firstChild.data = page.paused ? "Go on " : "Pause ";
  return ask("pace", page.paused ? 0 : Number(at("pace").value));
};

// ---- What is shown -------------------------------------------------------------------------

function rows() {
  const row = ({ name, role }, n) => {
    const chip = element("span", { className: `chip ${kindOf(n, role)}`, textContent: letter(n, role) });
    const state = element("span");
    const links = element("p", { className: "links" });
    const item = element("li", {}, element("p", {}, chip, " ", element("b", { textContent: name }), " ", state), links);
    if (role !== "base") {
      const kill = element("button", { type: "button", textContent: "Kill it", ariaLabel: `Kill ${name}` });
      kill.addEventListener("click", doing(async () => flown(await ask("lose", n))));
      item.append(kill);
    }
    item.style.borderColor = `var(--${kindOf(n, role)})`;
    return Object.assign(item, { parts: { chip, state, links } });
  };
  at("drones").replaceChildren(...page.setting.nodes.map(row));
}

function tellFrame(frame) {
  const { setting } = page;
  if (!setting || frame.drones.length !== setting.nodes.length) return;
  const whose = page.steers ? "You" : page.recipe.pilot ? "The pilot of the link" : "The scenario's pilot";
  const end = frame.over ? ", the end" : "";
  at("now").textContent = `${clock(frame.t)} of ${clock(setting.duration_s)}${end}. ${whose}: ${orderWords(frame.order, setting.mission)}${frame.recalled ? "; a drone calls all home" : ""}`;
  frame.drones.forEach((drone, n) => tellDrone(drone, n));
  for (const button of document.querySelectorAll("#pilot button")) button.disabled = frame.over;
  at("map").ariaLabel = mapWords(setting, frame, page.figures);
}

function tellDrone(drone, n) {
  const { setting } = page;
  const { role } = setting.nodes[n];
  const { parts } = at("drones").children[n];
  parts.state.textContent = role === "base" ? "hears the pilot" : drone.lost ? "is dead" : STATES[drone.state] ?? drone.state;
  parts.chip.className = `chip ${drone.lost ? "down" : kindOf(n, role)}`;
  const link = (to, words) => to && to.dbm !== null && !drone.lost
    ? [element("span", { className: gradeOf(to.dbm, setting), textContent: `${words} ${setting.nodes[to.peer]?.name ?? ""} ${dbm(to.dbm)}` })] : [];
  const motion = drone.forward ? `${drone.forward > 0 ? "forward" : "back"} at ${Math.abs(drone.forward).toFixed(2)} m/s` : "";
  const told = [...link(drone.back, "hears"), ...link(drone.front, "hears"), motion].filter(Boolean);
  parts.links.replaceChildren(...told.flatMap((part, k) => (k ? [", ", part] : [part])));
  const kill = at("drones").children[n].querySelector("button");
  if (kill) kill.disabled = drone.lost;
}

const PAUSES = ["waiting", "hovering"];

// Each change of a state is an event of the mission.
function events(frame) {
  frame.drones.forEach(({ state, lost }, n) => {
    const { name, role } = page.setting.nodes[n];
    const now = lost ? "dead" : state;
    const before = page.states[n];
    // Between two goals a drone waits, and goes on.
    if (before !== undefined && PAUSES.includes(now)) return;
    page.states[n] = now;
    if (before === undefined || before === now || role === "base") return;
    const words = lost ? "is dead" : STATES[state] ?? state;
    at("events").prepend(element("li", {}, element("time", { textContent: clock(frame.t) }), ` ${name} ${words}`));
  });
}

function tellFigures(figures) {
  page.figures = figures;
  if (!page.setting) return;
  at("figures").replaceChildren(...figureList(figures, page.frame, page.setting).flatMap(([value, words]) =>
    [element("dt", { textContent: value }), element("dd", { textContent: words })]));
}

function draw() {
  requestAnimationFrame(draw);
  view.draw(page.frame, page.plan);
  drawing.draw();
}

// ---- The pilot -----------------------------------------------------------------------------

async function steer(order, speed = 0) {
  page.steers = true;
  const recipe = await ask("steer", { order, speed, branch: order === "explore" ? page.branch : "" });
  await flown(recipe);
}

async function flown(recipe) {
  page.recipe = { ...page.recipe, ...without(recipe, "pilot", "loss") };
  page.flown = recipe;
  await keepLink(recipe);
}

const hold = doing(async (way) => {
  if (page.held === way) return;
  page.held = way;
  marks();
  await steer("explore", way ? SPEED[way] : 0);
});

function choose(branch) {
  page.branch = page.branch === branch ? "" : branch;
  branches();
  return steer("explore", page.held ? SPEED[page.held] : 0);
}

function branches() {
  for (const button of document.querySelectorAll("[data-branch]")) button.ariaPressed = String(button.dataset.branch === page.branch);
  marks();
}

const marks = () => document.querySelectorAll("[data-hold]").forEach((button) => button.classList.toggle("held", button.dataset.hold === page.held));

const HELD = { ArrowUp: "forward", w: "forward", ArrowDown: "back", s: "back" };
const PRESSED = {
  ArrowLeft: () => choose("left"), ArrowRight: () => choose("right"), r: () => steer("return"), l: () => steer("land"),
  Escape: () => steer("stop"), p: pause,
};

function pause() {
  page.paused = !page.paused;
  return setPace();
}

const isTyping = ({ target }) => target.matches?.("input, select, textarea");

addEventListener("keydown", (event) => {
  if (drawing.isOpen || event.ctrlKey || event.altKey || event.metaKey || (isTyping(event) && event.key !== "Escape")) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (!HELD[key] && !PRESSED[key]) return;
  event.preventDefault();
  if (event.repeat) return;
  if (page.setting?.mission !== "chain" && (HELD[key] || key.startsWith("Arrow"))) return;
  if (HELD[key]) hold(HELD[key]);
  else doing(PRESSED[key])();
});
addEventListener("keyup", (event) => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (HELD[key] && HELD[key] === page.held) hold(null);
});
addEventListener("blur", () => page.held && hold(null));

for (const button of document.querySelectorAll("[data-hold]")) {
  button.addEventListener("pointerdown", (event) => {
    button.setPointerCapture(event.pointerId);
    hold(button.dataset.hold);
  });
  for (const end of ["pointerup", "pointercancel"]) button.addEventListener(end, () => page.held && hold(null));
  button.addEventListener("contextmenu", (event) => event.preventDefault());
}
for (const button of document.querySelectorAll("[data-branch]")) button.addEventListener("click", doing(() => choose(button.dataset.branch)));
for (const button of document.querySelectorAll("[data-order]")) button.addEventListener("click", doing(() => steer(button.dataset.order)));

// ---- The choice of a mission ---------------------------------------------------------------

const begin = (recipe, dropped) => {
  drawing.show(false);
  Object.assign(page, { steers: false, flown: null });
  return open(recipe, dropped);
};

at("scenario").addEventListener("change", doing(() => begin({ scenario: at("scenario").value }, [])));
at("seed").addEventListener("change", doing(() => begin({ ...without(page.recipe, "pilot", "loss"), seed: Math.max(0, Math.floor(Number(at("seed").value))) })));
at("pace").addEventListener("change", doing(setPace));
at("pause").addEventListener("click", doing(pause));
at("again").addEventListener("click", doing(() => begin(page.recipe)));
at("finish").addEventListener("click", doing(() => ask("finish")));
at("whole").addEventListener("click", () => view.whole());
at("near").addEventListener("click", () => {
  view.whole();
  [view.follows, view.zoom] = [true, 2.5];
});
for (const id of Object.keys(SLIDERS)) {
  at(id).addEventListener("input", () => slid(id, Number(at(id).value)));
  at(id).addEventListener("change", doing(() => begin(changed(id)).catch((error) => {
    controls();
    throw error;
  })));
}

// Keys steer again after the pointer has moved a slider or chosen from a menu.
for (const control of document.querySelectorAll("select, input[type=range]")) {
  let isPointed = false;
  control.addEventListener("pointerdown", () => { isPointed = true; });
  control.addEventListener("keydown", () => { isPointed = false; });
  control.addEventListener("change", () => isPointed && control.blur());
}

// ---- A drawn cave --------------------------------------------------------------------------

const drawing = new Panel({
  check: (drawn) => ask("draw", drawn).catch((error) => ({ mistake: { line: error.message, legs: [] } })),
  fly: (text) => doing(() => begin({ text }, []))(),
  pause: (isOpen) => (isOpen ? ask("pace", 0) : setPace()),
});

// ---- Files ---------------------------------------------------------------------------------

async function take(dropped) {
  const found = entries(dropped);
  if (found.length === 0) throw new Error("none of these files is a survey, a map, a world or a scenario that this page reads");
  offer(dropped);
  await useEntry(found[0], dropped);
}

// Lists the files that a mission may begin with.
function offer(dropped) {
  page.offered = dropped;
  at("entry").replaceChildren(...entries(dropped).map((path) => new Option(path)));
  at("route").hidden = dropped.length === 0;
}

function useEntry(path, dropped, ends = {}) {
  if (isScenario(path)) {
    const { bytes } = dropped.find((file) => file.path === path);
    // The simulator knows the text alone: what is wrong in it is told with the file's name.
    return begin({ text: new TextDecoder().decode(bytes) }, dropped).catch((error) => {
      throw new Error(error.message.replace(/^scenario\.toml/, path));
    });
  }
  return begin({ map: path, ...ends }, dropped);
}

const ends = () => Object.fromEntries(["from", "to"].filter((id) => at(id).value.trim()).map((id) => [id, at(id).value.trim()]));

at("files").addEventListener("change", doing(async () => take(await ofInput(at("files").files))));
at("folder").addEventListener("change", doing(async () => take(await ofInput(at("folder").files))));
at("dig").addEventListener("click", doing(() => useEntry(at("entry").value, page.offered, ends())));
at("entry").addEventListener("change", doing(() => useEntry(at("entry").value, page.offered)));
addEventListener("dragover", (event) => {
  event.preventDefault();
  at("drop").hidden = false;
});
addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) at("drop").hidden = true;
});
addEventListener("drop", (event) => {
  event.preventDefault();
  at("drop").hidden = true;
  doing(async () => take(await ofDrop(event.dataTransfer)))();
});

// ---- The plan ------------------------------------------------------------------------------

async function plan() {
  at("answer").replaceChildren(element("p", { textContent: "Computing …" }));
  const answer = await ask("plan", { recipe: without(page.recipe, "pilot", "loss"), margin: Number(at("margin").value) });
  page.plan = answer.plan;
  at("answer").replaceChildren(...answered(answer));
  at("hide-plan").hidden = false;
}

at("ask").addEventListener("click", doing(() => plan().catch((error) => {
  at("answer").replaceChildren();
  throw error;
})));
at("hide-plan").addEventListener("click", () => {
  page.plan = null;
  at("answer").replaceChildren();
  at("hide-plan").hidden = true;
});

// ---- The link and the files ----------------------------------------------------------------

async function keepLink(recipe) {
  // Packing takes time, in which the next order may have come.
  const turn = ++keepLink.turn;
  const link = await write(recipe, page.dropped);
  if (turn !== keepLink.turn) return;
  history.replaceState(null, "", link ?? location.pathname);
  at("copy").disabled = link === null;
  at("link-words").textContent = link === null ? "The files of this map are too large for a link; save the scenario instead." : "";
}
keepLink.turn = 0;

function save(name, text) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text])), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

at("copy").addEventListener("click", doing(async () => {
  await navigator.clipboard.writeText(location.href);
  at("link-words").textContent = "The link is in the clipboard.";
}));
at("save-scenario").addEventListener("click", doing(async () => save("scenario.toml", (await ask("record")).toml)));
at("save-trace").addEventListener("click", doing(async () => save("trace.csv", (await ask("record")).csv)));
addEventListener("hashchange", doing(async () => {
  const { recipe, dropped } = await read(location.hash);
  await begin(recipe, dropped);
}));

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", takeColours);
takeColours();
draw();
// For tests, and for those who look into the page with the browser's tools.
window.uchain = { ask, page, view, drawing };
