// Solids of bodies and joints, springs and rods, as meshes of three.js.

const WIRE = 0.16; // radius of a coil's wire over that of the coil
const COILS = 8;
const ROD = 0.35; // radius of a rod, in half widths of a spring
const SHARP = 0.55; // rad between triangles at whose edge a mesh is not smooth
const PALE = 0.22; // share of a body's fill in its colour
const SHEER = 0.35; // opacity of plates, which bodies are behind

/** Unit forms: radius 1, along z from -1 to 1. */
function formsOf() {
  const box = new globalThis.THREE.BoxGeometry(2, 2, 2);
  return {
    ball: new globalThis.THREE.SphereGeometry(1, 20, 12),
    cylinder: new globalThis.THREE.CylinderGeometry(1, 1, 2, 24).rotateX(Math.PI / 2),
    box,
    plate: box,
  };
}

/** The world of a scene: {root, bodies, links, meshes, update(), paint(chosen)}. */
export function buildSolids(scene) {
  const forms = formsOf();
  const root = new globalThis.THREE.Group();
  const meshes = [];
  const bodies = scene.bodies.map(() => new globalThis.THREE.Group());
  root.add(...bodies);
  const add = (parent, geometry, color, known) => {
    const mesh = new globalThis.THREE.Mesh(geometry);
    mesh.userData = { color, ...known };
    parent.add(mesh);
    meshes.push(mesh);
    return mesh;
  };
  for (const solid of scene.run.solids) {
    const { form, body, matrix, element } = solid;
    const ground = scene.bodies[body].fixed;
    const color = ground ? "ground" : element ? "joint" : scene.number(body);
    const mesh = add(bodies[body], forms[form] ?? geometryOf(solid), color, { element, body, sheer: form === "plate" });
    mesh.matrixAutoUpdate = false;
    if (matrix) mesh.matrix.set(...matrix, 0, 0, 0, 1);
  }
  const links = scene.links.map((link) => {
    const group = new globalThis.THREE.Group();
    const long = lengthOf(scene, link) || scene.size;
    const part = (geometry, color) => add(group, geometry, color, { element: link.element });
    for (const kind of link.parts) buildLink(part, kind, link.half_width, long, link.parts.length > 1);
    root.add(group);
    return { link, group };
  });
  const update = () => {
    bodies.forEach((group, body) => {
      const { x, y, z, e } = scene.poses[body];
      group.visible = Number.isFinite(x + y + z + e[0] + e[1] + e[2] + e[3]);
      group.position.set(x, y, z);
      group.quaternion.set(e[1], e[2], e[3], e[0]);
    });
    for (const { link, group } of links) placeLink(scene, link, group);
    for (const mesh of meshes) if (mesh.userData.element in scene.run.acts) mesh.visible = scene.acts(mesh.userData.element);
  };
  return { root, meshes, update, paint: painter(scene, meshes) };
}

/** The surface of triangles that a modeller gave. */
function geometryOf({ corners, triangles }) {
  const geometry = new globalThis.THREE.BufferGeometry();
  geometry.setAttribute("position", new globalThis.THREE.BufferAttribute(corners, 3));
  geometry.setIndex([...triangles]);
  return globalThis.THREE.toCreasedNormals(geometry, SHARP);
}

function lengthOf(scene, { i, j }) {
  const [a, b] = [scene.place(i), scene.place(j)];
  return Math.hypot(b.x - a.x, b.y - a.y, b.z - a.z);
}

/** Parts of a link of length 1 along z, which is scaled to its length. */
function buildLink(part, kind, width, long, several) {
  const tube = (radius, from, to) => new globalThis.THREE.CylinderGeometry(radius, radius, to - from, 16)
    .rotateX(Math.PI / 2).translate(0, 0, (from + to) / 2);
  if (kind === "rod") part(tube(ROD * width, 0, 1), "joint");
  else if (kind === "spring") {
    const turn = (s) => [width * Math.cos(2 * Math.PI * COILS * s), width * Math.sin(2 * Math.PI * COILS * s)];
    const points = Array.from({ length: 24 * COILS + 1 }, (_, k) => {
      const s = k / (24 * COILS);
      return new globalThis.THREE.Vector3(...turn(s), long * (0.08 + 0.84 * s));
    });
    const coil = new globalThis.THREE.TubeGeometry(new globalThis.THREE.CatmullRomCurve3(points), 24 * COILS, WIRE * width, 8);
    part(coil.scale(1, 1, 1 / long), "spring");
    for (const [from, to] of [[0, 0.08], [0.92, 1]]) part(tube(WIRE * width, from, to), "spring");
  } else {
    const slim = several ? 0.55 : 0.9;
    part(tube(slim * width, 0.08, 0.58), kind);
    part(tube(0.35 * slim * width, 0, 1), "joint");
  }
}

function placeLink(scene, link, group) {
  const [a, b] = [scene.place(link.i), scene.place(link.j)];
  const way = new globalThis.THREE.Vector3(b.x - a.x, b.y - a.y, b.z - a.z);
  const long = way.length();
  group.visible = Number.isFinite(long) && long > 0 && scene.acts(link.element);
  if (!group.visible) return;
  group.position.set(a.x, a.y, a.z);
  group.quaternion.setFromUnitVectors(new globalThis.THREE.Vector3(0, 0, 1), way.divideScalar(long));
  group.scale.set(1, 1, long);
}

/** A function that gives all meshes the colours of the style sheet, and what is chosen its own. */
function painter(scene, meshes) {
  const materials = new Map();
  const material = (name, sheer) => {
    const key = sheer ? `sheer ${name}` : name;
    const look = sheer && { transparent: true, opacity: SHEER, depthWrite: false };
    if (!materials.has(key)) materials.set(key, new globalThis.THREE.MeshLambertMaterial({ ...look, userData: { name } }));
    return materials.get(key);
  };
  return (chosen) => {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => new globalThis.THREE.Color(style.getPropertyValue(`--${name}`).trim());
    for (const mesh of meshes) {
      const { color: name, element, body, sheer } = mesh.userData;
      const owner = element || scene.bodies[body]?.name;
      mesh.material = material(chosen && owner === chosen ? "accent" : name, sheer);
    }
    for (const one of materials.values()) {
      const { name } = one.userData;
      if (typeof name === "number") one.color = color(`line-${name}`).lerp(color(`fill-${name}`), PALE);
      else one.color = { ground: () => color("hatching").lerp(color("background"), 0.4),
        joint: () => color("joint").lerp(color("background"), 0.45) }[name]?.() ?? color(name);
    }
  };
}
