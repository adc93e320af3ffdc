// What lights up: two things, the points nearest to each other, spaces and their faces, turned boxes.
import {
  BufferAttribute, BufferGeometry, CanvasTexture, DoubleSide, Group, LineBasicMaterial, LineDashedMaterial, LineSegments,
  Mesh, MeshBasicMaterial, MeshLambertMaterial, PlaneGeometry, Points, PointsMaterial, Vector3,
} from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { CUBE, edgesOf, isCloud, placed, spaceBoxes } from "./shapes.js";

// Drawn after all else, and so counted among what is transparent: three.js draws that last.
const ABOVE_ALL = 10;

/** A thing that is lit up: as what it is drawn as, with the edges of its box. */
function lit(thing, geometry, colour, unsure) {
  const matrix = placed(thing.center, thing.half, thing.yaw);
  const group = new Group();
  if (geometry && isCloud(geometry)) {
    group.add(new Points(geometry, new PointsMaterial({ color: colour, size: 3, sizeAttenuation: false })));
  } else {
    const material = new MeshLambertMaterial({
      color: colour, emissive: colour, emissiveIntensity: 0.25, transparent: true,
      opacity: thing.surface ? 0.3 : unsure ? 0.6 : 0.82, side: DoubleSide,
      polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2,
    });
    const body = new Mesh(geometry ?? CUBE, material);
    if (!geometry) body.applyMatrix4(matrix);
    group.add(body);
  }
  group.add(unsure ? dashed(matrix, colour) : outline(matrix, colour));
  return group;
}

/** The points that something is measured between, and a line: as wide wherever one looks from. */
function segment([from, to], colour) {
  const group = new Group();
  const line = new LineSegments2(
    new LineSegmentsGeometry().setPositions([...from, ...to]), new LineMaterial({ color: colour, linewidth: 3, depthTest: false, transparent: true }),
  );
  const ends = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array([...from, ...to]), 3));
  const dots = new Points(ends, new PointsMaterial({
    color: colour, size: 11, sizeAttenuation: false, depthTest: false, map: disc(), transparent: true, alphaTest: 0.5,
  }));
  group.add(line, dots);
  for (const one of group.children) one.renderOrder = ABOVE_ALL + 1;
  return group;
}

let drawnDisc = null;

/** What makes a point round. */
function disc() {
  if (drawnDisc === null) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 32;
    const drawing = canvas.getContext("2d");
    drawing.fillStyle = "#fff";
    drawing.arc(16, 16, 15, 0, 2 * Math.PI);
    drawing.fill();
    drawnDisc = new CanvasTexture(canvas);
  }
  return drawnDisc;
}

/** The plane that decides on which side a thing is. */
function decisive([point, normal], thing, colour) {
  const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.3, depthWrite: false, side: DoubleSide });
  const wide = Math.min(0.6, Math.max(0.25, 1.2 * Math.max(...thing.half)));
  const plane = new Mesh(new PlaneGeometry(2 * wide, 2 * wide), material);
  plane.position.set(...point);
  plane.lookAt(plane.position.clone().add(new Vector3(...normal)));
  return plane;
}

function space({ volume, face }, colour) {
  const group = new Group();
  for (const [matrix, opacity] of [[volume, 0.14], [face, 0.45]]) {
    const material = new MeshBasicMaterial({ color: colour, transparent: true, opacity, depthWrite: false, side: DoubleSide });
    const body = new Mesh(CUBE, material);
    body.applyMatrix4(matrix);
    group.add(body);
  }
  const edges = new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.6 });
  group.add(new LineSegments(edgesOf([volume]), edges));
  return group;
}

function outline(matrix, colour) {
  const lines = new LineSegments(edgesOf([matrix]), new LineBasicMaterial({ color: colour, depthTest: false, transparent: true }));
  lines.renderOrder = ABOVE_ALL;
  return lines;
}

function dashed(matrix, colour) {
  const lines = new LineSegments(
    edgesOf([matrix]), new LineDashedMaterial({ color: colour, dashSize: 0.06, gapSize: 0.04, depthTest: false, transparent: true }),
  );
  lines.computeLineDistances();
  lines.renderOrder = ABOVE_ALL;
  return lines;
}

/** The group of what lights up. */
export function litUp(marks, model, colours, shapes) {
  const group = new Group();
  const { things, frames } = model;
  const light = (index, colour) => group.add(lit(things[index], shapes.of(things[index]), colour, marks.unsure));
  if (marks.reference !== null) light(marks.reference, colours.reference);
  if (marks.figure !== null) light(marks.figure, colours.figure);
  for (const one of marks.others) light(one, colours.other);
  for (const ends of marks.spans) group.add(segment(ends, colours.span));
  for (const { plane, thing } of marks.planes) group.add(decisive(plane, things[thing], colours.span));
  for (const { thing, axis, frame } of marks.spaces) {
    // Above and below are the same for all views.
    const boxes = spaceBoxes(things[thing], frames[axis[0] === "Z" ? 0 : frame]?.[thing] ?? null, axis);
    if (boxes) group.add(space(boxes, colours.space));
  }
  for (const { thing, frame } of marks.turned) {
    const row = frames[frame]?.[thing];
    if (row) group.add(dashed(placed(things[thing].center, row.slice(0, 3), row[3]), colours.turned));
  }
  return group;
}
