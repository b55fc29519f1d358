// Charts over time: panels of one recording, zoomed and read together.

/** What is recorded less each simulation. */
function residuals(traces, series) {
  var recorded = traces.findIndex(function (trace) { return trace.style === "recorded"; });
  var found = [];
  traces.forEach(function (trace, index) {
    if (recorded < 0 || trace.style === "recorded" || trace.style === "input") return;
    var values = series[index].map(function (value, row) {
      return value === null || series[recorded][row] === null ? null : series[recorded][row] - value;
    });
    found.push({ label: trace.label, style: trace.style, values: values });
  });
  return found;
}

/** Whether there is nothing to compare: no recorded trace beside a simulation. */
function isAlone(traces) {
  return traces.every(function (trace) { return trace.style === "input" || trace.style === "channel"; });
}

/** The charts of a figure, which act together. */
function group() {
  var shown = [], busy = false;
  return {
    name: "time-" + all.length,
    shown: shown,
    /** Does the same on all other charts, once. */
    others: function (plot, act) {
      if (busy) return;
      busy = true;
      shown.forEach(function (other) { if (other !== plot) act(other); });
      busy = false;
    },
  };
}

/** All charts of a group show the same time. */
function sameTime(charts) {
  return function (plot, key) {
    if (key !== "x") return;
    var range = { min: plot.scales.x.min, max: plot.scales.x.max };
    charts.others(plot, function (other) { other.setScale("x", range); });
  };
}

/** A trace that is switched off is off in all charts of a group. */
function sameTraces(charts) {
  return function (plot, index, changed) {
    if (index === null || changed.show === undefined) return;
    var label = plot.series[index].label;
    charts.others(plot, function (other) {
      other.series.forEach(function (series, at) {
        if (at > 0 && series.label === label) other.setSeries(at, { show: changed.show });
      });
    });
  };
}

function traceOverTime(trace, unit) {
  return {
    label: trace.label,
    stroke: stroke(trace.style),
    width: thickness(trace.style),
    points: { show: false },
    value: function (plot, value) { return withUnit(value, unit); },
  };
}

/** Draws one chart; the last of a figure names the time. */
function drawOverTime(place, chart, charts, width) {
  place.appendChild(element("p", "panel", chart.title + " [" + chart.unit + "]"));
  if (chart.note) place.appendChild(element("p", isAlone(chart.traces) ? "remark" : "quantity", chart.note));
  var options = {
    width: width,
    height: chart.height + (chart.last ? 50 : 28),
    scales: { x: { time: false }, y: { range: ofAll } },
    legend: legend(chart.traces.map(function (trace) { return stroke(trace.style); })),
    cursor: {
      drag: { x: true, y: false },
      sync: { key: charts.name, filters: { pub: function (type) { return type === "mousemove" || type === "mouseleave"; } } },
    },
    axes: [chart.last ? across("time [s]") : across(), upwards(chart.height)],
    series: [{ label: "time", value: function (plot, value) { return withUnit(value, "s"); } }].concat(
      chart.traces.map(function (trace) { return traceOverTime(trace, chart.unit); })
    ),
    hooks: {
      drawClear: [shades(chart.shade.map(function (ends) { return [ends[0], ends[1], null, null]; }))],
      setScale: [sameTime(charts)],
      setSeries: [sameTraces(charts)],
    },
  };
  var plot = new uPlot(options, [chart.time].concat(chart.traces.map(function (trace) { return trace.values; })), place);
  charts.shown.push(plot);
  fingers(plot);
}

function overTime(place, data, width) {
  var charts = group();
  data.panels.forEach(function (panel, index) {
    var last = index + 1 === data.panels.length;
    var series = panel.traces.map(unpacked);
    var traces = panel.traces.map(function (trace, at) {
      return { label: trace.label, style: trace.style, values: series[at] };
    });
    var missed = residuals(panel.traces, series);
    var chart = { unit: panel.unit, time: times(panel.time), shade: panel.shade };
    drawOverTime(place, Object.assign({}, chart, {
      title: panel.title, traces: traces, height: isAlone(traces) ? 110 : 170, last: last && !missed.length, note: panel.note,
    }), charts, width);
    if (missed.length) {
      drawOverTime(place, Object.assign({}, chart, { title: "recorded − simulated", traces: missed, height: 112, last: last }), charts, width);
    }
  });
  if (charts.shown.length) keys(place, charts.shown[0]);
  return charts.shown;
}
