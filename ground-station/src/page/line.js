// The line to the station: it connects, notices a stall, and keeps a stop until it has arrived.
//
// Each request carries the stamp of the last state that has come, the time since the person's act,
// and a number; the station bounds the age of an order by them (ground-station/src/freshness.rs).
// The numbers that the station has heard come back in its states.
"use strict";

const BEAT_MS = 250; // The station takes a page that is silent for 1.5 s for gone.
const FRESH_MS = 500; // The station refuses orders that may be older.
const STALE_MS = 1000; // States come every 100 ms.
const PATIENCE_MS = [2000, 16000]; // The time without an answer after which a line is given up.

// A random number tells this page from all others, also when it connects anew.
const PAGE = Number(crypto.getRandomValues(new BigUint64Array(1))[0] >> 11n);
const STOP_KEPT = "uchain-stop"; // In the tab's storage: the page may be loaded anew.
const STOP_KEPT_MS = 600000; // A tab that is restored a day later stops nothing.

// Whether a stop that the station has heard holds: the base has answered, or a person has given up
// waiting, or the base was switched off and on since. Until then the station may still go away with
// it.
function stopHolds(stop) {
  return stop === null || stop.sending !== "repeating" || stop.base_s !== null;
}

const line = {
  session: document.querySelector("meta[name=session]").content,
  socket: null,
  wasOpen: false,
  // When the present attempt to connect began, or the line was opened.
  began: 0,
  patience: PATIENCE_MS[0],
  // The last state, its stamp, and when it came.
  state: null,
  stamp: null,
  came: -Infinity,
  // The number of the last request, and when each that was not heard yet was written to this line.
  seq: 0,
  written: new Map(),
  // The names of the orders that were written to this line and not heard yet, by number.
  orders: new Map(),
  // The stop of which it is not known yet that it holds, by its number, and whether the station has
  // heard it.
  stop: null,
  stopIsHeard: false,
  onWelcome: () => {},
  onState: () => {},
  onLost: () => {}, // Takes the orders that were written to a line that is no more.

  connect() {
    this.began = performance.now();
    if (this.orders.size > 0) this.onLost(this.orders);
    this.written.clear();
    this.orders.clear();
    const again = this.wasOpen ? "&again=true" : "";
    const socket = new WebSocket(`ws://${location.host}/live?session=${this.session}&page=${PAGE}${again}`);
    this.socket = socket;
    socket.onopen = () => {
      this.began = performance.now();
      this.wasOpen = true;
      this.writeStop();
    };
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      if ("page" in message) this.onWelcome(message);
      else if ("drones" in message) this.take(message);
    };
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.socket = null;
      setTimeout(() => this.renew(), 500);
    };
  },

  // A station that was restarted has another session; the page looks on there.
  async renew() {
    try {
      const answer = await fetch(location.href, { cache: "no-store", signal: AbortSignal.timeout(this.patience) });
      const page = new DOMParser().parseFromString(await answer.text(), "text/html");
      const session = page.querySelector("meta[name=session]")?.content ?? this.session;
      if (session !== this.session) this.forget();
      this.session = session;
    } catch { /* The station is not there now. */ }
    if (!this.socket) this.connect();
  },

  forget() {
    [this.stamp, this.came, this.wasOpen] = [null, -Infinity, true];
  },

  take(state) {
    const now = performance.now();
    [this.state, this.stamp, this.came] = [state, state.stamp, now];
    const heard = state.heard.find(({ page }) => page === PAGE);
    for (const [seq, at] of this.written) {
      if (seq > (heard?.last ?? 0)) break;
      if (now - at < STALE_MS) this.patience = PATIENCE_MS[0];
      this.written.delete(seq);
      this.orders.delete(seq);
    }
    this.stopIsHeard = this.stop !== null && (heard?.stop ?? 0) >= this.stop;
    if (this.stopIsHeard && stopHolds(state.stop)) this.keepStop(null);
    this.onState(state);
  },

  isOpen() {
    return this.socket !== null && this.socket.readyState === WebSocket.OPEN;
  },

  // For how long nothing has come, and for how long the station has not heard what was written.
  age() {
    return performance.now() - this.came;
  },
  lag() {
    const [oldest] = this.written.values();
    return oldest === undefined ? 0 : performance.now() - oldest;
  },

  write(request, held = 0, seq = ++this.seq) {
    if (!this.isOpen()) return;
    // A stop that is written again says nothing about this line when a later request was heard.
    if (seq === this.seq && !this.written.has(seq)) this.written.set(seq, performance.now());
    this.socket.send(JSON.stringify({ ...request, stamp: this.stamp, held: Math.ceil(held), seq }));
  },

  // Writes what must not arrive late. Returns why it was not written; an empty text where it was.
  writeFresh(request, acted, name) {
    const held = Math.max(0, performance.now() - acted);
    if (!this.isOpen() || this.stamp === null) return "there is no line to the station";
    if (this.age() >= FRESH_MS) return `nothing has come from the station for ${(this.age() / 1000).toFixed(1)} s`;
    if (held >= FRESH_MS) return `this page was busy for ${(held / 1000).toFixed(1)} s`;
    this.write(request, held);
    this.orders.set(this.seq, name);
    return "";
  },

  // A stop is written to any line, however old its last state is, and to each new line until a state
  // says that it holds. The station takes it once, however often it is written.
  orderStop() {
    this.keepStop(++this.seq);
    this.writeStop();
  },
  writeStop() {
    if (this.stop !== null) this.write({ do: "stop" }, 0, this.stop);
  },
  keepStop(seq) {
    this.stop = seq;
    try {
      if (seq === null) sessionStorage.removeItem(STOP_KEPT);
      else sessionStorage.setItem(STOP_KEPT, Date.now());
    } catch { /* Without a storage the stop is lost when the page is loaded anew. */ }
  },

  // Four times a second: a sign of life, the stop again, and an end to a line that is stalled.
  beat() {
    if (this.isOpen()) {
      if (this.stamp !== null) this.write({ do: "beat" });
      this.writeStop();
    }
    const waited = Math.min(performance.now() - this.began, Math.max(this.age(), this.lag()));
    if (this.socket && waited > this.patience) this.giveUp();
  },

  // Leaves the socket to itself: closing it waits for an answer over the line that gives none.
  giveUp() {
    const socket = this.socket;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    // A line that is only slow must not be given up again and again.
    this.patience = Math.min(2 * this.patience, PATIENCE_MS[1]);
    this.connect();
  },

  begin() {
    try {
      const kept = sessionStorage.getItem(STOP_KEPT);
      if (kept !== null && Math.abs(Date.now() - kept) < STOP_KEPT_MS) this.orderStop();
    } catch { /* No storage. */ }
    addEventListener("beforeunload", (event) => {
      if (this.stop !== null) event.preventDefault();
    });
    setInterval(() => this.beat(), BEAT_MS);
    this.connect();
  },
};
