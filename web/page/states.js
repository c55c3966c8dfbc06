// The states of the on-board code, in words.
export const STATES = {
  idle: "waits on the ground", armed: "is called, and takes off next", "taking-off": "takes off",
  leading: "leads: flies as the pilot orders", relaying: "relays: flies to the weaker of its links",
  reconnecting: "reconnects: flies back to where its link was", searching: "searches for a better place",
  retiring: "retires: is needed no more", homing: "flies home", rejoining: "rejoins the chain",
  siting: "looks for a spot to land on", "backing-up": "backs up to keep its link", perched: "relays from the ground",
  rising: "rises again", landing: "lands", landed: "has landed", stopped: "is stopped",
  hovering: "hovers", surveying: "surveys its part", gathering: "gathers at the entrance", crossing: "crosses the passage",
  lost: "has lost its place", waiting: "hovers", exploring: "explores", returning: "returns",
};
