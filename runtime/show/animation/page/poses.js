// Where everything is at an instant: interpolation between samples, places of bodies.

/** Numbers of one array of float32, or of two, whose sum has them to 48 bits. */
export function summed(high, low) {
  return low ? Float64Array.from(high, (value, k) => value + low[k]) : high;
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

/** The pose {x, y, phi, c, s} of a body, or of a stroke that moves within its body, from its arrays. */
export function poseOf(arrays, at) {
  const [x, y, phi = 0] = arrays.map((values) => mixed(values, at));
  return { x, y, phi, c: Math.cos(phi), s: Math.sin(phi) };
}

/** Points {x, y} of an array of both in turn. */
export function pairs(numbers) {
  return Array.from({ length: numbers.length / 2 }, (_, k) => ({ x: numbers[2 * k], y: numbers[2 * k + 1] }));
}

/** A place of a body in global axes, m. */
export function inWorld(poses, place) {
  const pose = poses[place.body];
  return {
    x: pose.x + pose.c * place.x - pose.s * place.y,
    y: pose.y + pose.s * place.x + pose.c * place.y,
  };
}
