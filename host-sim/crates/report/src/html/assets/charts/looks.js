// Colours, axes and marks that all charts share.

var page = getComputedStyle(document.documentElement);
function colour(name) {
  return page.getPropertyValue("--" + name).trim();
}

function stroke(style) {
  return colour("trace-" + style);
}

function thickness(style) {
  return style === "recorded" ? 3 : 1.5;
}

var FONT = "12px system-ui, sans-serif";
// All panels of a figure begin at the same place.
var LEFT = 58;

/** Marks of the legend: a full square of the trace's colour. */
function legend(colours) {
  function of(plot, index) { return index > 0 ? colours[index - 1] : "transparent"; }
  return { markers: { width: 2, stroke: of, fill: of } };
}

function axis(options) {
  var looks = {
    stroke: colour("ink"),
    font: FONT,
    labelFont: FONT,
    grid: { stroke: colour("grid"), width: 1 },
    ticks: { stroke: colour("grid"), width: 1, size: 5 },
    values: function (plot, values) {
      return values.map(function (value) {
        return value === null ? "" : String(+value.toPrecision(8)).replace("-", "−");
      });
    },
  };
  return Object.assign(looks, options);
}

function across(label) {
  return axis(label ? { label: label, labelSize: 20, size: 32 } : { size: 32 });
}

function upwards(height) {
  return axis({ size: LEFT, space: height < 120 ? 20 : 32 });
}

/** The range of all traces in the part that is shown, switched off or not: nothing jumps when one is switched off. */
function ofAll(plot) {
  var rows = plot.series[0].idxs || [0, plot.data[0].length - 1];
  var low = Infinity, high = -Infinity;
  plot.data.slice(1).forEach(function (values) {
    for (var row = rows[0]; row <= rows[1]; row++) {
      var value = values[row];
      if (value === null || value === undefined || !isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  });
  return low > high ? [0, 1] : uPlot.rangeNum(low, high, 0.1, true);
}

/** Shaded rectangles under the traces, each [left, right, bottom, top] in values; null reaches to the edge. */
function shades(rectangles) {
  return function (plot) {
    var box = plot.bbox;
    var ink = plot.ctx;
    ink.save();
    ink.beginPath();
    ink.rect(box.left, box.top, box.width, box.height);
    ink.clip();
    ink.fillStyle = colour("shade");
    rectangles.forEach(function (edges) {
      var x = [edges[0], edges[1]].map(function (value, end) {
        return value === null ? box.left + end * box.width : plot.valToPos(value, "x", true);
      });
      var y = [edges[2], edges[3]].map(function (value, end) {
        return value === null ? box.top + (1 - end) * box.height : plot.valToPos(value, "y", true);
      });
      // An interval shorter than a pixel still shows.
      ink.fillRect(x[0], y[1], Math.max(x[1] - x[0], 2), y[0] - y[1]);
    });
    ink.restore();
  };
}

function element(tag, name, text) {
  var made = document.createElement(tag);
  if (name) made.className = name;
  if (text) made.textContent = text;
  return made;
}
