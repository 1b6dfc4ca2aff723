// Plays a recording: a slider, and frames at the speed of time. Pauses and steps a live run: the run itself
// if it takes a pace, else the picture alone. Resets a run without hardware.
import { PAUSED, encodePace, encodeReset } from "./wire.js";

export class Player {
  // show(frame), mark(t): draw a frame, and its time in the curves. send(buffer): to the run. history(): the
  // latest frames of a run.
  constructor(show, mark, send, history) {
    Object.assign(this, { show, mark, send, history, frames: [], t: 0, playing: false, about: null, frozen: false, latest: null });
    const by = (id) => document.getElementById(id);
    Object.assign(this, { bar: by("player"), button: by("play"), slider: by("slider"), time: by("time"), speed: by("speed"), resetButton: by("reset") });
    this.button.onclick = () => this.toggle();
    by("step").onclick = () => this.step(1);
    this.resetButton.onclick = () => this.reset();
    this.speed.onchange = () => { if (this.takesPace && !this.paused) this.pace(this.liveSpeed, 0); };
    this.slider.oninput = () => { this.playing = false; this.showAt(Number(this.slider.value)); };
  }

  setScene(about) {
    Object.assign(this, { about, frozen: false, latest: null, shown: null, frames: [], playing: false });
    this.takesPace = about.live && about.takes_pace;
    this.bar.hidden = !about.live;
    this.slider.hidden = about.live;
    this.noReset = about.live ? about.no_reset : "";
    Object.assign(this.resetButton, { disabled: Boolean(this.noReset), title: this.noReset || "Home: to the start" });
    this.speed.hidden = about.live && !about.takes_pace;
    const speeds = [["0.01x", 0.01], ["0.1x", 0.1], ["0.25x", 0.25], ["1x", 1], ...about.live ? [] : [["2x", 2], ["5x", 5]], ...about.fast ? [["no limit", Infinity]] : []];
    this.speed.replaceChildren(...speeds.map(([text, value]) => new Option(text, String(value))));
    this.speed.value = about.fast ? "Infinity" : "1";
  }
  load(frames) {
    if (!frames.length) return;
    this.frames = frames;
    this.bar.hidden = frames.length < 2;
    Object.assign(this.slider, { min: frames[0].t, max: frames.at(-1).t });
    this.showAt(frames[0].t);
    this.playing = frames.length > 1;
  }

  // Takes a frame of a live run.
  arrived(frame) {
    this.latest = frame;
    if (!this.frozen) this.show(this.shown = frame);
    this.time.textContent = `${frame.t.toFixed(3)} s`;
  }
  get isLive() { return Boolean(this.about?.live); }
  get paused() { return this.isLive ? this.takesPace ? Boolean(this.latest && this.latest.flags & PAUSED) : this.frozen : !this.playing; }
  get atEnd() { return !this.isLive && this.frames.length > 1 && this.t >= this.frames.at(-1).t; }
  // a run in wall time goes at 1x without a limit of its own
  get liveSpeed() { return !this.about.fast && this.speed.value === "1" ? Infinity : Number(this.speed.value); }
  pace(speed, steps) { this.send(encodePace({ speed, steps })); }

  toggle() {
    if (this.takesPace) this.pace(this.paused ? this.liveSpeed : 0, 0);
    if (this.isLive) return this.freeze(!this.takesPace && !this.frozen);
    if (this.frames.length < 2) return;
    if (!this.playing && this.atEnd) this.showAt(this.frames[0].t);
    this.playing = !this.playing;
  }
  // on: true to keep the picture while frames arrive
  freeze(on) {
    this.frozen = on;
    if (on || !this.latest) return;
    this.show(this.shown = this.latest);
    this.mark(null);
  }
  // Steps by frames of a recording, or by periods of a run; and through the latest frames of a run.
  step(frames) {
    if (this.isLive) return this.stepLive(frames);
    if (!this.frames.length) return;
    this.playing = false;
    this.showAt(this.frames[Math.min(Math.max(this.index(this.t) + frames, 0), this.frames.length - 1)].t);
  }
  stepLive(frames) {
    const list = this.history(), last = list.length - 1, at = list.findLastIndex((frame) => frame.t <= (this.shown?.t ?? Infinity));
    if (this.takesPace && frames > 0 && (!this.frozen || at === last)) {
      this.freeze(false);
      return this.pace(0, frames);
    }
    if (this.takesPace && !this.paused) this.pace(0, 0);
    this.freeze(true);
    if (last < 0) return;
    this.show(this.shown = list[Math.min(Math.max(at + frames, 0), last)]);
    this.mark(this.shown.t);
  }
  // Starts a run again, or shows the start of a recording.
  reset() {
    if (this.isLive && !this.noReset) {
      this.freeze(false);
      this.send(encodeReset());
    }
    if (this.isLive || !this.frames.length) return;
    this.playing = false;
    this.showAt(this.frames[0].t);
  }

  // Returns the index of the last frame that is not after t.
  index(t) {
    let low = 0, high = this.frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle].t <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  }
  showAt(t) {
    this.t = t;
    this.show(this.frames[this.index(t)]);
    this.mark(t);
    this.slider.value = t;
    this.time.textContent = `${t.toFixed(2)} of ${this.frames.at(-1).t.toFixed(2)} s`;
  }
  tick(now) {
    const dt = (now - (this.before ?? now)) / 1000;
    this.before = now;
    const text = this.paused ? "play" : "pause";
    if (this.button.textContent !== text) this.button.textContent = text;
    if (!this.playing) return;
    const end = this.frames.at(-1).t;
    this.showAt(Math.min(this.t + dt * Number(this.speed.value), end));
    this.playing = this.t < end;
  }
}
