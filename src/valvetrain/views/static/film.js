// A film of one cam revolution, recorded while it is played: makeFilm(canvas, began, done). The canvas of the picture is clear where
// nothing is drawn, and a recorder makes that black, so each picture is copied onto white paper, with the scale and a few words.
const FILM_TYPES = ["video/mp4;codecs=avc1.640028", "video/mp4;codecs=avc1.42E01E", "video/mp4", "video/webm;codecs=vp9", "video/webm"];
const FILM_RATE = 30, FILM_BITS = 8e6, LAST_PICTURE = 100, PAPER = "#ffffff", INK = "#1b2430", BAND = 76;

function filmType() { return window.MediaRecorder ? FILM_TYPES.find(function (type) { return MediaRecorder.isTypeSupported(type); }) || "" : ""; }

/**
 * Films a canvas. began() is called once the recorder runs, done(file, failure) at the end: a Blob, or null and why.
 * Returns {take, stop}: take(painted, lines) adds a picture, stop() ends the film.
 */
function makeFilm(canvas, began, done) {
  const type = filmType(), ratio = canvas.width / canvas.clientWidth, wide = canvas.width & ~1, high = Math.round(canvas.height + BAND * ratio) & ~1;
  const sheet = make("canvas", { width: wide, height: high }), pen = sheet.getContext("2d", { alpha: false }), parts = [];
  const recorder = new MediaRecorder(sheet.captureStream(FILM_RATE), { mimeType: type, videoBitsPerSecond: FILM_BITS });
  let failure = "";
  // A hidden page draws nothing, so the film waits as well.
  function hold() { if (recorder.state !== "inactive") { if (document.hidden) { recorder.pause(); } else { recorder.resume(); } } }
  function write(words, align, x, line, aside = 20) {
    pen.textAlign = align;
    pen.fillText(words, x, high + (19 * line - BAND + 12) * ratio, wide - aside * ratio);
  }
  recorder.addEventListener("start", began);
  recorder.addEventListener("dataavailable", function (event) { parts.push(event.data); });
  recorder.addEventListener("error", function (event) { failure = String(event.error ? event.error.message : "unknown"); });
  recorder.addEventListener("stop", function () {
    document.removeEventListener("visibilitychange", hold);
    recorder.stream.getTracks().forEach(function (track) { track.stop(); });
    done(failure ? null : new Blob(parts, { type: type }), failure);
  });
  document.addEventListener("visibilitychange", hold);
  recorder.start();
  return {
    take: function (painted, lines) {
      const room = high - BAND * ratio, size = Math.min(wide / canvas.width, room / canvas.height), left = 10 * ratio, right = wide - left;
      pen.fillStyle = PAPER; pen.fillRect(0, 0, wide, high);
      pen.drawImage(canvas, (wide - size * canvas.width) / 2, (room - size * canvas.height) / 2, size * canvas.width, size * canvas.height);
      pen.font = 13 * ratio + "px sans-serif";
      if (painted) {
        pen.fillStyle = pen.createLinearGradient(left, 0, right, 0);
        painted.stops.forEach(function (stop, place) { pen.fillStyle.addColorStop(place / (painted.stops.length - 1), stop); });
        pen.fillRect(left, room, right - left, 12 * ratio);
      }
      pen.fillStyle = INK;
      if (painted) {
        write(number(painted.low), "left", left, 1); write(number(painted.high), "right", right, 1);
        write(painted.words + " (" + painted.unit + ")", "center", wide / 2, 1, 120);
      }
      lines.forEach(function (words, line) { write(words, "center", wide / 2, line + 2); });
    },
    // The last picture is taken from the sheet when the page is next drawn.
    stop: function () {
      function end() { if (recorder.state !== "inactive") { recorder.stop(); } }
      requestAnimationFrame(function () { requestAnimationFrame(function () { setTimeout(end, LAST_PICTURE); }); });
    },
  };
}

function saveFile(file, name) {
  const link = make("a", { href: URL.createObjectURL(file), download: name });
  link.click();
  setTimeout(function () { URL.revokeObjectURL(link.href); }, 60000);
}
