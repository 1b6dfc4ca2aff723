// Bounds of a scene, and the camera that shows them.
import * as THREE from "three";
import { setPose } from "./solids.js";

const MARGIN = 1.06, FROM = new THREE.Vector3(-0.38, -0.8, 0.46).normalize();

// Returns the bounds of all finite bodies and obstacles. poses: of the bodies.
export function boundsOf(about, poses) {
  const box = new THREE.Box3(), at = new THREE.Vector3(), corner = new THREE.Vector3(), inWorld = new THREE.Matrix4();
  const body = new THREE.Object3D(), inBody = new THREE.Object3D();
  for (const solid of about.solids) {
    if (solid.kind === "plane" || solid.role === "contact") continue;
    setPose(body, solid.body === null ? [0, 0, 0, 0, 0, 0, 1] : poses[solid.body]);
    setPose(inBody, solid.pose);
    body.updateMatrix();
    inBody.updateMatrix();
    inWorld.multiplyMatrices(body.matrix, inBody.matrix);
    if (solid.kind === "mesh") {
      const { vertices } = about.meshes[solid.mesh];
      for (let i = 0; i < vertices.length; i += 3) box.expandByPoint(corner.set(...vertices.slice(i, i + 3)).applyMatrix4(inWorld));
      continue;
    }
    const [a, b, c] = solid.size;
    if (solid.kind === "box") {
      for (let i = 0; i < 8; ++i) box.expandByPoint(corner.set(i & 1 ? a : -a, i & 2 ? b : -b, i & 4 ? c : -c).applyMatrix4(inWorld));
      continue;
    }
    for (const end of solid.kind === "sphere" ? [0] : [-b, b])  // balls about both ends
      for (const side of [-a, a]) box.expandByPoint(at.set(0, 0, end).applyMatrix4(inWorld).addScalar(side));
  }
  for (const surface of about.surfaces)
    for (const end of surface.bounds) box.expandByPoint(corner.set(...end));
  return box.isEmpty() ? box.expandByPoint(at.set(0, 0, 0)) : box;
}

// Moves the camera so that the box fills the picture.
export function fit(camera, controls, box, extent) {
  const centre = box.getCenter(new THREE.Vector3()), tanY = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2));
  camera.position.copy(centre).add(FROM);
  camera.lookAt(centre);
  camera.updateMatrixWorld();
  const axis = (i) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, i), [right, up, back] = [axis(0), axis(1), axis(2)];
  let distance = 0.1 * extent;
  for (let i = 0; i < 8; ++i) {
    const corner = new THREE.Vector3(box[i & 1 ? "max" : "min"].x, box[i & 2 ? "max" : "min"].y, box[i & 4 ? "max" : "min"].z).sub(centre);
    const out = Math.max(Math.abs(corner.dot(right)) / camera.aspect, Math.abs(corner.dot(up)));
    distance = Math.max(distance, corner.dot(back) + MARGIN * out / tanY);
  }
  camera.position.copy(centre).addScaledVector(back, distance);
  camera.near = extent / 200;
  camera.far = distance + extent * 50;
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
}
