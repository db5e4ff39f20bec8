// Where everything is at an instant: interpolation between samples, places of bodies.

/** Instants of a run in s: the sum of two arrays of float32, which has them to 48 bits. */
export function instants(high, low) {
  return Float64Array.from(high, (value, k) => value + low[k]);
}

/** Angles in rad: an array of them within half a turn of 0, and one of whole turns, where any are. */
export function angles(wrapped, turns) {
  return turns ? Float64Array.from(wrapped, (value, k) => value + 2 * Math.PI * turns[k]) : wrapped;
}

/** Samples around an instant: {low, high, share}; of several at that instant the last one. */
export function locate(times, t) {
  let low = 0;
  let above = times.length;
  while (above - low > 1) {
    const middle = (low + above) >> 1;
    if (times[middle] <= t) low = middle;
    else above = middle;
  }
  const high = Math.min(low + 1, times.length - 1);
  const width = times[high] - times[low];
  const share = width > 0 ? Math.min(Math.max((t - times[low]) / width, 0), 1) : 0;
  return { low, high, share };
}

/** A series between two samples; where one of them is no number, the other. */
export function mixed(values, at) {
  const low = values[at.low];
  const high = values[at.high];
  if (Number.isNaN(high)) return low;
  return Number.isNaN(low) ? high : low + at.share * (high - low);
}

/** The pose of a body: {x, y, phi, c, s}. */
export function poseOf(body, at) {
  const [x, y, phi] = body.pose.map((values) => mixed(values, at));
  return { x, y, phi, c: Math.cos(phi), s: Math.sin(phi) };
}

/** How far a stroke has moved within its body, and turned: a pose like that of a body. */
export function shiftOf([x, y, turn], at) {
  const phi = turn ? mixed(turn, at) : 0;
  return { x: mixed(x, at), y: mixed(y, at), phi, c: Math.cos(phi), s: Math.sin(phi) };
}

/** A place of a body in global axes, m. */
export function inWorld(poses, place) {
  const pose = poses[place.body];
  return {
    x: pose.x + pose.c * place.x - pose.s * place.y,
    y: pose.y + pose.s * place.x + pose.c * place.y,
  };
}

/** Writes the numbers of a symbol that vary into its shape. */
export function refresh(symbol, at) {
  for (const { path, values } of symbol.moving) {
    let owner = symbol.shape;
    for (const name of path.slice(0, -1)) owner = owner[name];
    owner[path.at(-1)] = mixed(values, at);
  }
}

/** Whether a joint that comes and goes acts at an instant. */
export function acts(symbol, t) {
  if (!symbol.acts) return true;
  return symbol.acts.some(([from, to]) => from <= t && t < to);
}
