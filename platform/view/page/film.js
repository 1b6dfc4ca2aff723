// Pictures and films of the canvas, as files of the browser.
const FILM_HZ = 30, SHEET_COLUMNS = 4, SHEET_ROWS = 3, SHEET_WIDTH = 1600;

export function save(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
const png = (canvas) => new Promise((done) => canvas.toBlob(done, "image/png"));

export class Camera {
  // name(): begins the names of files
  constructor(view, player, name) {
    Object.assign(this, { view, player, name, recorder: null, saved: [] });
  }
  keep(blob, name) {
    this.saved.push({ name, type: blob.type, bytes: blob.size });
    save(blob, name);
    return blob;
  }

  async screenshot() {
    this.view.render();  // toBlob needs the picture of this task
    return this.keep(await png(this.view.renderer.domElement), `${this.name()}.png`);
  }

  // Begins a film, or ends it and saves it.
  toggleFilm() {
    if (this.recorder) return this.recorder.stop();
    const type = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"].find((one) => window.MediaRecorder?.isTypeSupported(one));
    if (!type) return alert("This browser records no films (MediaRecorder with video/webm).");
    const parts = [], recorder = new MediaRecorder(this.view.renderer.domElement.captureStream(FILM_HZ), { mimeType: type, videoBitsPerSecond: 8e6 });
    recorder.ondataavailable = ({ data }) => { if (data.size) parts.push(data); };
    recorder.onstop = () => {
      this.recorder = null;
      this.keep(new Blob(parts, { type: "video/webm" }), `${this.name()}.webm`);
    };
    recorder.start(500);
    this.recorder = recorder;
  }

  // Saves pictures of a recording at equal distances of time, in one file.
  async sheet() {
    const { frames } = this.player, { domElement } = this.view.renderer, n = Math.min(SHEET_COLUMNS * SHEET_ROWS, frames.length);
    if (!n) return null;
    const width = SHEET_WIDTH / SHEET_COLUMNS, height = Math.round(width * domElement.height / domElement.width), t = this.player.t;
    const canvas = Object.assign(document.createElement("canvas"), { width: SHEET_WIDTH, height: height * Math.ceil(n / SHEET_COLUMNS) }), pen = canvas.getContext("2d");
    const [begin, end] = [frames[0].t, frames.at(-1).t];
    Object.assign(pen, { font: "16px system-ui, sans-serif", textBaseline: "top" });
    for (let i = 0; i < n; ++i) {
      const frame = frames[this.player.index(begin + (end - begin) * (n > 1 ? i / (n - 1) : 0))], x = i % SHEET_COLUMNS * width, y = Math.floor(i / SHEET_COLUMNS) * height;
      this.view.update(frame);
      this.view.render();
      pen.drawImage(domElement, x, y, width, height);
      pen.fillStyle = this.view.theme === "dark" ? "#e4e8ee" : "#1c2430";
      pen.fillText(`${frame.t.toFixed(2)} s`, x + 8, y + 6);
      pen.strokeStyle = "#8a93a3";
      pen.strokeRect(x + 0.5, y + 0.5, width - 1, height - 1);
    }
    this.player.showAt(t);
    return this.keep(await png(canvas), `${this.name()}-sheet.png`);
  }
}
