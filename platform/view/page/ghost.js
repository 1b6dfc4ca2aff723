// The device of a driven body: the tool in wireframe at the target, the coupling to it, and the displayed
// force.
import * as THREE from "three";
import { arrowGeometry, setPose, span } from "./solids.js";
import { couplingForce, feedbackForce, targetPose } from "./wire.js";

const APART = 0.02, APART_RAD = 0.1;  // of the extent, rad: from here on the device is drawn fully
const COLOURS = { ghost: 0xe08a1e, unloaded: 0x2c9c5a, loaded: 0xd5261c, force: 0xb01fb0 };

// Returns a geometry with few edges, so that the wires of a thin tool do not fill it.
function lowDetail({ kind, size: [a, b] }) {
  if (kind === "sphere") return new THREE.SphereGeometry(a, 12, 8);
  if (kind === "capsule") return new THREE.CapsuleGeometry(a, 2 * b, 2, 6).rotateX(Math.PI / 2);
  return kind === "cylinder" ? new THREE.CylinderGeometry(a, a, 2 * b, 6).rotateX(Math.PI / 2) : null;
}

function wiresOf(mesh, material) {
  const low = lowDetail(mesh.userData.solid), isSmooth = mesh.userData.solid.kind === "mesh";
  // the angle is the largest between faces without a drawn edge, degrees
  const wires = new THREE.LineSegments(new THREE.EdgesGeometry(low ?? mesh.geometry, isSmooth ? 14 : 1), material);
  wires.position.copy(mesh.position);
  wires.quaternion.copy(mesh.quaternion);
  wires.renderOrder = 3;
  return wires;
}

export class Ghost {
  // body: index among all bodies
  constructor(view, body) {
    Object.assign(this, { view, body, group: new THREE.Group() });
    this.material = new THREE.LineBasicMaterial({ color: COLOURS.ghost, transparent: true, depthTest: false });
    for (const mesh of view.bodies[body].children) if (mesh.isMesh) this.group.add(wiresOf(mesh, this.material));
    const above = (geometry, color, renderOrder) =>
      Object.assign(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true })), { renderOrder });
    this.line = above(new THREE.CylinderGeometry(1, 1, 1, 8).rotateX(Math.PI / 2).translate(0, 0, 0.5), COLOURS.unloaded, 4);
    this.force = above(arrowGeometry(), COLOURS.force, 5);
    this.force.visible = false;
    view.world.add(this.group, this.line, this.force);
  }

  // i: index among the driven bodies
  update(frame, i) {
    const { about, show, extent } = this.view, isHeld = !this.view.grips || frame.held === this.body;
    this.group.visible = this.line.visible = this.force.visible = false;
    if (this.view.grips) this.view.paintHeld(this.body, frame.held === this.body);
    if (!isHeld) return;
    setPose(this.group, targetPose(frame, i));
    const tool = this.view.bodies[this.body], target = this.group.position;
    const load = Math.min(1, Math.hypot(...couplingForce(frame, i)) / about.max_force);
    const apart = tool.position.distanceTo(target) / (APART * extent) + tool.quaternion.angleTo(this.group.quaternion) / APART_RAD;
    this.material.opacity = Math.min(1, apart);  // not drawn over a tool in the same place
    this.group.visible = show.ghost && apart > 0.02;
    if (show.ghost) span(this.line, tool.position, target, 0.006 * extent * (1 + load));
    this.line.material.color.set(COLOURS.unloaded).lerp(new THREE.Color(COLOURS.loaded), load);
    if (show.arrows) this.point(target, this.view.grips ? frame.handForce : feedbackForce(frame, i));
  }

  point(from, force) {
    const { extent } = this.view, vector = new THREE.Vector3(...force).multiplyScalar(this.view.forceScale());
    if (vector.length() < 0.004 * extent) return;
    span(this.force, from, from.clone().add(vector), Math.max(vector.length(), 0.12 * extent));
  }
}
