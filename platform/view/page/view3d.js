// The scene in three dimensions: solid bodies at their simulated pose, wireframes at the pose of the device.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { arrowGeometry, geometryOf, setPose, span, triangles } from "./solids.js";
import { bodyPose, couplingForce, feedbackForce, targetPose } from "./wire.js";

export const COLOURS = {
  tool: 0xd5452c, body: 0x7e9fc7, obstacle: 0xa9a294, ghost: 0xe08a1e, unloaded: 0x2c9c5a, loaded: 0xd5261c,
  force: 0xb01fb0, contact: 0x1f7fd0, sphere: 0x333a44, lit: 0x404020,
};
const MAX_ARROWS = 4096, MANY = 150;
const THEMES = { light: { back: 0xf4f5f7, grid: 0xc4c9d2 }, dark: { back: 0x14181f, grid: 0x3a4350 } };

// Returns a context, without smooth edges on a software renderer, where they cost a large share of each
// frame.
function contextOf(canvas) {
  const probe = document.createElement("canvas").getContext("webgl2");
  const info = probe?.getExtension("WEBGL_debug_renderer_info");
  const inSoftware = Boolean(info) && /SwiftShader|llvmpipe|softpipe|Basic Render/.test(probe.getParameter(info.UNMASKED_RENDERER_WEBGL));
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return canvas.getContext("webgl2", { antialias: !inSoftware });
}

