// The figures of a mission under way.
import { linksOf } from "./draw.js";
import { clock, dbm, flying, percent } from "./words.js";

// The five numbers that matter in a mission of this kind, each with its words.
export function figureList(figures, frame, setting) {
  const weakest = Math.min(...linksOf(frame).map((link) => link.dbm));
  const metres = figures.farthest_m;
  const radio = [[figures.packets_sent ?? "–", "packets on the air"], [clock(frame.t), "of mission time"]];
  const own = {
    chain: () => [
      [metres === undefined || metres === null ? "–" : `${metres.toFixed(1)} m`, "from the base at the farthest"],
      [weakest < Infinity ? dbm(weakest) : "–", `the weakest link; a relay takes off below ${dbm(setting.launch_dbm)}`],
      [percent(figures.weak_share), "of the time some link was weaker than that"],
    ],
    explore: () => [[percent(figures.explored), "of the place is known"], ...radio],
    swarm: () => [[percent(figures.covered), "of the area was flown over"], ...radio],
  }[setting.mission]();
  const touches = (figures.wall_contacts ?? 0) + (figures.drone_contacts ?? 0);
  return [
    ...own,
    [String(flying(frame, setting)), `of ${setting.nodes.length - 1} drones in the air`],
    [String(touches), "touches of walls and of other drones"],
  ];
}
