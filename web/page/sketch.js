// A cave that the user draws: galleries as lists of corners in metres, and the pen, where the next leg begins.
export const distance = ([ax, ay], [bx, by]) => Math.hypot(ax - bx, ay - by);
const same = (a, b) => a[0] === b[0] && a[1] === b[1];
const rounded = (at, parts) => at.map((value) => Math.round(value * parts) / parts);
const nearest = (all, at) => all.reduce((best, each) => (best && distance(best, at) <= distance(each, at) ? best : each), null);

export class Sketch {
  constructor() {
    Object.assign(this, { width: 1.6, galleries: [], pen: null, earlier: [] });
  }

  // Each corner once.
  get corners() {
    return this.galleries.flat().filter((at, n, all) => all.findIndex((other) => same(other, at)) === n);
  }

  get legs() {
    return this.galleries.flatMap((corners, gallery) => corners.slice(1).map((to, n) => ({ gallery, n, from: corners[n], to })));
  }

  get length() {
    return this.legs.reduce((sum, { from, to }) => sum + distance(from, to), 0);
  }

  // Draws a leg from the pen to this place, or puts the mouth there. A leg from the end of a gallery goes on with
  // that gallery, and any other begins a branch.
  add(place) {
    const at = rounded(place, 10);
    this.keep();
    const ended = this.galleries.find((corners) => same(corners.at(-1), this.pen));
    if (this.galleries.length === 0) this.galleries.push([at]);
    else if (ended) ended.push(at);
    else this.galleries.push([this.cornered(this.pen), at]);
    this.pen = at;
  }

  // The corner or the point of a leg that is meant by this place, where it lies on a gallery or within `reach` metres
  // of its middle; else null. A point that is too near to a corner for a branch of its own means the corner.
  meant(place, reach) {
    const corner = nearest(this.corners, place);
    const foot = nearest(this.legs.map(({ from, to }) => footOf(place, from, to)), place) ?? corner;
    if (!foot || distance(foot, place) > Math.max(reach, this.width / 2)) return null;
    const near = nearest(this.corners, foot);
    return distance(near, foot) < Math.max(reach, this.width) ? near : rounded(foot, 100);
  }

  isCorner(at) {
    return this.corners.some((corner) => same(corner, at));
  }

  // Moves a corner, in all galleries that have it.
  move(corner, place) {
    const to = rounded(place, 10);
    this.galleries = this.galleries.map((corners) => corners.map((at) => (same(at, corner) ? to : at)));
    // A pen between two corners is no longer on its leg.
    if (same(this.pen, corner) || !this.isCorner(this.pen)) this.pen = to;
    return to;
  }

  // Puts the pen to the corner that was drawn before the one where it is, and from the mouth to the last one.
  back() {
    const { corners } = this;
    const now = corners.findIndex((at) => same(at, this.pen));
    this.pen = corners.at(now - 1) ?? null;
  }

  clear() {
    this.keep();
    Object.assign(this, { galleries: [], pen: null });
  }

  // Keeps the drawing as it is, so that what comes next can be undone.
  keep() {
    const { galleries, pen } = this;
    this.earlier.push(structuredClone({ galleries, pen }));
  }

  undo() {
    Object.assign(this, this.earlier.pop());
  }

  // Makes a place between two corners of a leg a corner, from which a branch can begin.
  cornered(at) {
    if (this.isCorner(at)) return at;
    const off = ({ from, to }) => distance(footOf(at, from, to), at);
    const { gallery, n } = this.legs.reduce((best, leg) => (off(leg) < off(best) ? leg : best));
    this.galleries[gallery].splice(n + 1, 0, at);
    return at;
  }
}

// The point of a leg that is nearest to a place.
function footOf([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const square = dx * dx + dy * dy;
  const along = square > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / square, 0), 1) : 0;
  return [ax + along * dx, ay + along * dy];
}
