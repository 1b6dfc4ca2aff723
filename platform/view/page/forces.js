// Arrows of contact forces, and the scale of all forces.
import * as THREE from "three";
import { arrowGeometry } from "./solids.js";

const MAX_ARROWS = 4096, SCALE_PIXELS = 60;

// Returns the round force, N, whose arrow has about this length: 1, 2 or 5 times a power of ten.
// metresPerNewton: scale of the arrows. pixelsPerMetre: at the distance of the camera's target.
export function scaleBar(metresPerNewton, pixelsPerMetre) {
  const pixelsPerNewton = metresPerNewton * pixelsPerMetre, wanted = SCALE_PIXELS / pixelsPerNewton;
  if (!(wanted > 0) || !Number.isFinite(wanted)) return null;
  const decade = 10 ** Math.floor(Math.log10(wanted));
  const newtons = decade * [5, 2, 1].find((digit) => digit * decade <= wanted * 1.0001);
  return { newtons, pixels: newtons * pixelsPerNewton };
}

// Contact points, and their forces as arrows.
export class ContactArrows {
  constructor(world, colour) {
    const many = (geometry) => {
      const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true }), MAX_ARROWS);
      mesh.count = 0;
      mesh.frustumCulled = false;
      mesh.renderOrder = 2;
      world.add(mesh);
      return mesh;
    };
    this.arrows = many(arrowGeometry());
    this.points = many(new THREE.OctahedronGeometry(1, 1));
  }

  // scale: m per N. extent: of the scene, m.
  update(frame, shown, scale, extent) {
    const at = new THREE.Vector3(), force = new THREE.Vector3(), size = new THREE.Vector3(), turn = new THREE.Quaternion(), matrix = new THREE.Matrix4();
    const z = new THREE.Vector3(0, 0, 1), n = shown ? Math.min(frame.numContacts, MAX_ARROWS) : 0;
    for (let i = 0; i < n; ++i) {
      const c = frame.contacts.subarray(11 * i, 11 * i + 11);
      at.set(c[2], c[3], c[4]);
      force.set(c[8], c[9], c[10]);
      const length = Math.min(force.length() * scale, 0.5 * extent);
      turn.setFromUnitVectors(z, force.normalize());
      const width = Math.max(length, 0.06 * extent);
      this.arrows.setMatrixAt(i, matrix.compose(at, turn, size.set(width, width, Math.max(length, 1e-6))));
      this.points.setMatrixAt(i, matrix.compose(at, turn, size.setScalar(0.006 * extent)));
    }
    for (const mesh of [this.arrows, this.points]) {
      mesh.count = n;
      mesh.instanceMatrix.clearUpdateRanges();
      mesh.instanceMatrix.addUpdateRange(0, 16 * n);
      mesh.instanceMatrix.needsUpdate = n > 0;
    }
  }
}
