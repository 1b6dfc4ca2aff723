// The scene in three dimensions: solid bodies at their simulated pose, wireframes at the pose of the device.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { fit, pointsOf } from "./camera.js";
import { ContactArrows, scaleBar } from "./forces.js";
import { Ghost } from "./ghost.js";
import { Marks, addGround, aimSun, axes } from "./marks.js";
import { geometryOf, setPose, triangles } from "./solids.js";
import { bodyPose } from "./wire.js";

export const COLOURS = {
  tool: 0xd5452c, body: 0x7e9fc7, obstacle: 0xa9a294, ghost: 0xe08a1e, unloaded: 0x2c9c5a, loaded: 0xd5261c,
  force: 0xb01fb0, contact: 0x1f7fd0, sphere: 0x333a44, lit: 0x404020, selected: 0x30304a,
};
const BAR_PIXELS = 48;  // height of the player's bar
const MANY = 150, HIDDEN_OPACITY = 0.45;
const THEMES = { light: { back: 0xf4f5f7, grid: 0xc4c9d2 }, dark: { back: 0x14181f, grid: 0x3a4350 } };

// Returns a context, without smooth edges on a software renderer, where they cost a large share of each
// frame.
function contextOf(canvas) {
  const probe = document.createElement("canvas").getContext("webgl2");
  const info = probe?.getExtension("WEBGL_debug_renderer_info");
  const inSoftware = Boolean(info) && /SwiftShader|llvmpipe|softpipe|Basic Render/.test(probe.getParameter(info.UNMASKED_RENDERER_WEBGL));
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return { inSoftware, context: canvas.getContext("webgl2", { antialias: !inSoftware, stencil: true }) };
}

