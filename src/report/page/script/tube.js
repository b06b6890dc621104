// A root's surface: rings of vertices about the centreline that do not twist about it, as src/roots/tube.rs makes them.
// Coordinates are (x, −y, −z) of the tank frame: a half turn, so that up is up and nothing is mirrored.
const RING_MM = data.tank.radius / 60;
const placed = (p, k) => [p[3 * k], -p[3 * k + 1], -p[3 * k + 2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => {
  const length = Math.hypot(...a);
  return length > 1e-9 ? a.map((x) => x / length) : null;
};

// The points of a root that its tube needs: its ends, and between them no two nearer than `apart` mm.
function ringsOf(root, apart) {
  const kept = [], p = root.xyz, n = root.d.length;
  let last = null;
  for (let k = 0; k < n; k++) {
    const far = last === null || Math.hypot(p[3 * k] - p[3 * last], p[3 * k + 1] - p[3 * last + 1], p[3 * k + 2] - p[3 * last + 2]) >= apart;
    if (far || k === n - 1) kept.push((last = k));
  }
  return kept;
}

// Adds the root's tube to `mesh` (x, y, z, i, j, k, and of every vertex its root and point), wider by `extra` mm.
function addTube(mesh, root, sides, extra = 0) {
  const rings = ringsOf(root, RING_MM), n = rings.length;
  if (n < 2) return;
  const first = mesh.x.length;
  let across = null, last = [0, 0, 1];
  for (let k = 0; k < n; k++) {
    const here = placed(root.xyz, rings[k]);
    const along = unit(minus(placed(root.xyz, rings[Math.min(k + 1, n - 1)]), placed(root.xyz, rings[Math.max(k - 1, 0)]))) || last;
    const side = across || (Math.abs(along[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
    const lean = dot(side, along);
    across = unit(minus(side, along.map((x) => x * lean))) || across || [1, 0, 0];
    last = along;
    const third = cross(along, across), radius = root.d[rings[k]] / 2 + extra;
    for (let s = 0; s < sides; s++) {
      const [sin, cos] = [Math.sin((2 * Math.PI * s) / sides), Math.cos((2 * Math.PI * s) / sides)];
      mesh.x.push(here[0] + radius * (across[0] * cos + third[0] * sin));
      mesh.y.push(here[1] + radius * (across[1] * cos + third[1] * sin));
      mesh.z.push(here[2] + radius * (across[2] * cos + third[2] * sin));
      mesh.root.push(root.id);
      mesh.point.push(rings[k]);
    }
  }
  const triangle = (a, b, c) => {
    mesh.i.push(first + a);
    mesh.j.push(first + b);
    mesh.k.push(first + c);
  };
  for (let k = 0; k + 1 < n; k++) {
    for (let s = 0; s < sides; s++) {
      const [a, b] = [k * sides + s, k * sides + ((s + 1) % sides)];
      triangle(a, b, b + sides);
      triangle(a, b + sides, a + sides);
    }
  }
  const end = (n - 1) * sides;
  for (let s = 1; s + 1 < sides; s++) {
    triangle(0, s + 1, s);
    triangle(end, end + s, end + s + 1);
  }
}

const emptyMesh = () => ({ x: [], y: [], z: [], i: [], j: [], k: [], root: [], point: [] });
