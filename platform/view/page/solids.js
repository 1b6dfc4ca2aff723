// Geometries of a scene's solids, and of arrows.
import * as THREE from "three";

const SEGMENTS = 24;

// Turns the axis from y to z, as in the core's capsules and cylinders.
const aboutZ = (geometry) => geometry.rotateX(Math.PI / 2);

// Returns the geometry of a solid. coarse: true for scenes with many solids.
export function geometryOf(solid, meshes, extent, coarse) {
  const [a, b, c] = solid.size;
  switch (solid.kind) {
    case "box": return new THREE.BoxGeometry(2 * a, 2 * b, 2 * c);
    case "sphere": return new THREE.SphereGeometry(a, coarse ? 12 : SEGMENTS, coarse ? 8 : SEGMENTS / 2);
    case "capsule": return aboutZ(new THREE.CapsuleGeometry(a, 2 * b, 8, SEGMENTS));
    case "cylinder": return aboutZ(new THREE.CylinderGeometry(a, a, 2 * b, SEGMENTS));
    case "plane": return new THREE.PlaneGeometry(8 * extent, 8 * extent);
    default: return triangles(meshes[solid.mesh].vertices, meshes[solid.mesh].triangles);
  }
}

// Returns a surface of nodes; moving nodes are written into its position attribute.
export function triangles(vertices, corners) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(vertices, 3));
  geometry.setIndex(corners);
  geometry.computeVertexNormals();
  return geometry;
}

// Returns an arrow of length 1 along z, with its tail at the origin.
export function arrowGeometry() {
  const shaft = aboutZ(new THREE.CylinderGeometry(0.018, 0.018, 0.8, 6, 1, true)).translate(0, 0, 0.4).toNonIndexed();
  const head = aboutZ(new THREE.ConeGeometry(0.06, 0.2, 10)).translate(0, 0, 0.9).toNonIndexed();
  const geometry = new THREE.BufferGeometry();
  for (const name of ["position", "normal"])
    geometry.setAttribute(name, new THREE.Float32BufferAttribute([...shaft.attributes[name].array, ...head.attributes[name].array], 3));
  return geometry;
}

export function setPose(object, pose) {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
}

const Z = new THREE.Vector3(0, 0, 1), way = new THREE.Vector3();
// Stretches an object of length 1 along z from a to b. width: scale across.
export function span(object, a, b, width) {
  way.subVectors(b, a);
  const length = way.length();
  object.visible = length > 1e-9;
  if (!object.visible) return;
  object.position.copy(a);
  object.quaternion.setFromUnitVectors(Z, way.divideScalar(length));
  object.scale.set(width, width, length);
}
