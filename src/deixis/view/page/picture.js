// The scene in three dimensions: things, surfaces, views, and what lights up. Drawn only when something changed.
import {
  AmbientLight, Color, DirectionalLight, DoubleSide, FrontSide, Group, InstancedMesh, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, Sphere, Vector2,
  Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Labels } from "./labels.js";
import { litUp } from "./lights.js";
import { CUBE, Shapes, edgesOf, freed, isCloud, placed } from "./shapes.js";
import { viewMarker } from "./viewer.js";

const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((at) => new Vector3((at & 1) - 0.5, ((at >> 1) & 1) - 0.5, (at >> 2) - 0.5));
const CLICK = 5; // pixels a pointer may move between down and up

export class Picture {
  constructor(host, model, pick) {
    this.host = host;
    this.model = model;
    this.pick = pick;
    this.renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "The scene in 3D. Arrow keys turn it, plus and minus come nearer or go away.");
    host.prepend(this.canvas);
    this.world = new Scene();
    this.camera = new PerspectiveCamera(45, 1, 0.01, 1000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.labels = new Labels(host, model);
    this.fixed = new Group();
    this.shapes = new Shapes();
    this.marks = null;
    this.world.add(this.fixed);
    this.lit = [];
    this.waiting = false;
    this.drawn = 0;
    this.listen();
    new ResizeObserver(() => this.fit()).observe(host);
  }