export class View {
  constructor(canvas) {
    const { inSoftware, context } = contextOf(canvas);
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.renderer.shadowMap.enabled = !inSoftware;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.scene = new THREE.Scene();
    this.sky = new THREE.HemisphereLight(0xffffff, 0x8a8f99, 1.6);
    this.sun = new THREE.DirectionalLight(0xffffff, 1.8);
    this.sun.castShadow = true;
    this.scene.add(this.sky, this.sun, this.sun.target);
    this.show = { ghost: true, arrows: true, contacts: true, spheres: false, joints: false, frames: false, labels: false, shadows: !inSoftware, follow: false };
    this.forceFactor = 1;
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
    this.frame = null;
    this.about = about;
    this.grips = about.takes_hold;
    this.lit = this.selected = this.followed = null;
    this.geometries = new Map();
    this.bounds = new THREE.Box3().setFromPoints(pointsOf(about, about.bodies.map((body) => body.pose)));
    this.extent = Math.max(0.01, 0.5 * this.bounds.getSize(new THREE.Vector3()).length());
    this.driven = about.driven;
    this.bodies = about.bodies.map((body, i) => this.addBody(body, i));
    this.spheres = [];
    for (const solid of about.solids) this.addSolid(solid);
    this.ghosts = this.driven.map((body) => new Ghost(this, body));
    this.joints = about.joints.map((joint) => this.addJoint(joint));
    this.surfaces = about.surfaces.map((surface) => this.addSurface(surface));
    this.contactArrows = new ContactArrows(this.world, COLOURS.contact);
    this.marks = new Marks(about, this.bodies, this.joints, this.extent);
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
    const colour = !onBody ? COLOURS.obstacle : isTool && !this.grips ? COLOURS.tool : COLOURS.body;
    // behind by a little, so that edges and other faces in the same place leave no stripes
    const material = new THREE.MeshLambertMaterial({ color: colour, side: solid.kind === "mesh" ? THREE.DoubleSide : THREE.FrontSide,
      polygonOffset: true, polygonOffsetFactor: onBody ? 1 : 2, polygonOffsetUnits: onBody ? 1 : 2 });
    if (solid.kind === "plane") Object.assign(material, { transparent: true, opacity: 0.35, side: THREE.DoubleSide, depthWrite: false });
    const mesh = new THREE.Mesh(this.geometry(solid), material);
    setPose(mesh, solid.pose);
    mesh.userData.solid = solid;
    mesh.castShadow = mesh.receiveShadow = solid.kind !== "plane";
    if (isTool) this.addHidden(mesh);
    if (solid.kind === "box") mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(mesh.geometry), new THREE.LineBasicMaterial({ color: 0x223344, transparent: true, opacity: 0.5 })));
    (onBody ? this.bodies[solid.body] : this.world).add(mesh);
  }

  // Draws the hidden part of a tool's solid through the obstacles before it. The stencil keeps it off the
  // tool's own pixels.
  addHidden(mesh) {
    const stencil = { stencilWrite: true, stencilRef: 1, stencilZPass: THREE.ReplaceStencilOp };
    mesh.material.setValues(stencil);
    const hidden = new THREE.Mesh(mesh.geometry, new THREE.MeshBasicMaterial({ color: COLOURS.tool, transparent: true, opacity: HIDDEN_OPACITY,
      depthFunc: THREE.GreaterDepth, depthWrite: false, ...stencil, stencilFunc: THREE.NotEqualStencilFunc }));
    hidden.renderOrder = 1;
    hidden.raycast = () => {};
    mesh.userData.hidden = hidden;
    mesh.add(hidden);
  }

  // Shares the geometry of equal solids, because an organ has some hundred spheres.
  geometry(solid) {
    const key = JSON.stringify([solid.kind, solid.size, solid.mesh]);
    if (!this.geometries.has(key)) this.geometries.set(key, geometryOf(solid, this.about.meshes, this.extent, this.about.solids.length > MANY));
    return this.geometries.get(key);
  }

  addJoint(joint) {
    const frame = axes(0.12 * this.extent);
    setPose(frame, joint.pose);
    frame.visible = this.show.joints;
    frame.add(new THREE.Mesh(new THREE.OctahedronGeometry(0.015 * this.extent), new THREE.MeshBasicMaterial({ color: COLOURS.sphere, depthTest: false, transparent: true })));
    (joint.parent === null ? this.world : this.bodies[joint.parent]).add(frame);
    return frame;
  }

  // Adds a net; its nodes come with each frame.
  addSurface(surface) {
    const mesh = new THREE.Mesh(triangles(new Float32Array(3 * surface.num_vertices), surface.triangles),
      new THREE.MeshLambertMaterial({ color: COLOURS.body, side: THREE.DoubleSide }));
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = true;
    this.world.add(mesh);
    return mesh;
  }

  addGrid() {
    const size = 4 * this.extent;
    this.grid = new THREE.GridHelper(size, 40).rotateX(Math.PI / 2);
    this.grid.material = new THREE.LineBasicMaterial({ color: THEMES[this.theme].grid, transparent: true, opacity: 0.5, depthWrite: false });
    const isFlat = (solid) => solid.kind === "plane" && Math.hypot(solid.pose[3], solid.pose[4]) < 1e-6;
    this.grid.position.z = this.about.solids.find(isFlat)?.pose[2] ?? this.bounds.min.z - 0.002 * this.extent;
    this.world.add(this.grid);
    const centre = this.bounds.getCenter(new THREE.Vector3());
    this.ground = addGround(this.world, this.extent, centre, this.grid.position.z);
    aimSun(this.sun, centre, this.extent);
  }

  setShown(name, on) {
    this.show[name] = on;
    if (!this.about) return;
    if (name === "spheres") this.showSpheres(on);
    if (name === "joints") for (const joint of this.joints) joint.visible = on;
    if (name === "labels" || name === "frames") this.marks.show(name, on);
    if (name === "shadows") this.showShadows(on);
  }

  showShadows(on) {
    this.ground.visible = on;
    if (this.renderer.shadowMap.enabled === on) return;
    this.renderer.shadowMap.enabled = on;
    this.scene.traverse((object) => { if (object.material) object.material.needsUpdate = true; });
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

  // Shows all bodies of these frames with the next picture, because the shape of the canvas is known then.
  // Without frames they are where they are now.
  lookAtAll(frames = this.frame ? [this.frame] : []) {
    const poses = frames.map((frame) => this.bodies.map((_, i) => bodyPose(frame, i)));
    if (!poses.length) poses.push(this.about.bodies.map((body) => body.pose));
    this.unfitted = poses.flatMap((one) => pointsOf(this.about, one));
    this.followed = null;
  }

  update(frame) {
    this.frame = frame;
    this.bodies.forEach((body, i) => setPose(body, bodyPose(frame, i)));
    this.ghosts.forEach((ghost, i) => ghost.update(frame, i));
    this.contactArrows.update(frame, this.show.contacts, this.forceScale(), this.extent);
    let first = 0;
    for (const surface of this.surfaces) {
      const position = surface.geometry.attributes.position;
      position.array.set(frame.vertices.subarray(first, first += position.array.length));
      position.needsUpdate = true;
      surface.geometry.computeVertexNormals();
    }
    this.follow();
  }

  // Highlights a driven body. target: its index; null for none.
  highlight(target) {
    if (target === this.lit) return;
    this.lit = target;
    this.light();
  }
  // Highlights the selected body. index: of all bodies; null for none.
  select(index) {
    this.selected = index;
    this.light();
  }
  light() {
    for (const { children, userData } of this.bodies ?? []) {
      const colour = this.lit !== null && userData.target === this.lit ? COLOURS.lit : this.selected === userData.body ? COLOURS.selected : 0;
      for (const mesh of children) if (mesh.isMesh) mesh.material.emissive?.setHex(colour);
    }
  }

  paintHeld(body, isHeld) {
    for (const mesh of this.bodies[body].children)
      if (mesh.isMesh && mesh.material.color && mesh.userData.solid?.role !== "contact") {
        mesh.material.color.setHex(isHeld ? COLOURS.tool : COLOURS.body);
        if (mesh.userData.hidden) mesh.userData.hidden.visible = isHeld;
      }
  }

  // Returns the length of arrows, m per N.
  forceScale() { return this.forceFactor * 0.4 * this.extent / this.about.max_force; }
  // Returns { newtons, pixels } of the legend's arrow.
  forceLegend() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return scaleBar(this.forceScale(), this.height / (2 * distance * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2))));
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
    if (this.unfitted) {
      fit(this.camera, this.controls, this.unfitted, this.bounds.getCenter(new THREE.Vector3()), this.extent, BAR_PIXELS / Math.max(height, 4 * BAR_PIXELS));
      this.unfitted = null;
    }
    this.controls.update();
    this.marks?.update(this.height, this.camera.fov, (point) => this.project(point));
    this.renderer.render(this.scene, this.camera);
  }

  // Returns the position of a world point on the canvas, CSS pixels.
  project(point) {
    const seen = new THREE.Vector3(...point).project(this.camera);
    return { x: (seen.x + 1) / 2 * this.width, y: (1 - seen.y) / 2 * this.height };
  }
}
