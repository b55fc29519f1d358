// Puts interactive charts in the place of the page's drawings. Without scripts, and on paper, the drawings stay.
//
// A figure holds its drawing (SVG) and, as JSON, the numbers behind it:
//   kind "time":   panels of one recording over one time axis, zoomed and read together
//   kind "figure": one quantity over another: dots, lines, ranges with their middle
//   kind "rows":   one row for each recording, its error over time, with the located intervals
//   kind "map":    cells over two states; the drawing stays, and tells the cell under the pointer
// Numbers of a series are whole steps from one value to the next ([first, change, change, …]); null is no value.

var SVG_ONLY = "map";
// For tests, and for whoever wants the numbers: every chart with the figure it stands in.
var all = (window.hostSimCharts = []);

var KINDS = { time: overTime, figure: overState, rows: inRows };

function widthOf(figure) {
  return Math.max(240, Math.floor(figure.getBoundingClientRect().width));
}

/** Draws a figure's charts, unless it has them or is folded away. */
function live(figure) {
  if (figure.classList.contains("live") || figure.closest("details:not([open])")) return;
  var data = JSON.parse(figure.querySelector("script").textContent);
  if (data.kind === SVG_ONLY) {
    figure.classList.add("live", "drawn");
    onMap(figure, data);
    return;
  }
  var place = element("div", "plots");
  figure.appendChild(place);
  var plots;
  try {
    plots = KINDS[data.kind](place, data, widthOf(figure));
  } catch (error) {
    // The drawing stays, and so do all other charts.
    place.remove();
    figure.classList.remove("data");
    console.error(error);
    return;
  }
  plots.forEach(function (plot) { all.push({ figure: figure, kind: data.kind, plot: plot, most: plot.width }); });
  figure.classList.add("live");
}

function remove(figure) {
  for (var index = all.length - 1; index >= 0; index--) {
    if (all[index].figure === figure) all.splice(index, 1)[0].plot.destroy();
  }
  var place = figure.querySelector(".plots");
  if (place) place.remove();
  if (!figure.classList.contains("drawn")) figure.classList.remove("live");
}

var figures = Array.prototype.slice.call(document.querySelectorAll("figure.data"));

function again() {
  figures.forEach(remove);
  figures.forEach(live);
}

// What is folded is drawn when it is opened.
document.querySelectorAll("details").forEach(function (folded) {
  folded.addEventListener("toggle", function () {
    if (folded.open) folded.querySelectorAll("figure.data").forEach(live);
  });
});
window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
var width = document.documentElement.clientWidth;
window.addEventListener("resize", function () {
  if (document.documentElement.clientWidth === width) return;
  width = document.documentElement.clientWidth;
  all.forEach(function (one) {
    var room = widthOf(one.figure);
    one.plot.setSize({ width: one.kind === "figure" ? Math.min(room, 680) : room, height: one.plot.height });
  });
});
figures.forEach(live);

// In a frame that has its page as text, a link to a place within the page would lead out of it.
document.querySelectorAll(".contents a").forEach(function (link) {
  link.addEventListener("click", function (event) {
    event.preventDefault();
    document.getElementById(link.hash.slice(1)).scrollIntoView();
  });
});
