// Cells over two states.

/** The drawing stays; a line below it tells what is under the pointer. */
function onMap(figure, data) {
  var drawing = figure.querySelector("svg");
  var told = figure.querySelector(".told") || figure.appendChild(element("p", "told soft", "\u00a0"));
  drawing.addEventListener("pointermove", function (event) {
    var box = drawing.getBoundingClientRect();
    var x = ((event.clientX - box.left) / box.width) * data.width;
    var y = ((event.clientY - box.top) / box.height) * data.height;
    var column = Math.floor(((x - data.left) / (data.right - data.left)) * data.columns);
    var row = Math.floor(((data.bottom - y) / (data.bottom - data.top)) * data.rows);
    var inside = column >= 0 && column < data.columns && row >= 0 && row < data.rows;
    var cell = inside ? data.cells[row * data.columns + column] : null;
    told.textContent = cell
      ? data.x + " " + readable(data.from[0] + column * data.step[0]) + " to " + readable(data.from[0] + (column + 1) * data.step[0]) +
        ", " + data.y + " " + readable(data.from[1] + row * data.step[1]) + " to " + readable(data.from[1] + (row + 1) * data.step[1]) +
        ": " + readable(cell[0]) + " " + data.unit + ", " + cell[1] + " rows"
      : "\u00a0";
  });
}
