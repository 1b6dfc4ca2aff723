// Mouse, touch and gamepad as a relative device that grips the tool.
import * as THREE from "three";
import { encodePointer } from "./wire.js";

const SEND_MS = 1000 / 60, TURN_PER_PIXEL = 0.01, DEPTH_PER_STEP = 0.02;
const PAD_SPEED = 0.25, PAD_TURN = 1.5, PAD_DEAD = 0.12;  // m/s, rad/s at full deflection; dead zone

export class Pointer {
  constructor(view, canvas, send) {
    Object.assign(this, { view, canvas, send, holds: false, kept: false, clutch: false, target: 0, number: 0, enabled: false, drag: null });
    Object.assign(this, { joints: null, hover: null, pointed: null });
    this.shift = new THREE.Vector3();
    this.turn = new THREE.Vector3();
    this.ray = new THREE.Raycaster();
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, (event) => this.up(event));
    canvas.addEventListener("wheel", (event) => this.wheel(event), { capture: true, passive: false });
    setInterval(() => this.tick(), SEND_MS);
  }

  // Grips a driven body. kept: true to hold it until release(), false while the mouse button is down.
  grab(target = this.target, kept = true) {
    this.kept = kept;
    if (this.holds && this.target === target) return;
    this.target = target;
    this.holds = true;
    this.shift.set(0, 0, 0);
    this.turn.set(0, 0, 0);
  }
  release() {
    this.holds = this.kept = false;
    this.drag = null;
    this.view.controls.enabled = true;
  }

  // Marks the body that a press would drag.
  showHover() {
    const hit = this.enabled && this.pointed && !this.drag ? this.under(this.pointed) : null;
    this.pointed = null;
    this.hover = hit ? hit.target : null;
    this.canvas.style.cursor = hit ? "grab" : "";
    this.view.highlight(this.hover);
  }

  // Returns the coupled body under the pointer, and the point hit.
  under(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
    this.ray.setFromCamera(at, this.view.camera);
    const grabbed = this.view.bodies?.filter((body) => body.userData.target >= 0) ?? [];
    for (const hit of this.ray.intersectObjects(grabbed, true)) {
      if (!hit.object.isMesh) continue;
      let object = hit.object;
      while (object.userData.target === undefined) object = object.parent;
      return { target: object.userData.target, point: hit.point };
    }
    return null;
  }

  down(event) {
    if (!this.enabled || this.joints || event.button !== 0) return;
    const hit = this.under(event);
    if (!hit) return;
    event.stopImmediatePropagation();  // no camera motion
    this.view.controls.enabled = false;
    this.grab(hit.target, this.kept && this.target === hit.target);
    this.drag = { point: hit.point, x: event.clientX, y: event.clientY };
    this.canvas.setPointerCapture(event.pointerId);
  }

  move(event) {
    if (!this.drag) return void (this.pointed = { clientX: event.clientX, clientY: event.clientY });
    const dx = event.clientX - this.drag.x, dy = event.clientY - this.drag.y, { camera } = this.view;
    Object.assign(this.drag, { x: event.clientX, y: event.clientY });
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0), up = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    if (event.shiftKey) {
      this.turn.addScaledVector(up, TURN_PER_PIXEL * dx).addScaledVector(right, TURN_PER_PIXEL * dy);
      return;
    }
    const depth = this.drag.point.clone().applyMatrix4(camera.matrixWorldInverse).z;
    const perPixel = 2 * -depth * Math.tan(THREE.MathUtils.degToRad(camera.fov / 2)) / this.canvas.clientHeight;
    const shift = right.multiplyScalar(dx * perPixel).addScaledVector(up, -dy * perPixel);
    this.drag.point.add(shift);
    this.shift.add(shift);
  }

  up(event) {
    if (!this.drag) return;
    this.drag = null;
    this.view.controls.enabled = true;
    this.canvas.releasePointerCapture?.(event.pointerId);
    if (!this.kept) this.release();
  }

  wheel(event) {
    if (!this.enabled) return;
    if (this.joints) return this.joints.wheel(event, this.under(event)?.target);
    if (!this.drag) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.shift.addScaledVector(this.view.camera.getWorldDirection(new THREE.Vector3()), -Math.sign(event.deltaY) * DEPTH_PER_STEP * this.view.extent);
  }

  gamepad(dt) {
    const pad = [...(navigator.getGamepads?.() ?? [])].find((one) => one?.connected);
    if (!pad) return;
    const pressed = (i) => pad.buttons[i]?.pressed ?? false, way = (i) => Math.abs(pad.axes[i] ?? 0) > PAD_DEAD ? pad.axes[i] : 0;
    if (pressed(0) && !this.holds) this.grab();
    if (pressed(1) && this.holds) this.release();
    const { matrixWorld } = this.view.camera, axis = (i) => new THREE.Vector3().setFromMatrixColumn(matrixWorld, i);
    const depth = (pad.buttons[7]?.value ?? 0) - (pad.buttons[6]?.value ?? 0);
    this.shift.addScaledVector(axis(0), way(0) * PAD_SPEED * dt).addScaledVector(axis(1), -way(1) * PAD_SPEED * dt).addScaledVector(axis(2), -depth * PAD_SPEED * dt);
    this.turn.addScaledVector(axis(1), way(2) * PAD_TURN * dt).addScaledVector(axis(0), way(3) * PAD_TURN * dt);
    this.padClutch = pressed(5);
  }

  // Sends a sample even without motion, because a silent device is stale.
  tick() {
    if (this.pointed) this.showHover();
    if (this.enabled && this.joints) return this.joints.tick(SEND_MS / 1000);
    if (!this.enabled || document.hidden) return;
    this.gamepad(SEND_MS / 1000);
    const moves = !this.clutch && !this.padClutch;
    this.number = (this.number + 1) >>> 0;
    this.shift.clampLength(0, 0.9);
    this.turn.clampLength(0, 3);
    this.send(encodePointer({ number: this.number, holds: this.holds, moves, target: this.target, shift: this.shift.toArray(), turn: this.turn.toArray() }));
    this.shift.set(0, 0, 0);
    this.turn.set(0, 0, 0);
  }
}
