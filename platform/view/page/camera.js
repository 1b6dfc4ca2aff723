// Bounds of a scene, and the camera that shows them.
import * as THREE from "three";
import { setPose } from "./solids.js";

const MARGIN = 1.05, FROM = new THREE.Vector3(-0.38, -0.8, 0.46).normalize();

// Returns points around all finite bodies and obstacles. poses: of the bodies.
export function pointsOf(about, poses) {
  const points = [], inWorld = new THREE.Matrix4(), body = new THREE.Object3D(), inBody = new THREE.Object3D();
  const put = (x, y, z) => points.push(new THREE.Vector3(x, y, z).applyMatrix4(inWorld));
  for (const solid of about.solids) {
    if (solid.kind === "plane" || solid.role === "contact") continue;
    setPose(body, solid.body === null ? [0, 0, 0, 0, 0, 0, 1] : poses[solid.body]);
    setPose(inBody, solid.pose);
    body.updateMatrix();
    inBody.updateMatrix();
    inWorld.multiplyMatrices(body.matrix, inBody.matrix);
    if (solid.kind === "mesh") {
      const { vertices } = about.meshes[solid.mesh];
      for (let i = 0; i < vertices.length; i += 3) put(...vertices.slice(i, i + 3));
      continue;
    }
    const [a, b, c] = solid.size, half = { box: [a, b, c], sphere: [a, a, a], capsule: [a, a, a + b] }[solid.kind] ?? [a, a, b];
    for (let i = 0; i < 8; ++i) put(...half.map((x, k) => i >> k & 1 ? x : -x));
  }
  inWorld.identity();
  for (const surface of about.surfaces) for (const end of surface.bounds) put(...end);
  if (!points.length) put(0, 0, 0);
  return points;
}

// Moves the camera so that the points fill the picture. centre: of their bounds. covered: share of the
// height that is covered at the lower end.
export function fit(camera, controls, points, centre, extent, covered) {
  const halfTan = Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)), tanX = halfTan * camera.aspect, tanY = halfTan * (1 - covered), target = centre.clone(), from = new THREE.Vector3();
  camera.position.copy(target).add(FROM);
  camera.lookAt(target);
  camera.updateMatrixWorld();
  const axis = (i) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, i), [right, up, back] = [axis(0), axis(1), axis(2)];
  let distance = 0.1 * extent;
  for (let round = 0; round < 3; ++round) {  // then also in the middle of the picture
    distance = 0.1 * extent;
    for (const point of points) {
      from.subVectors(point, target);
      distance = Math.max(distance, from.dot(back) + MARGIN * Math.max(Math.abs(from.dot(right)) / tanX, Math.abs(from.dot(up)) / tanY));
    }
    const ends = [Infinity, -Infinity, Infinity, -Infinity];
    for (const point of points) {
      from.subVectors(point, target);
      const depth = distance - from.dot(back), x = from.dot(right) / depth, y = from.dot(up) / depth;
      [ends[0], ends[1], ends[2], ends[3]] = [Math.min(ends[0], x), Math.max(ends[1], x), Math.min(ends[2], y), Math.max(ends[3], y)];
    }
    if (round < 2) target.addScaledVector(right, 0.5 * distance * (ends[0] + ends[1])).addScaledVector(up, 0.5 * distance * (ends[2] + ends[3]));
  }
  target.addScaledVector(up, -covered * halfTan * distance);
  camera.position.copy(target).addScaledVector(back, distance);
  camera.near = extent / 200;
  camera.far = distance + extent * 50;
  camera.updateProjectionMatrix();
  controls.target.copy(target);
}
