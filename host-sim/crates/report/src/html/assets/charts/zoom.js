// Zoom without a mouse: by keys and by a finger.

/** Shows a part of the time, within what is recorded; null shows all. */
function show(plot, from, to) {
  var times = plot.data[0], first = times[0], last = times[times.length - 1];
  if (from === null || to - from >= last - first) { from = first; to = last; }
  if (from < first) { to += first - from; from = first; }
  if (to > last) { from -= to - last; to = last; }
  if (to > from) plot.setScale("x", { min: from, max: to });
}

/** Keys of a chart that has the focus: + and −, arrows, 0 or Escape for all. */
function keys(place, plot) {
  place.tabIndex = 0;
  place.setAttribute("role", "group");
  place.setAttribute("aria-label", "chart: + and - zoom, arrows move, 0 shows all");
  place.addEventListener("keydown", function (event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    var from = plot.scales.x.min, to = plot.scales.x.max, part = (to - from) / 4;
    if (event.key === "+" || event.key === "=") show(plot, from + part, to - part);
    else if (event.key === "-") show(plot, from - 2 * part, to + 2 * part);
    else if (event.key === "ArrowLeft") show(plot, from - part, to - part);
    else if (event.key === "ArrowRight") show(plot, from + part, to + part);
    else if (event.key === "0" || event.key === "Escape") show(plot, null, null);
    else return;
    event.preventDefault();
  });
}

/** A finger that moves sideways chooses a part; one that moves up or down scrolls the page; a double tap shows all. */
function fingers(plot) {
  var over = plot.over, began = null;
  over.style.touchAction = "pan-y";
  function at(event) { return Math.min(Math.max(event.clientX - over.getBoundingClientRect().left, 0), over.clientWidth); }
  function choose(left, right) {
    plot.setSelect({ left: left, top: 0, width: right - left, height: right > left ? over.clientHeight : 0 }, false);
  }
  over.addEventListener("pointerdown", function (event) {
    if (event.pointerType === "touch") began = at(event);
  });
  over.addEventListener("pointermove", function (event) {
    if (began !== null && event.pointerType === "touch") choose(Math.min(began, at(event)), Math.max(began, at(event)));
  });
  over.addEventListener("pointerup", function (event) {
    if (began === null || event.pointerType !== "touch") return;
    var left = Math.min(began, at(event)), right = Math.max(began, at(event));
    began = null;
    choose(0, 0);
    if (right - left > 15) show(plot, plot.posToVal(left, "x"), plot.posToVal(right, "x"));
  });
  over.addEventListener("pointercancel", function () { began = null; choose(0, 0); });
}