  listen() {
    let down = null;
    this.canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    this.canvas.addEventListener("pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < CLICK) this.pick(this.under(event));
      down = null;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) return;
      const found = this.under(event);
      this.canvas.classList.toggle("over", found !== null);
      if (this.labels.hover(found)) this.draw();
    });
    const turns = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    this.canvas.addEventListener("keydown", (event) => {
      if (turns[event.key]) this.turn(...turns[event.key], 1);
      else if (event.key === "+" || event.key === "=") this.turn(0, 0, 0.85);
      else if (event.key === "-") this.turn(0, 0, 1.18);
      else return;
      event.preventDefault();
    });
  }

  /** Take over another model; what is seen of it is built next, and looked at from where one looks now. */
  take(model) {
    this.model = model;
    this.labels.take(model);
  }

  /** Build what is there whatever is selected; the shapes of things may be known later. */
  build(colours, told) {
    freed(this.fixed);
    if (this.shapes.told !== told) {
      this.shapes.free();
      this.shapes = new Shapes(told);
    }
    this.fixed.clear();
    this.world.background = new Color(colours.back);
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(0.6, -0.8, 1.5);
    this.fixed.add(sun, new AmbientLight(0xffffff, 1.7));
    const { things } = this.model;
    // A mesh may be open; of a box only the outside is seen, and drawing the inside too would take twice as long.
    this.solids = [FrontSide, DoubleSide].map((side) => new MeshLambertMaterial({ color: colours.thing, transparent: true, side }));
    this.flat = new MeshLambertMaterial({
      color: colours.surface, side: DoubleSide, transparent: true, opacity: 0.55, depthWrite: false,
    });
    this.targets = [this.filled(things.filter((one) => !one.surface && !this.shapes.of(one)), this.solids[0])];
    for (const thing of things) if (thing.surface || this.shapes.of(thing)) this.shaped(thing, colours);
    const matrices = things.map((one) => placed(one.center, one.half, one.yaw));
    const lines = new LineBasicMaterial({ color: colours.line, transparent: true, opacity: 0.75 });
    this.fixed.add(new LineSegments(edgesOf(matrices), lines));
    this.colours = colours;
    this.draw();
  }

  /** Add a surface, a mesh or points; what is clicked of the latter two is the box. */
  shaped(thing, colours) {
    const geometry = this.shapes.of(thing);
    let target = this.boxed(thing, thing.surface ? this.flat : new MeshBasicMaterial({ transparent: true, opacity: 0, depthWrite: false }));
    if (geometry && isCloud(geometry)) {
      this.fixed.add(new Points(geometry, new PointsMaterial({ color: colours.line, size: 2, sizeAttenuation: false })));
    } else if (geometry) {
      const body = new Mesh(geometry, thing.surface ? this.flat : this.solids[1]);
      if (thing.surface) target = body;
      else this.fixed.add(body);
    }
    target.userData.thing = thing.index;
    this.fixed.add(target);
    this.targets.push(target);
  }

  filled(things, material) {
    const mesh = new InstancedMesh(CUBE, material, things.length);
    things.forEach((one, at) => mesh.setMatrixAt(at, placed(one.center, one.half, one.yaw)));
    mesh.userData.things = things.map((one) => one.index);
    this.fixed.add(mesh);
    return mesh;
  }

  boxed(thing, material) {
    const mesh = new Mesh(CUBE, material);
    mesh.applyMatrix4(placed(thing.center, thing.half, thing.yaw));
    return mesh;
  }

  /** Show from where the current view looks. */
  stand(view) {
    this.view = view;
    if (this.markers) {
      freed(this.markers);
      this.world.remove(this.markers);
    }
    this.markers = new Group();
    const size = Math.min(0.25, 0.06 * this.around().radius);
    for (const one of this.model.views) this.markers.add(viewMarker(one, one.index === view, size, this.colours.view));
    this.world.add(this.markers);
    this.labels.stand(view);
    this.draw();
  }

  /** Light up what a step or a thing is about. */
  light(marks) {
    if (this.marks) {
      freed(this.marks);
      this.world.remove(this.marks);
    }
    this.marks = litUp(marks, this.model, this.colours, this.shapes);
    this.world.add(this.marks);
    this.lit = [marks.figure, marks.reference, ...marks.others].filter((one) => one !== null);
    for (const solid of this.solids) {
      solid.opacity = marks.figure === null ? 1 : 0.32;
      solid.depthWrite = marks.figure === null;
    }
    this.labels.light(marks);
    this.draw();
  }

  /** The corners of things, or of all. */
  corners(things = this.model.things) {
    return things.flatMap(({ center, half, yaw }) => {
      const matrix = placed(center, half, yaw);
      return CORNERS.map((one) => one.clone().applyMatrix4(matrix));
    });
  }

  around(corners = this.corners()) {
    return corners.length === 0 ? new Sphere(new Vector3(), 1) : new Sphere().setFromPoints(corners);
  }

  /** Look at everything, from behind the current view and above it. */
  overview() {
    const { center } = this.around();
    const view = this.model.views[this.view ?? 0];
    const way = view ? new Vector3(...view.position).sub(center).setZ(0) : new Vector3(-1, -1, 0);
    if (way.length() < 1e-3) way.set(-1, -1, 0);
    way.normalize().applyAxisAngle(this.camera.up, 0.35).setZ(0.62).normalize();
    this.show(this.corners(), way);
  }

  /** Come as near to what is lit up as it fits, looking the same way as now. */
  closer() {
    const things = this.lit.map((one) => this.model.things[one]);
    const way = this.camera.position.clone().sub(this.controls.target).normalize();
    if (things.length) this.show(this.corners(things), way);
  }

  /** Go back from points, some way, until all of them are in sight. */
  show(corners, way) {
    const { center, radius } = this.around(corners);
    this.controls.target.copy(center);
    const seen = new Vector3();
    for (let far = 0.6 * radius + 0.2; far < 60 * radius + 1; far *= 1.06) {
      this.camera.position.copy(center).addScaledVector(way, far);
      this.camera.lookAt(center);
      this.camera.updateMatrixWorld();
      if (corners.every((one) => Math.max(Math.abs(seen.copy(one).project(this.camera).x), Math.abs(seen.y)) < 0.86 && seen.z < 1)) break;
    }
    this.controls.update();
    this.draw();
  }

  /** Look as the current view does. */
  lookFrom() {
    const view = this.model.views[this.view];
    const ahead = new Vector3(Math.cos(view.heading), Math.sin(view.heading), -0.12);
    this.camera.position.set(...view.position);
    this.controls.target.copy(this.camera.position).addScaledVector(ahead, 1.5);
    this.controls.update();
    this.draw();
  }

  turn(around, over, away) {
    const arm = this.camera.position.clone().sub(this.controls.target).multiplyScalar(away);
    arm.applyAxisAngle(this.camera.up, around);
    const side = new Vector3().crossVectors(this.camera.up, arm).normalize();
    const tilted = arm.clone().applyAxisAngle(side, over);
    const steep = tilted.angleTo(this.camera.up);
    this.camera.position.copy(this.controls.target).add(steep > 0.1 && steep < 3 ? tilted : arm);
    this.controls.update();
    this.draw();
  }

  under(event) {
    const area = this.canvas.getBoundingClientRect();
    const at = new Vector2(
      (2 * (event.clientX - area.left)) / area.width - 1, 1 - (2 * (event.clientY - area.top)) / area.height,
    );
    const ray = new Raycaster();
    ray.setFromCamera(at, this.camera);
    const hits = ray.intersectObjects(this.targets, false).map(
      ({ object, instanceId }) => object.userData.things?.[instanceId] ?? object.userData.thing,
    );
    // A wall stands before what it is behind of as well: a thing wins over a surface.
    return hits.find((one) => !this.model.things[one].surface) ?? hits[0] ?? null;
  }

  fit() {
    const { clientWidth: wide, clientHeight: tall } = this.host;
    if (!wide || !tall) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(wide, tall);
    this.camera.aspect = wide / tall;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.renderer.render(this.world, this.camera);
      this.labels.place(this.camera, this.host.clientWidth, this.host.clientHeight);
      this.drawn += 1;
    });
  }
}