export class View {
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({ canvas, context: contextOf(canvas) });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.scene = new THREE.Scene();
    this.sky = new THREE.HemisphereLight(0xffffff, 0x8a8f99, 1.6);
    this.sun = new THREE.DirectionalLight(0xffffff, 1.8);
    this.scene.add(this.sky, this.sun);
    this.show = { ghost: true, arrows: true, contacts: true, spheres: false, joints: false, follow: false };
    this.theme = "light";
    this.world = new THREE.Group();
    this.scene.add(this.world);
  }

  setTheme(theme) {
    this.theme = theme;
    this.scene.background = new THREE.Color(THEMES[theme].back);
    if (this.grid) this.grid.material.color.setHex(THEMES[theme].grid);
  }

  setScene(about) {
    this.world.traverse((object) => { object.geometry?.dispose(); });
    this.world.clear();
    this.about = about;
    this.lit = null;
    this.geometries = new Map();
    this.bounds = boundsOf(about);
    this.extent = Math.max(0.01, 0.5 * this.bounds.getSize(new THREE.Vector3()).length());
    this.driven = about.driven;
    this.bodies = about.bodies.map((body, i) => this.addBody(body, i));
    this.spheres = [];
    for (const solid of about.solids) this.addSolid(solid);
    this.ghosts = this.driven.map((body) => this.addGhost(body));
    this.joints = about.joints.map((joint) => this.addJoint(joint));
    this.surfaces = about.surfaces.map((surface) => this.addSurface(surface));
    this.addArrows();
    this.addGrid();
    this.setTheme(this.theme);
    this.lookAtAll();
  }

  addBody(body, index) {
    const group = new THREE.Group();
    setPose(group, body.pose);
    group.userData = { body: index, target: this.driven.indexOf(index) };
    this.world.add(group);
    return group;
  }

  addSolid(solid) {
    const onBody = solid.body !== null, isTool = onBody && this.driven.includes(solid.body);
    if (solid.role === "contact") return this.spheres.push(solid);  // drawn on demand
    const colour = !onBody ? COLOURS.obstacle : isTool && !this.about.takes_hold ? COLOURS.tool : COLOURS.body;
    const material = new THREE.MeshLambertMaterial({ color: colour, side: solid.kind === "mesh" ? THREE.DoubleSide : THREE.FrontSide });
    if (solid.kind === "plane") Object.assign(material, { transparent: true, opacity: 0.35, side: THREE.DoubleSide, depthWrite: false });
    const mesh = new THREE.Mesh(this.geometry(solid), material);
    setPose(mesh, solid.pose);
    mesh.userData.solid = solid;
    if (solid.kind === "box") mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry), new THREE.LineBasicMaterial({ color: 0x223344, transparent: true, opacity: 0.5 })));
    (onBody ? this.bodies[solid.body] : this.world).add(mesh);
  }

  // Shares the geometry of equal solids, because an organ has some hundred spheres.
  geometry(solid) {
    const key = JSON.stringify([solid.kind, solid.size, solid.mesh]);
    if (!this.geometries.has(key)) this.geometries.set(key, geometryOf(solid, this.about.meshes, this.extent, this.about.solids.length > MANY));
    return this.geometries.get(key);
  }

  // Adds the device: the tool in wireframe at the target, the coupling to it, and the displayed force.
  addGhost(body) {
    const group = new THREE.Group();
    const material = new THREE.LineBasicMaterial({ color: COLOURS.ghost, transparent: true, depthTest: false });
    for (const mesh of this.bodies[body].children) {
      if (!mesh.isMesh) continue;
      // largest angle between faces without a drawn edge, degrees
      const angle = mesh.userData.solid.kind === "box" ? 1 : 14;
      const wires = new THREE.LineSegments(mesh.geometry.attributes.position.count > 400 && angle > 1
        ? new THREE.WireframeGeometry(lowDetail(mesh)) : new THREE.EdgesGeometry(mesh.geometry, angle), material);
      wires.position.copy(mesh.position);
      wires.quaternion.copy(mesh.quaternion);
      wires.renderOrder = 3;
      group.add(wires);
    }
    const line = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5),
      new THREE.MeshBasicMaterial({ color: COLOURS.unloaded, depthTest: false, transparent: true }));
    line.renderOrder = 4;
    const force = this.arrow(COLOURS.force);
    this.world.add(group, line, force);
    return { body, group, material, line, force };
  }

  arrow(colour) {
    this.arrowShape ??= arrowGeometry();
    const arrow = new THREE.Mesh(this.arrowShape.clone(), new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true }));
    arrow.renderOrder = 5;
    arrow.visible = false;
    return arrow;
  }

  addArrows() {
    const many = (geometry, colour) => {
      const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true }), MAX_ARROWS);
      mesh.count = 0;
      mesh.frustumCulled = false;
      mesh.renderOrder = 2;
      this.world.add(mesh);
      return mesh;
    };
    this.contactArrows = many(arrowGeometry(), COLOURS.contact);
    this.contactPoints = many(new THREE.OctahedronGeometry(1, 1), COLOURS.contact);
  }

  addJoint(joint) {
    const axes = new THREE.AxesHelper(0.12 * this.extent);
    setPose(axes, joint.pose);
    axes.visible = this.show.joints;
    axes.material.depthTest = false;
    (joint.parent === null ? this.world : this.bodies[joint.parent]).add(axes);
    return axes;
  }

  // Adds a net; its nodes come with each frame.
  addSurface(surface) {
    const mesh = new THREE.Mesh(triangles(new Float32Array(3 * surface.num_vertices), surface.triangles),
      new THREE.MeshLambertMaterial({ color: COLOURS.body, side: THREE.DoubleSide }));
    mesh.frustumCulled = false;
    this.world.add(mesh);
    return mesh;
  }

  addGrid() {
    const size = 4 * this.extent;
    this.grid = new THREE.GridHelper(size, 40).rotateX(Math.PI / 2);
    this.grid.material = new THREE.LineBasicMaterial({ color: THEMES[this.theme].grid, transparent: true, opacity: 0.5 });
    const plane = this.about.solids.find((solid) => solid.kind === "plane");
    this.grid.position.z = plane ? plane.pose[2] : -0.6 * this.extent;
    this.world.add(this.grid);
  }

  setShown(name, on) {
    this.show[name] = on;
    if (!this.about) return;
    if (name === "spheres") this.showSpheres(on);
    if (name === "joints") for (const joint of this.joints) joint.visible = on;
  }

  showSpheres(on) {
    for (const mesh of this.sphereMeshes ?? []) mesh.removeFromParent();
    const material = new THREE.MeshLambertMaterial({ color: COLOURS.sphere });
    this.sphereMeshes = !on ? [] : this.spheres.map((solid) => {
      const mesh = new THREE.Mesh(this.geometry(solid), material);
      setPose(mesh, solid.pose);
      this.bodies[solid.body].add(mesh);
      return mesh;
    });
  }

  lookAtAll() {
    const centre = this.bounds.getCenter(new THREE.Vector3());
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).add(new THREE.Vector3(-0.38, -0.8, 0.46).multiplyScalar(2.6 * this.extent));
    this.camera.near = this.extent / 200;
    this.camera.far = this.extent * 50;
    this.camera.updateProjectionMatrix();
    this.followed = null;
  }

  update(frame) {
    this.frame = frame;
    this.bodies.forEach((body, i) => setPose(body, bodyPose(frame, i)));
    this.ghosts.forEach((ghost, i) => this.updateGhost(ghost, frame, i));
    this.updateContacts(frame);
    let first = 0;
    for (const surface of this.surfaces) {
      const position = surface.geometry.attributes.position;
      position.array.set(frame.vertices.subarray(first, first += position.array.length));
      position.needsUpdate = true;
      surface.geometry.computeVertexNormals();
    }
    this.follow();
  }

  updateGhost(ghost, frame, i) {
    const isHeld = !this.about.takes_hold || frame.held === ghost.body;
    ghost.group.visible = this.show.ghost && isHeld;
    ghost.line.visible = ghost.force.visible = false;
    if (this.about.takes_hold) this.paintHeld(ghost.body, frame.held === ghost.body);
    if (!isHeld) return;
    setPose(ghost.group, targetPose(frame, i));
    const load = Math.min(1, Math.hypot(...couplingForce(frame, i)) / this.about.max_force);
    const tool = this.bodies[ghost.body].position, target = ghost.group.position;
    const apart = tool.distanceTo(target) / (0.02 * this.extent);
    ghost.material.opacity = Math.min(1, 0.35 + 0.65 * apart);
    if (this.show.ghost) span(ghost.line, tool, target, 0.006 * this.extent * (1 + load));
    ghost.line.material.color.set(COLOURS.unloaded).lerp(new THREE.Color(COLOURS.loaded), load);
    const force = this.about.takes_hold ? frame.handForce : feedbackForce(frame, i);
    if (this.show.arrows) this.pointArrow(ghost.force, target, force);
  }

  // Highlights a driven body. target: its index; null for none.
  highlight(target) {
    if (target === this.lit) return;
    this.lit = target;
    for (const body of this.bodies ?? [])
      for (const mesh of body.children)
        if (mesh.isMesh) mesh.material.emissive?.setHex(target !== null && body.userData.target === target ? COLOURS.lit : 0);
  }

  paintHeld(body, isHeld) {
    for (const mesh of this.bodies[body].children)
      if (mesh.isMesh && mesh.material.color && mesh.userData.solid?.role !== "contact") mesh.material.color.setHex(isHeld ? COLOURS.tool : COLOURS.body);
  }

  forceScale() { return 0.4 * this.extent / this.about.max_force; }

  pointArrow(arrow, from, force) {
    const vector = new THREE.Vector3(...force).multiplyScalar(this.forceScale());
    if (vector.length() < 0.004 * this.extent) return;
    span(arrow, from, from.clone().add(vector), Math.max(vector.length(), 0.12 * this.extent));
  }

  updateContacts(frame) {
    const at = new THREE.Vector3(), force = new THREE.Vector3(), scale = new THREE.Vector3(), turn = new THREE.Quaternion(), matrix = new THREE.Matrix4();
    const z = new THREE.Vector3(0, 0, 1), n = this.show.contacts ? Math.min(frame.numContacts, MAX_ARROWS) : 0;
    for (let i = 0; i < n; ++i) {
      const c = frame.contacts.subarray(11 * i, 11 * i + 11);
      at.set(c[2], c[3], c[4]);
      force.set(c[8], c[9], c[10]);
      const length = Math.min(force.length() * this.forceScale(), 0.5 * this.extent);
      turn.setFromUnitVectors(z, force.normalize());
      const width = Math.max(length, 0.06 * this.extent);
      this.contactArrows.setMatrixAt(i, matrix.compose(at, turn, scale.set(width, width, Math.max(length, 1e-6))));
      this.contactPoints.setMatrixAt(i, matrix.compose(at, turn, scale.setScalar(0.006 * this.extent)));
    }
    for (const mesh of [this.contactArrows, this.contactPoints]) {
      mesh.count = n;
      mesh.instanceMatrix.clearUpdateRanges();
      mesh.instanceMatrix.addUpdateRange(0, 16 * n);
      mesh.instanceMatrix.needsUpdate = n > 0;
    }
  }

  // Moves the camera with the tool.
  follow() {
    const held = this.frame.held >= 0 ? this.frame.held : this.driven[0];
    if (!this.show.follow || held === undefined) return void (this.followed = null);
    const now = this.bodies[held].position;
    if (this.followed) {
      const shift = now.clone().sub(this.followed);
      this.camera.position.add(shift);
      this.controls.target.add(shift);
    }
    this.followed = now.clone();
  }

  render() {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement.parentElement;
    if (width !== this.width || height !== this.height) {
      [this.width, this.height] = [width, height];
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(1, height);
      this.camera.updateProjectionMatrix();
    }
    this.controls.update();
    this.sun.position.copy(this.camera.position).add(new THREE.Vector3(0.3, 0.2, 1).multiplyScalar(this.extent ?? 1));
    this.renderer.render(this.scene, this.camera);
  }

  // Returns the position of a world point on the canvas, CSS pixels.
  project(point) {
    const seen = new THREE.Vector3(...point).project(this.camera);
    return { x: (seen.x + 1) / 2 * this.width, y: (1 - seen.y) / 2 * this.height };
  }
}

