// One row for each recording, its error over time.

/** The rows' traces as series: row 0 is on top, and values reach from the row's base to 0.85 above it. */
function seriesOfRows(data) {
  var found = { series: [{ label: "time" }], columns: [times(data.time)], shade: [], traces: [] };
  data.rows.forEach(function (row, index) {
    var base = data.rows.length - 1 - index;
    row.shade.forEach(function (ends) { found.shade.push([ends[0], ends[1], base, base + 0.95]); });
    row.traces.forEach(function (trace) {
      var values = unpacked(trace);
      found.columns.push(values.map(function (value) {
        return value === null ? null : base + (0.85 * Math.min(value, data.most)) / data.most;
      }));
      found.series.push({ label: trace.label, stroke: stroke(trace.style), width: 1.25, points: { show: false } });
      found.traces.push({ row: index, label: trace.label, values: values });
    });
  });
  return found;
}

/** A switch for a kind of trace, in all rows. */
function switchOf(trace, plotted) {
  var button = element("button", "", trace.label);
  button.type = "button";
  button.style.setProperty("--mark", stroke(trace.style));
  button.setAttribute("aria-pressed", "true");
  button.addEventListener("click", function () {
    var show = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", String(show));
    plotted().series.forEach(function (one, index) {
      if (index > 0 && one.label === trace.label) plotted().setSeries(index, { show: show });
    });
  });
  return button;
}

/** What is under the pointer, as a text. */
function underPointer(plot, data, traces) {
  var at = plot.cursor.idx, row = data.rows.length - 1 - Math.floor(plot.posToVal(plot.cursor.top, "y"));
  var here = traces.filter(function (trace) { return trace.row === row; });
  if (at === null || at === undefined || plot.cursor.left < 0 || !here.length) return "";
  var values = here.map(function (trace) { return trace.label + " " + withUnit(trace.values[at], data.unit); });
  return data.rows[row].label + " at " + withUnit(plot.data[0][at], "s") + ": " + values.join(", ");
}

/** An axis with the rows' names, cut where they are long. */
function namesOfRows(rows) {
  var longest = Math.max.apply(null, rows.map(function (row) { return row.label.length; }).concat(1));
  return axis({
    size: Math.min(120, Math.max(LEFT, 14 + 6.6 * longest)),
    splits: function () { return rows.map(function (row, index) { return index; }); },
    values: function (plot, splits) {
      return splits.map(function (at) {
        var label = rows[rows.length - 1 - at].label;
        return label.length > 16 ? label.slice(0, 15) + "…" : label;
      });
    },
  });
}

function inRows(place, data, width) {
  place.appendChild(element("p", "panel", data.title));
  var found = seriesOfRows(data), plot;
  // A legend of all rows would be long: one switch for each kind of trace, and a line for the row under the pointer.
  var switches = element("p", "switches"), told = element("span", "soft", "");
  data.rows.length && data.rows[0].traces.forEach(function (trace) {
    switches.appendChild(switchOf(trace, function () { return plot; }));
  });
  switches.appendChild(told);
  var options = {
    width: width,
    height: 54 + 46 * data.rows.length,
    scales: { x: { time: false }, y: { range: [0, data.rows.length] } },
    legend: { show: false },
    cursor: { drag: { x: true, y: false }, y: false, points: { show: false } },
    axes: [across("time [s]"), namesOfRows(data.rows)],
    series: found.series,
    hooks: {
      drawClear: [shades(found.shade)],
      setCursor: [function (drawn) { told.textContent = underPointer(drawn, data, found.traces); }],
    },
  };
  plot = new uPlot(options, found.columns, place);
  place.appendChild(switches);
  keys(place, plot);
  fingers(plot);
  return [plot];
}
