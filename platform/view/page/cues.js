// Sounds for a hand without force. A knock is an impact, the louder the faster; a hum rises with the distance
// of the tool from the device. Off until switched on.
import { divergence } from "./strips.js";

const QUIET_M_PER_S = 0.002, LOUD_M_PER_S = 0.5;  // speeds of the quietest and the loudest knock
const HUM_FROM_M = 0.001, HUM_FULL_M = 0.03;

// Returns 0 to 1 on a logarithmic scale from low to high.
const share = (x, low, high) => Math.min(1, Math.max(0, Math.log(Math.max(x, 1e-12) / low) / Math.log(high / low)));
export const knockGain = (speed) => 0.05 + 0.45 * share(speed, QUIET_M_PER_S, LOUD_M_PER_S);
export const humGain = (distance) => 0.2 * share(distance, HUM_FROM_M, HUM_FULL_M);

export class Cues {
  constructor() {
    Object.assign(this, { on: false, knocks: 0, loudest: 0, hum: 0 });
  }
  // Browsers allow sound after a click or a key alone: this is called by one.
  toggle() {
    this.on = !this.on;
    if (this.on && !this.audio) this.begin();
    if (!this.on && this.audio) this.level.gain.value = 0;
  }
  begin() {
    this.audio = new AudioContext();
    this.level = new GainNode(this.audio, { gain: 0 });
    this.tone = new OscillatorNode(this.audio, { frequency: 110 });
    this.tone.connect(this.level).connect(this.audio.destination);
    this.tone.start();
  }
  show(frame, driven) {
    if (!this.on) return;
    const distance = divergence(frame, driven), now = this.audio.currentTime;
    this.hum = humGain(distance);
    this.level.gain.setTargetAtTime(this.hum, now, 0.03);
    this.tone.frequency.setTargetAtTime(110 + 110 * share(distance, HUM_FROM_M, HUM_FULL_M), now, 0.03);
    if (frame.numImpacts > 0) this.knock(frame.impactSpeed, now);
  }
  silence() {
    this.hum = 0;
    if (this.audio) this.level.gain.value = 0;
  }
  knock(speed, now) {
    this.knocks++;
    this.loudest = Math.max(this.loudest, speed);
    const tone = new OscillatorNode(this.audio, { type: "triangle", frequency: 320 }), level = new GainNode(this.audio, { gain: knockGain(speed) });
    level.gain.setTargetAtTime(0, now, 0.02);
    tone.connect(level).connect(this.audio.destination);
    tone.start();
    tone.stop(now + 0.15);
  }
}
