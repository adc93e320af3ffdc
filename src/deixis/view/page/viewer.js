// Who looks from where: a ball at the eyes and the cone of what is ahead.
import {
  BufferAttribute, BufferGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, SphereGeometry,
} from "three";

const WIDE = 0.45;
const TALL = 0.3;
const FAR = 5;

/** The marker of a view, of this size; fainter unless it is the current one. */
export function viewMarker(view, current, size, colour) {
  const group = new Group();
  const opacity = current ? 1 : 0.4;
  const ball = new Mesh(new SphereGeometry(0.35 * size, 16, 12), new MeshBasicMaterial({ color: colour, transparent: true, opacity }));
  const far = FAR * size * (current ? 1 : 0.6);
  const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([y, z]) => [far, WIDE * far * y, TALL * far * z]);
  const lines = corners.flatMap((one, at) => [[0, 0, 0], one, one, corners[(at + 1) % 4]]);
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(lines.flat()), 3));
  group.add(ball, new LineSegments(geometry, new LineBasicMaterial({ color: colour, transparent: true, opacity })));
  group.position.set(...view.position);
  group.rotation.z = view.heading;
  return group;
}
