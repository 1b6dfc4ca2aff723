// Plays a recording: a slider, and frames at the speed of time.
export class Player {
  constructor(show, mark) {
    Object.assign(this, { show, mark, frames: [], t: 0, playing: false });
    const by = (id) => document.getElementById(id);
    Object.assign(this, { bar: by("player"), button: by("play"), slider: by("slider"), time: by("time"), speed: by("speed") });
    this.button.onclick = () => this.toggle();
    this.slider.oninput = () => { this.playing = false; this.seek(Number(this.slider.value)); };
  }

  load(frames) {
    if (!frames.length) return;
    this.frames = frames;
    this.bar.hidden = frames.length < 2;
    Object.assign(this.slider, { min: frames[0].t, max: frames.at(-1).t });
    this.seek(frames[0].t);
    this.playing = frames.length > 1;
  }
  toggle() {
    if (this.frames.length < 2) return;
    if (!this.playing && this.t >= this.frames.at(-1).t) this.seek(this.frames[0].t);
    this.playing = !this.playing;
  }
  step(frames) {
    if (!this.frames.length) return;
    this.playing = false;
    this.seek(this.frames[Math.min(Math.max(this.index(this.t) + frames, 0), this.frames.length - 1)].t);
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
  seek(t) {
    this.t = t;
    this.show(this.frames[this.index(t)]);
    this.mark(t);
    this.slider.value = t;
    this.time.textContent = `${t.toFixed(2)} of ${this.frames.at(-1).t.toFixed(2)} s`;
  }
  tick(now) {
    const dt = (now - (this.before ?? now)) / 1000;
    this.before = now;
    this.button.textContent = this.playing ? "pause" : "play";
    if (!this.playing) return;
    const end = this.frames.at(-1).t;
    this.seek(Math.min(this.t + dt * Number(this.speed.value), end));
    this.playing = this.t < end;
  }
}
