// One quantity over another: dots, lines, and ranges with their middle.

/** uPlot wants one row of x for all layers: every point gets a row of its own, where the others have none. */
function columnsOf(layers) {
  var rows = [];
  layers.forEach(function (layer, index) {
    layer.points.forEach(function (point, order) { rows.push([point[0], index, point, order]); });
  });
  rows.sort(function (a, b) { return a[0] - b[0] || a[1] - b[1] || a[3] - b[3]; });
  var columns = layers.map(function () { return rows.map(function () { return null; }); });
  rows.forEach(function (row, at) { columns[row[1]][at] = row[2].length > 2 ? row[2][2] : row[2][1]; });
  return [rows.map(function (row) { return row[0]; })].concat(columns);
}

/** The first layer of its kind: the one itself unless it has no name. */
function lead(layers, index) {
  var layer = layers[index];
  if (layer.label) return index;
  return layers.findIndex(function (other) {
    return other.style === layer.style && (other.marks === "bins") === (layer.marks === "bins");
  });
}

function ofLayer(layer) {
  return layer.marks === "bins" ? colour("ink") : stroke(layer.style);
}

/** Draws the ranges of layers of bins. */
function whiskers(layers) {
  return function (plot) {
    var ink = plot.ctx;
    ink.save();
    ink.strokeStyle = colour("ink");
    ink.lineWidth = window.devicePixelRatio || 1;
    layers.forEach(function (layer, index) {
      if (layer.marks !== "bins" || !plot.series[index + 1].show) return;
      layer.points.forEach(function (point) {
        var x = plot.valToPos(point[0], "x", true);
        if (x < plot.bbox.left || x > plot.bbox.left + plot.bbox.width) return;
        ink.beginPath();
        ink.moveTo(x, plot.valToPos(point[1], "y", true));
        ink.lineTo(x, plot.valToPos(point[3], "y", true));
        ink.stroke();
      });
    });
    ink.restore();
  };
}

/** The nearest row in which a layer has a value. */
function nearest(plot, series, index) {
  var values = plot.data[series];
  if (series === 0 || values[index] !== null) return index;
  for (var off = 1; off < values.length; off++) {
    if (values[index - off] !== null && values[index - off] !== undefined) return index - off;
    if (values[index + off] !== null && values[index + off] !== undefined) return index + off;
  }
  return index;
}

function layerOverState(layers, index, unit) {
  var layer = layers[index], dots = layer.marks !== "line", ink = ofLayer(layer);
  return {
    label: layer.label || (layer.marks === "bins" ? "middle half" : "other branch"),
    // A further branch has no place in the legend: it goes with the first.
    class: lead(layers, index) === index ? null : "branch",
    stroke: ink,
    width: dots ? 0 : 2,
    paths: dots ? function () { return null; } : undefined,
    spanGaps: true,
    points: { show: dots, size: layer.marks === "bins" ? 6 : 4, fill: ink, width: 0 },
    value: function (plot, value) { return withUnit(value, unit); },
  };
}

/** Branches are switched with the first layer of their kind. */
function withBranches(layers) {
  return function (plot, index, changed) {
    if (index === null || changed.show === undefined || lead(layers, index - 1) !== index - 1) return;
    layers.forEach(function (layer, at) {
      if (at !== index - 1 && lead(layers, at) === index - 1) plot.setSeries(at + 1, { show: changed.show });
    });
  };
}

function overState(place, data, width) {
  var layers = data.layers, xTitle = parts(data.x), yTitle = parts(data.y);
  place.appendChild(element("p", "panel", data.title));
  var options = {
    width: Math.min(width, 680),
    height: 350,
    scales: { x: { time: false }, y: { range: ofAll } },
    legend: legend(layers.map(ofLayer)),
    cursor: { drag: { x: true, y: true, uni: 12 }, dataIdx: nearest },
    axes: [across(data.x), upwards(380)],
    series: [{ label: xTitle[0], value: function (plot, value) { return withUnit(value, xTitle[1]); } }].concat(
      layers.map(function (layer, index) { return layerOverState(layers, index, yTitle[1]); })
    ),
    hooks: {
      drawClear: data.band === null ? [] : [shades([[null, null, -data.band, data.band]])],
      draw: [whiskers(layers)],
      setSeries: [withBranches(layers)],
    },
  };
  place.appendChild(element("p", "quantity", data.y));
  return [new uPlot(options, columnsOf(layers), place)];
}
