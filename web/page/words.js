// How the page says numbers, orders and missions.
export const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")}`;
export const dbm = (value) => `${value.toFixed(0).replace("-", "−")} dBm`;
export const percent = (share) => (share === null || share === undefined ? "–" : `${Math.round(share * 100)} %`);

export const ABOUT = {
  chain: "A head flies into a cave; relays follow by themselves, so that its radio link to the base lasts.",
  explore: "Explorers map a place together, each with its own map: dark ground is known to none of them, and at the amber frontier they go on. A cross is where an explorer flies to.",
  swarm: "A swarm surveys an area in rows, gathers, and crosses a narrow passage.",
};

// The order as a pilot would say it.
export function orderWords(order, mission) {
  const speed = /^explore at ([−-]?)([\d.]+) m\/s(.*)$/.exec(order);
  if (!speed || mission !== "chain") return order.replace(/^explore at .*$/, "explore");
  const [, sign, value, rest] = speed;
  return (Number(value) === 0 ? "hover" : `fly ${sign ? "back" : "in"} at ${value} m/s`) + rest;
}

export const flying = ({ drones }, { nodes }) => drones.filter(({ z }, n) => z > 0.05 && nodes[n].role !== "base").length;

// What the map shows, for those who do not see it.
export function mapWords(setting, frame, figures) {
  const inAir = `${flying(frame, setting)} of ${setting.nodes.length - 1} in the air`;
  const part = (share, words) => (share === null || share === undefined ? "" : `, and ${percent(share)} of ${words}`);
  return {
    chain: () => `The cave and the drones from above: the head is ${Math.round(frame.drones[0].way)} m from the base.`,
    explore: () => `The place and the explorers from above: ${inAir}${part(figures.explored, "the place is known")}.`,
    swarm: () => `The area and the swarm from above: ${inAir}${part(figures.covered, "the area was flown over")}.`,
  }[setting.mission]();
}
