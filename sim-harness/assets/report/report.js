"use strict";
// Plays the mission whose data stands in this page. No library, no network.
(() => {
  const SVG = "http://www.w3.org/2000/svg";
  const data = JSON.parse(document.getElementById("data").textContent);
  const $ = (id) => document.getElementById(id);

  // Every column is told as differences; null is "nothing known" and changes nothing.
  const whole = (column, unit) => {
    let sum = 0;
    return column.map((step) => (step === null ? null : (sum += step) * unit));
  };
  const times = whole(data.times, 1e-3);
  const last = times.length - 1;
  const nodes = data.nodes.map((node) => ({
    ...node,
    x: whole(node.x, 1e-3), y: whole(node.y, 1e-3), z: whole(node.z, 1e-3),
    yaw: whole(node.yaw, 1e-3), way: whole(node.way, 1e-3),
    battery: whole(node.battery, 1e-3),
    state: whole(node.state, 1), ranges: node.ranges.map((beam) => met(whole(beam, 1e-3))),
    goalX: whole(node.goalX, 1e-3), goalY: whole(node.goalY, 1e-3),
    target: node.target.map((axis) => whole(axis, 1e-3)), rowFrom: node.rowFrom.map((axis) => whole(axis, 1e-3)), row: whole(node.row, 1),
    front: link(node.front), back: link(node.back),
  }));
  // A beam that saw nothing is told as a negative range.
  function met(beam) {
    return beam.map((range) => (range < 0 ? null : range));
  }
  function link(l) {
    return { peer: whole(l.peer, 1), raw: whole(l.raw, 0.1), filtered: whole(l.filtered, 0.1), truth: whole(l.truth, 0.1) };
  }
  if (last < 0) return;

  const make = (parent, tag, attributes = {}) => {
    const element = document.createElementNS(SVG, tag);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return parent.appendChild(element);
  };
  const fixed = (value, digits) => (value === null ? "–" : value.toFixed(digits).replace(/^-0(\.0*)?$/, "0$1").replace("-", "−"));
  const minutes = (t) => `${Math.floor(t / 60)}:${String(Math.floor(t % 60)).padStart(2, "0")}`;
  const moment = (t) => `${minutes(t)} (${t.toFixed(1)} s)`;

  const isChain = data.mission === "chain";

  // ---- what each state looks like in the strips: paler than the drones, whose colours are full
  const KINDS = [
    { name: "on the ground", colour: "var(--axis)", states: ["idle", "armed", "landed"] },
    { name: "taking off, landing", colour: "#a9d6f5", states: ["taking-off", "landing", "rising"] },
    { name: "in the chain", colour: "#8fcf9f", states: ["leading", "relaying"] },
    { name: "relaying from the ground", colour: "#b59f7a", states: ["perched"] },
    { name: "looking for its link", colour: "#f4c77b", states: ["reconnecting", "rejoining"] },
    { name: "searching for a better place", colour: "#e6dc6a", states: ["searching", "siting"] },
    { name: "backing up", colour: "#f0a07a", states: ["backing-up"] },
    { name: "flying home", colour: "#e3b7d0", states: ["homing", "returning", "retiring"] },
    { name: "surveying", colour: "#79b58b", states: ["surveying"] },
    { name: "gathering", colour: "#d6cb96", states: ["gathering"] },
    { name: "crossing", colour: "#c48fc4", states: ["crossing"] },
    { name: "exploring", colour: "#93d3c9", states: ["exploring"] },
    { name: "waiting in the air", colour: "#a79bd6", states: ["waiting", "hovering"] },
    { name: "lost", colour: "#b86f8f", states: ["lost"] },
    { name: "down, without having landed", colour: "var(--ink)", states: ["down"] },
    { name: "stopped", colour: "#a86a5c", states: ["stopped"] },
  ];
  // A change to one of these is told in the list of events.
  const TOLD = {
    "taking-off": "takes off", perched: "lands, and relays from the ground", rising: "rises again",
    reconnecting: "has lost its link, and flies back to where it was", rejoining: "comes back into the chain",
    searching: "searches for a better place", "backing-up": "backs up to keep its link", retiring: "is needed no more, and flies home",
    homing: "flies home", returning: "flies home", surveying: "begins to survey", gathering: "gathers at the entrance",
    crossing: "enters the passage", exploring: "begins to explore", lost: "has lost its place", landed: "has landed", down: "is down without having landed, and says no more", stopped: "stops its motors",
  };
  const OTHER = { name: "another state", colour: "#c3c38a", states: [] };
  const AIRBORNE = 0.1; // m
  const GROUNDING = ["idle", "armed", "landed", "landing", "taking-off", "perched", "rising", "stopped"];
  const kindOf = (name) => KINDS.find((kind) => kind.states.includes(name)) ?? OTHER;
  const grounded = (node, i) => kindOf(data.states[node.state[i]]) === KINDS[0];
  const isDown = (node, i) => data.states[node.state[i]] === "down";
  // On board, strengths count as if both ends were in the air: here they are what was received.
  const groundLoss = (node, i) => (data.states[node.state[i]] === "perched" ? data.groundLoss : 0);
  for (const node of nodes) {
    for (const { peer, raw, filtered } of [node.front, node.back]) {
      peer.forEach((other, i) => {
        const loss = other === null ? 0 : groundLoss(node, i) + groundLoss(nodes[other], i);
        for (const values of [raw, filtered]) if (values[i] !== null) values[i] -= loss;
      });
    }
  }
  // The ground speed over so many frames before and after one.
  const AROUND = 2;
  const speed = (node, i) => {
    const [from, to] = [Math.max(0, i - AROUND), Math.min(last, i + AROUND)];
    if (to === from || [from, to].some((n) => node.x[n] === null)) return null;
    return Math.hypot(node.x[to] - node.x[from], node.y[to] - node.y[from]) / (times[to] - times[from]);
  };

  // ---- links
  const ramp = data.linkColours;
  const strength = (dbm) => {
    const share = Math.min(1, Math.max(0, (dbm - ramp.from) / (ramp.to - ramp.from)));
    return ramp.colours[Math.round(share * (ramp.colours.length - 1))];
  };
  // A node's link towards the head: as it knew it, or as the one at the other end did. A drone that is down
  // has none, though what it knew last still stands in the record.
  const towardsHead = (index, i) => {
    const link = recorded(index, i);
    return link && !isDown(nodes[index], i) && !isDown(nodes[link.peer], i) ? link : null;
  };
  const recorded = (index, i) => {
    const own = nodes[index].front;
    if (own.peer[i] !== null) return { peer: own.peer[i], raw: own.raw[i], filtered: own.filtered[i], truth: own.truth[i] };
    for (let ahead = index - 1; ahead >= 0; ahead--) {
      const back = nodes[ahead].back;
      if (back.peer[i] === index) return { peer: ahead, raw: back.raw[i], filtered: back.filtered[i], truth: back.truth[i] };
    }
    return null;
  };

  // In a swarm and an exploration: who hears whom, with the true strength at the weaker end.
  const team = data.teamLinks.map(({ ends, dbm }) => ({ ends, dbm: whole(dbm, 1) }));
  // The links that connect all who hear one another, from the strongest on each that joins two parts: the weakest
  // of them is as strong as it can be.
  function teamLinks(i) {
    const part = nodes.map((_, index) => index);
    const heard = team.filter((pair) => pair.dbm[i] !== null).sort((a, b) => b.dbm[i] - a.dbm[i]);
    return heard.flatMap(({ ends: [a, b], dbm }) => {
      const [kept, joined] = [part[a], part[b]];
      if (kept === joined) return [];
      part.forEach((of, index) => { if (of === joined) part[index] = kept; });
      return [{ a, b, dbm: dbm[i], words: `true ${fixed(dbm[i], 0)} dBm, at the weaker end` }];
    });
  }
  const chainLinks = (i) => nodes.flatMap((_, index) => {
    const link = towardsHead(index, i);
    if (!link || link.filtered === null) return [];
    return [{ a: link.peer, b: index, dbm: link.filtered, words: `received ${fixed(link.raw, 0)} dBm\nfiltered ${fixed(link.filtered, 1)} dBm\ntrue ${fixed(link.truth, 1)} dBm` }];
  });
  const linksAt = isChain ? chainLinks : teamLinks;
  const between = ({ a, b }) => `${nodes[a].name} – ${nodes[b].name}`;

  // ---- the map
  // The changes of the map that explorers have drawn together, in order of time.
  const changes = (data.map?.moments ?? []).flatMap(([ms, cells, grounds]) =>
    whole(cells, 1).map((cell, n) => ({ t: ms / 1000, cell, ground: grounds[n] })));
  const map = $("map");
  const world = bounds();
  let view = { ...world };
  map.style.aspectRatio = `${world.width} / ${world.height}`;
  const layers = Object.fromEntries(["plan", "seen", "trails", "goals", "beams", "links", "bodies", "names", "scale"].map((name) => [name, make(map, "g")]));
  for (const outline of data.outlines) {
    const points = outline.points.map(([x, y]) => `${x},${-y}`).join(" ");
    make(layers.plan, "polygon", { points, class: outline.free ? "floor" : "floor pillar" });
  }
  for (const centre of data.centres) {
    make(layers.plan, "polyline", { class: "centre", points: centre.map(([x, y]) => `${x},${-y}`).join(" ") });
  }
  if (data.passage) {
    const points = data.passage.map(([x, y]) => `${x},${-y}`).join(" ");
    const area = make(layers.plan, "polygon", { points, class: "passage" });
    area.addEventListener("pointermove", (event) => tell("the passage that the swarm crosses", event));
    area.addEventListener("pointerleave", () => tell(""));
  }
  // Each line has a wide one over it that is not seen, so that the pointer meets it.
  const lines = nodes.map(() => ({ link: make(layers.links, "line", { class: "link" }), hit: make(layers.links, "line", { class: "hit" }), shown: null }));
  for (const line of lines) {
    line.hit.addEventListener("pointermove", (event) => tell(line.shown ? `${between(line.shown)}\n${line.shown.words}` : "", event));
    line.hit.addEventListener("pointerleave", () => tell(""));
  }
  // Many names would hide each other: then a relay has its number alone.
  const few = nodes.length <= 8;
  const marks = nodes.map((node) => {
    const body = make(layers.bodies, "g", {});
    const shape = node.role === "base" ? "M-6-6H6V6H-6Z" : "M9.5 0 -6.5 6.5 -3 0 -6.5-6.5Z";
    make(body, "path", { d: shape, class: "body", style: `fill:${node.colour}` });
    const name = make(layers.names, "text", { class: "name", style: `fill:${node.colour}` });
    make(name, "tspan", { x: 0 });
    const doing = make(name, "tspan", { x: 0, dy: 13 });
    return {
      body, name, doing, lead: name.firstChild,
      trail: make(layers.trails, "polyline", { class: "trail", style: `stroke:${node.colour}` }),
      beams: node.ranges.map(() => make(layers.beams, "line", { class: "beam" })),
      row: make(layers.goals, "line", { class: "row", style: `stroke:${node.colour}` }),
      place: make(layers.goals, "circle", { class: "place", r: 7, style: `stroke:${node.colour}` }),
      course: make(layers.goals, "line", { class: "course", style: `stroke:${node.colour}` }),
      goal: make(layers.goals, "path", { class: "goal", d: "M-6 0H6M0-6V6", style: `stroke:${node.colour}` }),
    };
  });
  const scaleBar = make(layers.scale, "path", { class: "scale" });
  const scaleText = make(layers.scale, "text", { class: "scale-text" });
  const north = make(layers.scale, "g", { class: "north" });
  make(north, "path", { d: "M0-14 4-5H-4Z" });
  make(north, "path", { d: "M0-6V1", class: "scale" });
  make(north, "text", { class: "scale-text", x: 7, y: 0 }).textContent = "N";

  function bounds() {
    const xs = [], ys = [];
    for (const outline of data.outlines) for (const [x, y] of outline.points) { xs.push(x); ys.push(-y); }
    for (const node of nodes) for (let i = 0; i <= last; i++) if (node.x[i] !== null) { xs.push(node.x[i]); ys.push(-node.y[i]); }
    for (const { cell } of changes) {
      const [x, y] = southWest(cell);
      xs.push(x, x + data.map.side); ys.push(-y, -y - data.map.side);
    }
    const least = (all) => all.reduce((a, b) => Math.min(a, b), Infinity);
    const most = (all) => all.reduce((a, b) => Math.max(a, b), -Infinity);
    if (!xs.length) return { x: 0, y: 0, width: 1, height: 1 };
    const width = Math.max(1, most(xs) - least(xs));
    // Room for names above and the scale below, whatever the size on the screen.
    const [side, end] = [0.02 * width, 0.06 * width];
    return { x: least(xs) - side, y: least(ys) - end, width: width + 2 * side, height: most(ys) - least(ys) + 2 * end };
  }
  // The south-western corner of a cell of the explorers' map.
  function southWest(cell) {
    const { corner, side, columns } = data.map;
    return [corner[0] + (cell % columns) * side, corner[1] + Math.floor(cell / columns) * side];
  }
  // Metres to a pixel of the screen.
  const metresPerPixel = () => Math.max(view.width / Math.max(1, map.clientWidth), view.height / Math.max(1, map.clientHeight));

  function drawScale() {
    const unit = metresPerPixel();
    const wanted = 90 * unit;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const metres = [5, 2, 1].find((f) => f * power <= wanted) * power;
    const left = view.x + view.width / 2 - (map.clientWidth / 2 - 8) * unit;
    const bottom = view.y + view.height / 2 + (map.clientHeight / 2 - 8) * unit;
    scaleBar.setAttribute("d", `M0-4V0H${metres / unit}V-4`);
    scaleText.setAttribute("x", metres / unit + 7);
    scaleText.textContent = `${metres} m`;
    north.setAttribute("transform", `translate(${metres / unit + 7 + wide(scaleText.textContent, "11px") + 16})`);
    layers.scale.setAttribute("transform", `translate(${left} ${bottom}) scale(${unit})`);
  }
  function show() {
    map.classList.toggle("zoomed", view.width < 0.99 * world.width);
    map.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
    drawScale();
    render();
  }
  function zoom(factor, at = { x: view.x + view.width / 2, y: view.y + view.height / 2 }) {
    const width = Math.min(world.width * 1.5, Math.max(1.5, view.width * factor));
    const by = width / view.width;
    view = { x: at.x - (at.x - view.x) * by, y: at.y - (at.y - view.y) * by, width, height: view.height * by };
    show();
  }
  const place = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(map.getScreenCTM().inverse());

  // NW, NE, SW, SE of a nose that points north, counter-clockwise from it.
  const BEAMS = [0.25, -0.25, 0.75, -0.75].map((half) => half * Math.PI);
  // ---- the map that explorers have drawn together: a square for each cell of which they ever know something
  const CELL_CLASS = { u: "", f: "seen", e: "frontier", w: "wall-seen" };
  const squares = new Map();
  let drawn = 0; // the number of changes that the map shows
  for (const { cell } of changes) {
    if (squares.has(cell)) continue;
    const [x, y] = southWest(cell), { side } = data.map;
    squares.set(cell, make(layers.seen, "rect", { x, y: -y - side, width: side, height: side, display: "none" }));
  }
  $("seen-legend").hidden = changes.length === 0;
  function showSeen() {
    const t = times[now] + 1e-9;
    const changed = new Map();
    if (drawn > 0 && changes[drawn - 1].t > t) {
      drawn = 0;
      for (const cell of squares.keys()) changed.set(cell, "u");
    }
    while (drawn < changes.length && changes[drawn].t <= t) changed.set(changes[drawn].cell, changes[drawn++].ground);
    for (const [cell, ground] of changed) {
      const square = squares.get(cell);
      if (square.getAttribute("class") !== CELL_CLASS[ground]) square.setAttribute("class", CELL_CLASS[ground]);
      if (ground === "u") square.setAttribute("display", "none"); else square.removeAttribute("display");
    }
  }

  // ---- one moment
  let now = 0;
  const TRAIL = 150; // frames: half a minute
  // How wide a text is, pixels, with the edge about it.
  const pen = document.createElement("canvas").getContext("2d"), widths = new Map();
  function wide(text, font) {
    const key = `${font} ${text}`;
    if (!widths.has(key)) {
      pen.font = `${font} ${getComputedStyle(document.body).fontFamily}`;
      widths.set(key, pen.measureText(text).width + 4);
    }
    return widths.get(key);
  }
  // Writes a drone's name where it hides no other: with what the drone is doing, without, or its number alone.
  function writeName(mark, node, [x, y], unit, taken) {
    const number = node.name.replace(/^(relay|drone|explorer) /, "");
    const doing = node.role === "base" || !few ? "" : data.states[node.state[now]];
    const ways = [[node.name, "", -14], [node.name, "", 24], [number, "", -14], [number, "", 24], [number, "", 5, 15], [number, "", 5, -15]];
    if (!few) ways.splice(0, 2);
    if (doing) ways.unshift([node.name, doing, -26], [node.name, doing, 22]);
    // Drones wait about the base: its name stands below.
    if (node.role === "base") ways.splice(0, Infinity, [node.name, "", 20], [node.name, "", -14]);
    const boxed = ([name, words, rise, aside = 0]) => {
      const half = 0.5 * Math.max(wide(name, "650 12px"), wide(words, "11px")) * unit;
      const centre = Math.min(Math.max(x + aside * unit, view.x + half), view.x + view.width - half);
      const top = y + (rise - 13) * unit;
      return { centre, left: centre - half, right: centre + half, top, bottom: top + (words ? 32 : 18) * unit };
    };
    const isFree = (box) => taken.every((other) => box.right < other.left || other.right < box.left || box.bottom < other.top || other.bottom < box.top);
    // In a crowd the table has the name.
    const way = ways.find((each) => isFree(boxed(each)));
    mark.name.style.display = way ? "" : "none";
    if (!way) return;
    const box = boxed(way);
    taken.push(box);
    [mark.lead.textContent, mark.doing.textContent] = way;
    mark.name.setAttribute("transform", `translate(${box.centre} ${y + way[2] * unit}) scale(${unit})`);
  }
  // The goal of an explorer on its way, by its own estimate, and the line to it.
  function drawGoal(mark, node, [x, y], unit) {
    const [goalX, goalY] = [node.goalX[now], node.goalY[now]];
    mark.course.style.display = mark.goal.style.display = goalX === null ? "none" : "";
    if (goalX === null) return;
    mark.course.setAttribute("x1", x); mark.course.setAttribute("y1", y);
    mark.course.setAttribute("x2", goalX); mark.course.setAttribute("y2", -goalY);
    mark.goal.setAttribute("transform", `translate(${goalX} ${-goalY}) scale(${unit})`);
  }
  // Where a drone of a swarm is to be: the row that it flies over, or its place in the formation.
  function drawTarget(mark, node, [x, y], unit) {
    const [[toX, toY], [fromX, fromY]] = [node.target, node.rowFrom].map((axes) => axes.map((axis) => axis[now]));
    mark.place.style.display = toX === null ? "none" : "";
    mark.row.style.display = fromX === null ? "none" : "";
    if (toX === null) return;
    mark.course.style.display = "";
    for (const [name, value] of Object.entries({ x1: x, y1: y, x2: toX, y2: -toY })) mark.course.setAttribute(name, value);
    mark.place.setAttribute("transform", `translate(${toX} ${-toY}) scale(${unit})`);
    if (fromX !== null) for (const [name, value] of Object.entries({ x1: fromX, y1: -fromY, x2: toX, y2: -toY })) mark.row.setAttribute(name, value);
  }
  // What a drone of a swarm flies to, in words.
  const toWords = (node) => {
    if (node.target[0][now] === null) return data.states[node.state[now]] === "crossing" ? "through the passage" : "–";
    if (node.row[now] !== null) return `row ${node.row[now] + 1}`;
    return data.states[node.state[now]] === "gathering" ? "its place in the formation" : "where it took off";
  };
  function drawLinks() {
    const shown = linksAt(now);
    lines.forEach((line, n) => {
      line.shown = shown[n] ?? null;
      for (const element of [line.link, line.hit]) {
        element.style.display = line.shown ? "" : "none";
        if (!line.shown) continue;
        const [one, other] = [nodes[line.shown.a], nodes[line.shown.b]];
        element.setAttribute("x1", one.x[now]); element.setAttribute("y1", -one.y[now]);
        element.setAttribute("x2", other.x[now]); element.setAttribute("y2", -other.y[now]);
      }
      if (line.shown) line.link.setAttribute("stroke", strength(line.shown.dbm));
    });
    listLinks(shown);
  }
  // The strengths as a list: a phone has no pointer to hover with.
  function listLinks(shown) {
    const items = shown.map((link) => {
      const item = document.createElement("li"), swatch = document.createElement("i"), value = document.createElement("b");
      swatch.style.background = strength(link.dbm);
      value.textContent = `${fixed(link.dbm, isChain ? 1 : 0)} dBm`;
      item.append(swatch, between(link), value);
      return item;
    });
    $("links-now").replaceChildren(...items);
  }
  function render() {
    const unit = metresPerPixel();
    const taken = [];
    nodes.forEach((node, index) => {
      const mark = marks[index];
      const [x, y] = [node.x[now], -node.y[now]];
      const degrees = node.role === "base" ? 0 : (-node.yaw[now] * 180) / Math.PI;
      mark.body.setAttribute("transform", `translate(${x} ${y}) rotate(${degrees}) scale(${unit})`);
      mark.body.setAttribute("class", grounded(node, now) || isDown(node, now) ? "grounded" : "");
      const waiting = grounded(node, now) && node.role !== "base" && index > 0;
      mark.name.style.display = waiting ? "none" : "";
      if (!waiting) writeName(mark, node, [x, y], unit, taken);
      const trail = [];
      for (let i = Math.max(0, now - TRAIL); i <= now; i++) trail.push(`${node.x[i]},${-node.y[i]}`);
      mark.trail.setAttribute("points", trail.join(" "));
      mark.beams.forEach((line, beam) => {
        const range = node.ranges[beam][now];
        line.style.display = range === null ? "none" : "";
        if (range === null) return;
        const angle = node.yaw[now] + BEAMS[beam];
        line.setAttribute("x1", x); line.setAttribute("y1", y);
        line.setAttribute("x2", x + range * Math.cos(angle)); line.setAttribute("y2", y - range * Math.sin(angle));
      });
      drawGoal(mark, node, [x, y], unit);
      drawTarget(mark, node, [x, y], unit);
      fillRow(rows[index], node);
    });
    drawLinks();
    showSeen();
    markEvent();
    const t = times[now];
    $("clock").textContent = moment(t);
    slider.value = now;
    slider.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
    for (const cursor of cursors) cursor(t);
  }

  // ---- the table
  const rows = nodes.map((node) => {
    const row = $("nodes").tBodies[0].insertRow();
    const head = document.createElement("th");
    head.scope = "row";
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = node.colour;
    head.append(swatch, node.name);
    row.append(head);
    const cell = (number) => { const c = row.insertCell(); if (number) c.className = "number"; return c; };
    return { doing: cell(false), way: cell(true), speed: cell(true), front: cell(true), back: cell(true), to: cell(false) };
  });
  function fillRow(row, node) {
    row.doing.textContent = node.role === "base" ? "base" : data.states[node.state[now]];
    row.to.textContent = toWords(node);
    row.way.textContent = fixed(node.way[now], 2);
    row.speed.textContent = node.role === "base" ? "–" : fixed(speed(node, now), 2);
    for (const side of ["front", "back"]) {
      const peer = node[side].peer[now];
      const isCut = peer === null || isDown(node, now) || isDown(nodes[peer], now);
      const dbm = isCut ? null : node[side].filtered[now];
      row[side].textContent = dbm === null ? "–" : fixed(dbm, 1);
      row[side].classList.toggle("weak", dbm !== null && data.limit !== null && dbm < data.limit);
      row[side].title = dbm === null ? "" : `to ${nodes[peer].name}; received ${fixed(node[side].raw[now], 0)}, true ${fixed(node[side].truth[now], 1)} dBm`;
    }
  }
  // A swarm and explorers keep no links as a chain does, and fly across the plan, not along a way.
  const hasTargets = nodes.some((node) => node.target[0].some((x) => x !== null));
  const hasLinks = nodes.some((node) => ["front", "back"].some((side) => node[side].peer.some((peer) => peer !== null)));
  for (const row of $("nodes").rows) {
    row.cells[2].hidden = !isChain;
    row.cells[4].hidden = row.cells[5].hidden = !hasLinks;
    row.cells[6].hidden = !hasTargets;
  }
  $("strength").hidden = $("links-box").hidden = !hasLinks && !team.length;
  $("links-why").hidden = isChain;
  $("target-legend").hidden = !hasTargets;
  $("strength-weak").textContent = `${fixed(ramp.from, 0)} dBm`;
  $("strength-strong").textContent = `${fixed(ramp.to, 0)} dBm`;

  // ---- time
  const slider = $("time");
  slider.max = last;
  const cursors = [];
  const frameAt = (t) => {
    let low = 0, high = last;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t + 1e-9) low = middle; else high = middle - 1;
    }
    return low;
  };
  const go = (frame) => { now = Math.min(last, Math.max(0, frame)); render(); };
  let playing = false, clock = 0, stamp = 0;
  function play(on) {
    playing = on;
    if (on && now === last) now = 0;
    clock = times[now];
    stamp = performance.now();
    $("play").setAttribute("aria-label", on ? "Pause" : "Play");
    $("play-icon").setAttribute("d", on ? "M3.5 2.5h3.4v11H3.5zM9.1 2.5h3.4v11H9.1z" : "M4 2.5v11l9.5-5.5z");
    if (on) requestAnimationFrame(tick);
  }
  function tick(at) {
    if (!playing) return;
    // A tab that slept must not leap.
    clock += Math.min(0.1, Math.max(0, (at - stamp) / 1000)) * Number($("speed").value);
    stamp = at;
    const next = frameAt(clock);
    if (next !== now) go(next);
    if (now === last) play(false); else requestAnimationFrame(tick);
  }
  $("play").addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => { go(Number(slider.value)); clock = times[now]; });
  const seek = (t) => { go(frameAt(t)); clock = times[now]; };
  document.addEventListener("keydown", (event) => {
    if (event.target.closest("select") || event.ctrlKey || event.metaKey || event.altKey) return;
    const far = frameAt(times[now] + 10) - now || 1;
    const jumps = { ArrowRight: event.shiftKey ? far : 1, ArrowLeft: event.shiftKey ? -far : -1, Home: -Infinity, End: Infinity };
    if (event.key === " " && !event.target.closest("button")) play(!playing);
    else if (event.key in jumps) { go(now + jumps[event.key]); clock = times[now]; }
    else return;
    event.preventDefault();
  });

  // ---- what was ordered
  const span = times[last] - times[0] || 1;
  const share = (i) => ((times[Math.min(i, last)] - times[0]) / span) * 100;
  const orderAt = (i) => data.orders.findLast(([from]) => from <= i)?.[1] ?? "";
  const timeIn = (element) => (event) => { const box = element.getBoundingClientRect(); return times[0] + ((event.clientX - box.left) / box.width) * span; };
  (() => {
    const name = document.createElement("span"), bar = document.createElement("div");
    name.textContent = "Order";
    bar.className = "orders";
    $("strips").append(name, bar);
    data.orders.forEach(([from, words], n) => {
      const until = data.orders[n + 1]?.[0] ?? last;
      const item = bar.appendChild(document.createElement("span"));
      item.style.left = `${share(from)}%`;
      item.style.width = `${share(until) - share(from)}%`;
      // An order that stands too briefly to be read is told on hover, and in the list of events.
      if (share(until) - share(from) > (bar.clientWidth < 500 ? 22 : 9)) item.textContent = words;
    });
    scrub(bar, timeIn(bar), (t) => `${moment(t)}: ${orderAt(frameAt(t))}`);
  })();

  // ---- what happened: orders, changes of states, links that stay weak
  const LONG = 5; // s: a link that is weak for so long is told
  const MARGIN = 0.5; // dB below the limit, as in the figure "violation"
  const PAUSES = new Set(["waiting", "hovering"]);
  const HOMEWARD = ["homing", "returning", "retiring"];
  // Why the drones of a chain fly home that no order calls.
  const REASONS = { battery: ", since a battery of the chain needs it", radio: ", since the links do not bear the chain" };
  function happened() {
    const all = data.orders.slice(1).map(([i, words]) => ({ i, words: `The operator: ${words}` }));
    const base = nodes.findIndex((node) => node.role === "base");
    nodes.forEach((node, index) => {
      if (node.role === "base") return;
      for (let i = 1; i <= last; i++) {
        if (node.state[i] === node.state[i - 1]) continue;
        const state = data.states[node.state[i]];
        const words = TOLD[state];
        if (!words) continue;
        // Between two goals an explorer waits, and explores on.
        let before = i - 1;
        while (before > 0 && PAUSES.has(data.states[node.state[before]])) before--;
        if (node.state[before] === node.state[i]) continue;
        // It is told already that the drone flies home.
        if (HOMEWARD.includes(state) && HOMEWARD.includes(data.states[node.state[before]])) continue;
        let why = HOMEWARD.includes(state) && state !== "retiring" && !orderAt(i).startsWith("return") ? REASONS[data.ended] ?? "" : "";
        const link = base >= 0 ? towardsHead(base, i) : null;
        if (state === "taking-off" && data.mission === "chain" && index > 0 && data.limit !== null && link && link.filtered !== null && link.filtered < data.limit + 1) {
          why = `: the base hears ${nodes[link.peer].name} with ${fixed(link.filtered, 0)} dBm, and the limit is ${fixed(data.limit, 0)}`;
        }
        all.push({ i, who: node.name, index, words: words + why });
      }
    });
    if (data.limit !== null && data.mission === "chain") {
      nodes.forEach((node, index) => {
        for (let from = null, peer = null, i = 0; i <= last + 1; i++) {
          const link = i <= last ? towardsHead(index, i) : null;
          // Who waits or has landed is not part of the chain.
          const flies = (n) => nodes[n].role === "base" || !GROUNDING.includes(data.states[nodes[n].state[i]]);
          const weak = link !== null && flies(index) && flies(link.peer) && link.truth !== null && link.truth < data.limit - MARGIN && (from === null || link.peer === peer);
          if (weak && from === null) { from = i; peer = link.peer; }
          if (weak || from === null) continue;
          const long = times[Math.min(i, last)] - times[from];
          if (long >= LONG) all.push({ i: from, words: `The link ${nodes[peer].name} – ${node.name} is weaker than ${fixed(data.limit, 0)} dBm for ${long.toFixed(0)} s` });
          from = null;
        }
      });
    }
    const aloft = nodes.filter((node) => node.role !== "base" && node.z[last] > AIRBORNE && !isDown(node, last)).map((node) => node.name);
    if (aloft.length) all.push({ i: last, words: `The record ends; still in the air: ${aloft.join(", ")}` });
    all.sort((a, b) => a.i - b.i);
    // Drones that do the same within two seconds are told together.
    const merged = [];
    for (const event of all) {
      const same = merged.findLast((other) => other.who && event.who && other.words === event.words && times[event.i] - times[other.i] <= 2);
      if (same) same.who.set(event.index, event.who);
      else merged.push({ ...event, who: event.who ? new Map([[event.index, event.who]]) : null });
    }
    const inOrder = (who) => who && [...who].sort(([a], [b]) => a - b).map(([, name]) => name);
    return merged.map((event) => ({ ...event, who: inOrder(event.who) }));
  }
  const plural = (words) => words.replace(/^(\w+)( |,|$)/, (_, verb, end) => `${{ takes: "take", has: "have", lands: "land", rises: "rise", flies: "fly", begins: "begin", gathers: "gather", enters: "enter", searches: "search", backs: "back", comes: "come", is: "are", stops: "stop" }[verb] ?? verb}${end}`).replace(/ flies /g, " fly ").replace(/ relays /g, " relay ").replace(/ says /g, " say ").replace(/its link, and flies back to where it was/, "their links, and fly back to where they were").replace(/its link/g, "their links").replace(/its place/g, "their places").replace(/its motors/g, "their motors");
  const events = happened().map(({ i, who, words }) => {
    const item = document.createElement("li"), jump = document.createElement("button"), time = document.createElement("time");
    jump.type = "button";
    time.textContent = minutes(times[i]);
    const flying = nodes.filter((node) => node.role !== "base").length;
    const names = who && (who.length > 2 && who.length === flying ? "all drones" : who.join(who.length === 2 ? " and " : ", "));
    const text = who ? `${names} ${who.length > 1 ? plural(words) : words}` : words;
    jump.append(time, text[0].toUpperCase() + text.slice(1));
    jump.addEventListener("click", () => { play(false); go(i); clock = times[i]; });
    item.append(jump);
    $("events").append(item);
    return { i, item };
  });
  if (!events.length) $("story").hidden = true;
  let marked = null;
  function markEvent() {
    const current = events.findLast((event) => event.i <= now) ?? null;
    if (current === marked) return;
    marked?.item.classList.remove("current");
    current?.item.classList.add("current");
    marked = current;
  }

  // ---- curves of every drone over time
  function curves(title, unit, digits, of) {
    const drawn = nodes.filter((node) => of(node).some((value) => value !== null));
    if (!drawn.length) return;
    const all = drawn.flatMap(of).filter((value) => value !== null);
    const least = all.reduce((a, b) => Math.min(a, b)), most = all.reduce((a, b) => Math.max(a, b));
    const name = document.createElement("span"), range = document.createElement("small");
    range.textContent = `${fixed(least, digits)} to ${fixed(most, digits)} ${unit}`;
    name.append(title, range);
    const box = document.createElementNS(SVG, "svg");
    box.setAttribute("class", "curves");
    box.setAttribute("viewBox", "0 0 1000 100");
    box.setAttribute("preserveAspectRatio", "none");
    box.setAttribute("role", "img");
    box.setAttribute("aria-label", `${title} of every drone over time`);
    for (const node of drawn) {
      const points = of(node).flatMap((value, i) => (value === null ? [] : [`${share(i) * 10},${96 - (92 * (value - least)) / (most - least || 1)}`]));
      make(box, "polyline", { class: "curve", points: points.join(" "), style: `stroke:${node.colour}` });
    }
    const line = make(box, "line", { y1: 0, y2: 100, stroke: "var(--ink)", "vector-effect": "non-scaling-stroke" });
    cursors.push((t) => { const x = ((t - times[0]) / span) * 1000; line.setAttribute("x1", x); line.setAttribute("x2", x); });
    scrub(box, timeIn(box), (t) => {
      const i = frameAt(t);
      return [`${moment(times[i])}, ${title.toLowerCase()}`, ...drawn.map((node) => `${node.name}: ${fixed(of(node)[i], digits)} ${unit}`)].join("\n");
    });
    $("strips").append(name, box);
  }

  // ---- the axis of time below strips and curves
  const STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200];
  const APART = 64; // pixels from one time to the next
  function axis() {
    const name = document.createElement("span"), bar = document.createElement("div");
    name.textContent = "Time, min:s";
    name.className = "quiet";
    bar.className = "axis";
    bar.setAttribute("role", "img");
    bar.setAttribute("aria-label", `Times from ${minutes(times[0])} to ${minutes(times[last])}`);
    $("strips").append(name, bar);
    const draw = () => {
      const most = Math.max(1, Math.floor(bar.clientWidth / APART));
      const step = STEPS.find((seconds) => span / seconds <= most) ?? span;
      const ticks = [];
      for (let t = Math.ceil(times[0] / step) * step; t <= times[last] + 1e-9; t += step) {
        const tick = document.createElement("span");
        tick.textContent = minutes(t);
        tick.style.left = `${((t - times[0]) / span) * 100}%`;
        // The last one would stand out at the right.
        if ((times[last] - t) / span * bar.clientWidth < 34) tick.className = "end";
        ticks.push(tick);
      }
      bar.replaceChildren(...ticks);
    };
    new ResizeObserver(draw).observe(bar);
    draw();
  }

  // ---- strips of states
  const seen = new Set();
  nodes.filter((node) => node.role !== "base").forEach((node) => {
    const name = document.createElement("span");
    name.textContent = node.name;
    const strip = document.createElementNS(SVG, "svg");
    strip.setAttribute("viewBox", "0 0 1000 10");
    strip.setAttribute("preserveAspectRatio", "none");
    strip.setAttribute("role", "img");
    strip.setAttribute("aria-label", `What ${node.name} was doing over time`);
    const at = (i) => share(i) * 10;
    for (let from = 0, i = 1; i <= last + 1; i++) {
      if (i <= last && node.state[i] === node.state[from]) continue;
      const state = data.states[node.state[from]];
      seen.add(kindOf(state));
      make(strip, "rect", { x: at(from), y: 0, width: Math.max(1, at(i) - at(from)), height: 10, style: `fill:${kindOf(state).colour}` });
      from = i;
    }
    const line = make(strip, "line", { y1: 0, y2: 10, stroke: "var(--ink)", "stroke-width": 2, "vector-effect": "non-scaling-stroke" });
    cursors.push((t) => { const x = ((t - times[0]) / span) * 1000; line.setAttribute("x1", x); line.setAttribute("x2", x); });
    scrub(strip, timeIn(strip), (t) => `${node.name}, ${moment(t)}: ${data.states[node.state[frameAt(t)]]}`);
    $("strips").append(name, strip);
  });
  axis();
  // Before the legend, so that all of them are there when the page is first drawn.
  const flown = nodes.filter((node) => node.role !== "base");
  curves("Height", "m", 2, (node) => (flown.includes(node) ? node.z : []));
  curves("Battery", "V", 2, (node) => node.battery);
  if ($("strips").querySelector(".curves")) axis();
  for (const kind of [...KINDS, OTHER].filter((kind) => seen.has(kind))) {
    const item = document.createElement("span"), box = document.createElement("i");
    box.style.background = kind.colour;
    item.append(box, kind.name);
    $("state-legend").append(item);
  }

  // ---- charts: a cursor over each plot, values under the pointer, a click goes there
  const positionsAt = (t) => {
    const i = frameAt(t);
    return [moment(times[i]), ...nodes.map((node) => `${node.name}: ${fixed(node.way[i], 2)} m`)].join("\n");
  };
  const linked = nodes.map((_, index) => index).filter((index) => index > 0 && times.some((_, i) => towardsHead(index, i)));
  const linkAt = (index) => (t) => {
    const i = frameAt(t), link = towardsHead(index, i);
    const title = `${moment(times[i])}, ${nodes[index].name}`;
    if (!link) return `${title}: no link towards the head`;
    return `${title} – ${nodes[link.peer].name}\nreceived ${fixed(link.raw, 0)} dBm\nfiltered ${fixed(link.filtered, 1)} dBm\ntrue ${fixed(link.truth, 1)} dBm`;
  };
  const UNITS = 10; // of a picture to one of its pixels
  function chart(picture, frames, words) {
    const svg = picture.querySelector("svg");
    if (!svg) return;
    const time = (frame, x) => frame.from + ((x - frame.left) / (frame.right - frame.left)) * (frame.to - frame.from);
    for (const frame of frames) {
      const line = make(svg, "line", { class: "cursor", y1: frame.top * UNITS, y2: frame.bottom * UNITS });
      cursors.push((t) => {
        const x = (frame.left + ((t - frame.from) / (frame.to - frame.from)) * (frame.right - frame.left)) * UNITS;
        line.setAttribute("x1", x); line.setAttribute("x2", x);
      });
    }
    const under = (event) => {
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const [x, y] = [p.x / UNITS, p.y / UNITS];
      const index = frames.findIndex((f) => x >= f.left - 8 && x <= f.right + 8 && y >= f.top - 4 && y <= f.bottom + 4);
      return index < 0 ? null : { index, t: Math.min(frames[index].to, Math.max(frames[index].from, time(frames[index], x))) };
    };
    scrub(svg, (event) => under(event)?.t ?? null, (t, event) => { const at = under(event); return at && words[at.index] ? words[at.index](t) : ""; });
  }
  const tip = $("tip");
  function tell(text, event) {
    tip.hidden = !text;
    if (!text) return;
    tip.textContent = text;
    const { width, height } = tip.getBoundingClientRect();
    tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, innerWidth - width - 8))}px`;
    tip.style.top = `${Math.max(4, Math.min(event.clientY + 14, innerHeight - height - 8))}px`;
  }
  function scrub(element, timeOf, words) {
    let held = false;
    // A finger moves a picture sideways that is wider than the screen: a tap goes to a moment of it.
    const slides = (event) => event.pointerType === "touch" && element.closest(".picture") && element.clientWidth > innerWidth;
    element.addEventListener("click", (event) => {
      const t = timeOf(event);
      if (t !== null) seek(t);
    });
    element.addEventListener("pointerdown", (event) => {
      const t = timeOf(event);
      if (t === null || event.button !== 0 || slides(event)) return;
      held = true;
      element.setPointerCapture(event.pointerId);
      seek(t);
    });
    element.addEventListener("pointermove", (event) => {
      const t = timeOf(event);
      if (held && t !== null) seek(t);
      tell(t === null ? "" : words(t, event), event);
    });
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, () => { held = false; });
    element.addEventListener("pointerleave", () => tell(""));
  }
  if ($("positions")) chart($("positions"), data.frames.positions, data.frames.positions.map(() => positionsAt));
  if ($("links")) chart($("links"), data.frames.links, linked.map(linkAt));

  // ---- the map under the pointer
  marks.forEach((mark, index) => {
    const node = nodes[index];
    const words = () => {
      const lines = [`${node.name}: ${data.states[node.state[now]]}`, `x ${fixed(node.x[now], 2)}, y ${fixed(node.y[now], 2)}, height ${fixed(node.z[now], 2)} m`, isChain ? `${fixed(node.way[now], 2)} m along the tunnel` : `flies to: ${toWords(node)}`];
      for (const [side, link] of [["front", node.front], ["back", node.back]]) {
        if (link.peer[now] !== null && !isDown(node, now) && !isDown(nodes[link.peer[now]], now)) lines.push(`${side}: ${nodes[link.peer[now]].name}, ${fixed(link.filtered[now], 1)} dBm`);
      }
      const heard = team.filter((pair) => pair.ends.includes(index) && pair.dbm[now] !== null).sort((a, b) => b.dbm[now] - a.dbm[now]);
      for (const { ends, dbm } of heard.slice(0, 6)) lines.push(`hears ${nodes[ends[0] === index ? ends[1] : ends[0]].name}: ${fixed(dbm[now], 0)} dBm`);
      const beams = node.ranges.map((r) => fixed(r[now], 2));
      if (beams.some((b) => b !== "–")) lines.push(`beams NW ${beams[0]}, NE ${beams[1]}, SW ${beams[2]}, SE ${beams[3]} m`);
      return lines.join("\n");
    };
    mark.body.addEventListener("pointermove", (event) => tell(words(), event));
    mark.body.addEventListener("pointerleave", () => tell(""));
  });
  let grip = null;
  map.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    grip = place(event);
    map.setPointerCapture(event.pointerId);
    map.classList.add("dragging");
  });
  map.addEventListener("pointermove", (event) => {
    if (!grip) return;
    const p = place(event);
    view = { ...view, x: view.x + grip.x - p.x, y: view.y + grip.y - p.y };
    show();
  });
  for (const end of ["pointerup", "pointercancel"]) map.addEventListener(end, () => { grip = null; map.classList.remove("dragging"); });
  map.addEventListener("wheel", (event) => {
    // Without a key the wheel scrolls the page, as everywhere.
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, place(event));
  }, { passive: false });
  $("zoom-in").addEventListener("click", () => zoom(1 / 1.5));
  $("zoom-out").addEventListener("click", () => zoom(1.5));
  $("zoom-fit").addEventListener("click", () => { view = { ...world }; show(); });
  new ResizeObserver(show).observe(map);

  // report.html#t=120 opens at that second.
  const asked = /^#t=([\d.]+)$/.exec(location.hash);
  now = asked ? frameAt(Number(asked[1])) : 0;
  show();
})();
