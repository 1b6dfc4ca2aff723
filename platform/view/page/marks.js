// Marks in the scene: names, frames of bodies and joints, ground and its shadows.
import * as THREE from "three";

const LABEL_PIXELS = 20, MAX_LABELS = 200;

// Returns a text that faces the camera and keeps its size on the screen, above or below its point.
export function label(text, colour, isAbove) {
  const canvas = document.createElement("canvas"), font = "600 24px system-ui, sans-serif", pen = canvas.getContext("2d");
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 12;
  canvas.height = 36;
  pen.font = font;
  pen.textBaseline = "middle";
  pen.lineWidth = 4;
  pen.lineJoin = "round";
  pen.strokeStyle = "rgba(255, 255, 255, 0.8)";
  pen.strokeText(text, 6, 18);
  pen.fillStyle = colour;
  pen.fillText(text, 6, 18);
  const map = Object.assign(new THREE.CanvasTexture(canvas), { colorSpace: THREE.SRGBColorSpace, generateMipmaps: false, minFilter: THREE.LinearFilter });
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.center.set(0, isAbove ? 0 : 1);
  sprite.renderOrder = 6;
  sprite.userData = { text, aspect: canvas.width / canvas.height, isAbove };
  sprite.raycast = () => {};
  return sprite;
}

// Scales a label to its size on the screen. height: of the picture, pixels.
export function sizeLabel(sprite, height, fov) {
  const size = 2 * Math.tan(THREE.MathUtils.degToRad(fov / 2)) * LABEL_PIXELS / Math.max(1, height);
  sprite.scale.set(size * sprite.userData.aspect, size, 1);
}

export function axes(length) {
  const frame = new THREE.AxesHelper(length);
  frame.material.depthTest = false;
  frame.renderOrder = 4;
  frame.raycast = () => {};
  return frame;
}

// Names and frames of all bodies and joints; made when first shown.
export class Marks {
  constructor(about, bodies, joints, extent) {
    Object.assign(this, { about, bodies, joints, extent, labels: [], frames: [] });
  }
  show(name, on) {
    if (on && !this[name].length) this[name] = name === "labels" ? this.makeLabels() : this.makeFrames();
    for (const mark of this[name]) mark.visible = on;
  }
  makeLabels() {
    const named = [...this.bodies.map((group, i) => [group, this.about.bodies[i].name, "#1c2430"]),
      ...this.joints.map((group, i) => [group, this.about.joints[i].name, "#2c5aa0"])];
    return named.slice(0, MAX_LABELS).map(([group, name, colour]) => {
      const sprite = label(name, colour, group.userData.body !== undefined);
      group.parent.add(sprite);
      sprite.userData.of = group;
      return sprite;
    });
  }
  makeFrames() {
    return this.bodies.map((group) => {
      const frame = axes(0.08 * this.extent);
      group.add(frame);
      return frame;
    });
  }
  // Moves the labels with their bodies; those at one place are drawn in lines. project(point): pixels.
  update(height, fov, project) {
    const lines = new Map(), at = new THREE.Vector3();
    for (const sprite of this.labels) {
      if (!sprite.visible) continue;
      const { isAbove, of } = sprite.userData;
      sprite.position.copy(of.position);
      sizeLabel(sprite, height, fov);
      const { x, y } = project(of.getWorldPosition(at).toArray());
      const place = [Math.round(x / 40), Math.round(y / LABEL_PIXELS), isAbove].join(), line = lines.get(place) ?? 0;
      lines.set(place, line + 1);
      sprite.center.set(0, isAbove ? -line : 1 + line);
    }
  }
}

// Adds a ground that shows only shadows, at this height.
export function addGround(world, extent, centre, z) {
  const ground = new THREE.Mesh(new THREE.PlaneGeometry(8 * extent, 8 * extent), new THREE.ShadowMaterial({ opacity: 0.28, depthWrite: false }));
  ground.position.set(centre.x, centre.y, z);
  ground.receiveShadow = true;
  ground.renderOrder = 1;
  ground.raycast = () => {};
  world.add(ground);
  return ground;
}

// Directs the light of the shadows at the scene.
export function aimSun(sun, centre, extent) {
  sun.position.copy(centre).add(new THREE.Vector3(-0.35, -0.45, 1).normalize().multiplyScalar(4 * extent));
  sun.target.position.copy(centre);
  sun.target.updateMatrixWorld();
  sun.shadow.mapSize.set(1024, 1024);
  sun.shadow.radius = 5;
  sun.shadow.bias = -0.0005;
  sun.shadow.normalBias = 0.002 * extent;
  Object.assign(sun.shadow.camera, { left: -1.6 * extent, right: 1.6 * extent, top: 1.6 * extent, bottom: -1.6 * extent, near: extent, far: 9 * extent });
  sun.shadow.camera.updateProjectionMatrix();
}
