// From the numbers of the data to geometry that three.js draws.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, EdgesGeometry, Matrix4, Quaternion, ShapeUtils, Vector2, Vector3,
} from "three";

const UP = new Vector3(0, 0, 1);
const THIN = 0.004;

export const CUBE = kept(new BoxGeometry(1, 1, 1));
const EDGES = new EdgesGeometry(CUBE).getAttribute("position");

/** Mark a geometry as one that outlives what is drawn with it. */
function kept(geometry) {
  geometry.userData.kept = true;
  return geometry;
}

/** Free what a group was drawn with, but for what is kept. */
export function freed(group) {
  group.traverse((one) => {
    if (one.geometry && !one.geometry.userData.kept) one.geometry.dispose();
    if (one.isInstancedMesh) one.dispose();
  });
}

/** The shape of a thing as geometry, made once; null for a thing that is drawn as its box. */
export class Shapes {
  constructor(told) {
    this.told = told;
    this.made = new Map();
  }

  of(thing) {
    if (!this.made.has(thing.index)) this.made.set(thing.index, this.make(this.told?.[thing.index] ?? null));
    return this.made.get(thing.index);
  }

  /** Free all that was made. */
  free() {
    for (const geometry of this.made.values()) geometry?.dispose();
    this.made.clear();
  }

  make(shape) {
    if (shape === null) return null;
    return kept(shape.ring ? ringGeometry(shape) : shape.vertices ? meshGeometry(shape) : pointGeometry(shape));
  }
}

/** Where a unit cube has to be to stand for a box. */
export function placed(center, half, yaw) {
  const size = new Vector3(...half.map((one) => Math.max(2 * one, THIN)));
  return new Matrix4().compose(new Vector3(...center), new Quaternion().setFromAxisAngle(UP, yaw), size);
}

/** The edges of many placed cubes in one geometry. */
export function edgesOf(matrices) {
  const points = new Float32Array(matrices.length * EDGES.count * 3);
  const point = new Vector3();
  matrices.forEach((matrix, number) => {
    for (let corner = 0; corner < EDGES.count; corner += 1) {
      point.fromBufferAttribute(EDGES, corner).applyMatrix4(matrix);
      point.toArray(points, (number * EDGES.count + corner) * 3);
    }
  });
  return new BufferGeometry().setAttribute("position", new BufferAttribute(points, 3));
}

const inMetres = (row) => Float32Array.from(row, (one) => one / 1000);

/** A mesh of the data. */
function meshGeometry(shape) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(inMetres(shape.vertices), 3));
  geometry.setIndex(shape.faces);
  geometry.computeVertexNormals();
  return geometry;
}

/** Points of the data: a geometry without faces. */
const pointGeometry = (shape) => new BufferGeometry().setAttribute("position", new BufferAttribute(inMetres(shape.points), 3));

/** Whether a geometry is of points only. */
export const isCloud = (geometry) => geometry.getIndex() === null && !geometry.getAttribute("normal");

/** A flat polygon, cut into triangles in its own plane. */
function ringGeometry(shape) {
  const flat = inMetres(shape.ring);
  const points = Array.from({ length: flat.length / 3 }, (_, at) => new Vector3().fromArray(flat, 3 * at));
  const normal = new Vector3();
  points.forEach((one, at) => normal.add(new Vector3().crossVectors(one, points[(at + 1) % points.length])));
  const away = ["x", "y", "z"].reduce((a, b) => (Math.abs(normal[b]) > Math.abs(normal[a]) ? b : a));
  const [u, v] = ["x", "y", "z"].filter((one) => one !== away);
  const faces = ShapeUtils.triangulateShape(points.map((one) => new Vector2(one[u], one[v])), []);
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(flat, 3));
  geometry.setIndex(faces.flat());
  geometry.computeVertexNormals();
  return geometry;
}

/** The box of the space on one side of a thing, and of the face where it begins. */
export function spaceBoxes(thing, frame, axis) {
  const number = "XYZ".indexOf(axis[0]);
  const sign = axis[1] === "+" ? 1 : -1;
  const upright = number === 2;
  if (frame === null) return null;
  const half = upright ? thing.half : frame.slice(0, 3);
  const yaw = upright ? thing.yaw : frame[3];
  const reach = frame[4 + number];
  const boxes = [[0.5 * reach, half[number] + 0.5 * reach], [0, half[number]]].map(([deep, away]) => {
    const size = half.with(number, deep);
    const offset = new Vector3().setComponent(number, sign * away).applyAxisAngle(UP, yaw);
    return placed(offset.add(new Vector3(...thing.center)).toArray(), size, yaw);
  });
  return { volume: boxes[0], face: boxes[1] };
}
