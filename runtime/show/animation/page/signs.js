// Elements of SVG, and the small signs of which symbols consist. Lengths are in the unit of the
// scene; `u` is the radius of a pin.

const SVG = "http://www.w3.org/2000/svg";

/** An element of SVG with attributes and children. */
export function svg(name, attributes = {}, ...children) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

/** A path through points, closed or not; points that are no numbers are left out. */
export function through(points, closed = false) {
  const known = points.filter(({ x, y }) => Number.isFinite(x) && Number.isFinite(y));
  const line = known.map(({ x, y }) => `${x.toFixed(6)} ${y.toFixed(6)}`).join("L");
  return known.length ? `M${line}${closed ? "Z" : ""}` : "";
}

/** Places an element at a point, turned by an angle in rad. */
export function place(node, { x, y }, angle = 0) {
  if (!Number.isFinite(x + y + angle)) return;
  const turn = angle ? `rotate(${(((angle * 180) / Math.PI) % 360).toFixed(4)})` : "";
  node.setAttribute("transform", `translate(${x.toFixed(6)} ${y.toFixed(6)})${turn}`);
}

/** A curved arrow about the origin, counter-clockwise where `turn` is positive. */
export function roundArrow(radius, turn) {
  const sign = turn < 0 ? -1 : 1;
  const [from, to] = [-0.6, 3.2].map((angle) => sign * angle);
  const at = (angle, r = radius) => `${r * Math.cos(angle)} ${r * Math.sin(angle)}`;
  const back = to - sign * 0.5;
  return (
    `M${at(from)}A${radius} ${radius} 0 1 ${sign > 0 ? 1 : 0} ${at(to)}` +
    `M${at(back, radius * 1.3)}L${at(to)}L${at(back, radius * 0.72)}`
  );
}

/** A number with unit, four digits, with the prefix that suits it. */
export function withUnit(value, unit) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const scaled = { N: 1, "N m": 1, W: 1, J: 1 }[unit];
  const prefixes = [[1e9, "G"], [1e6, "M"], [1e3, "k"]];
  const found = scaled ? prefixes.find(([limit]) => size >= limit) : undefined;
  const [factor, prefix] = found ?? [1, ""];
  return `${short(value / factor)}${unit ? ` ${prefix}${unit}` : ""}`;
}

/** A number in four digits, or five. */
export function short(value) {
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) return value.toExponential(2).replaceAll("-", "−");
  return value.toPrecision(size >= 1e4 ? 5 : 4).replace("-", "−");
}