const lowDetail = (mesh) => {
  const { kind, size } = mesh.userData.solid;
  if (kind === "sphere") return new THREE.SphereGeometry(size[0], 12, 8);
  if (kind === "capsule") return new THREE.CapsuleGeometry(size[0], 2 * size[1], 3, 10).rotateX(Math.PI / 2);
  return mesh.geometry;
};

// Returns the bounds of all finite bodies and obstacles at the start of the scene.
function boundsOf(about) {
  const box = new THREE.Box3(), at = new THREE.Vector3(), turn = new THREE.Quaternion(), object = new THREE.Object3D(), inBody = new THREE.Object3D();
  for (const solid of about.solids) {
    if (solid.kind === "plane" || solid.role === "contact") continue;
    setPose(object, solid.body === null ? [0, 0, 0, 0, 0, 0, 1] : about.bodies[solid.body].pose);
    setPose(inBody, solid.pose);
    at.copy(inBody.position).applyQuaternion(turn.copy(object.quaternion)).add(object.position);
    const [a, b, c] = solid.size, reach = solid.kind === "box" ? Math.hypot(a, b, c) : a, isLong = /c(apsule|ylinder)/.test(solid.kind);
    const axis = new THREE.Vector3(0, 0, isLong ? b : 0).applyQuaternion(inBody.quaternion).applyQuaternion(object.quaternion);
    for (const side of [-1, 1])
      for (const end of [-1, 1]) box.expandByPoint(at.clone().addScaledVector(axis, end).addScalar(side * reach / Math.sqrt(3)));
    if (solid.kind !== "mesh") continue;
    const { vertices } = about.meshes[solid.mesh];
    for (let i = 0; i < vertices.length; i += 3) box.expandByPoint(new THREE.Vector3(...vertices.slice(i, i + 3)).applyQuaternion(inBody.quaternion).add(inBody.position));
  }
  for (const surface of about.surfaces)
    for (const corner of surface.bounds) box.expandByPoint(new THREE.Vector3(...corner));
  return box.isEmpty() ? box.expandByPoint(at) : box;
}
