// Draws the figures as wide as the page, dark where the reader's system is, light on paper.
const dark = matchMedia("(prefers-color-scheme: dark)");
const paper = 700; // px: the text width of a sheet of A4
const brighter = {
  "#1a1a1a": "#e8e8e6", "#e4e4e4": "#3a3d42", "#0072b2": "#6c96ff", "#a3003c": "#ff7aa5", "#5b4cc4": "#9d92ff",
  "#8a8a8a": "#a0a3a8", "#7e4fc9": "#b08bff", "#8c5a3c": "#c98e68", "#7a8a00": "#b5c433", "#3f7f93": "#7cc4da",
};

function draw(printing) {
  for (const place of document.querySelectorAll("[data-plot]")) {
    let text = document.querySelector(`[data-drawing="${place.dataset.plot}"]`).textContent;
    if (dark.matches && !printing)
      for (const [colour, bright] of Object.entries(brighter)) text = text.replaceAll(colour, bright);
    const { data, layouts } = JSON.parse(text).pieces[place.dataset.piece];
    const width = printing ? paper : place.parentElement.clientWidth;
    const layout = layouts.find((each) => each.width <= width) || layouts[layouts.length - 1];
    layout.width = Math.min(width, layouts[0].width);
    Plotly.react(place, data, layout, { displayModeBar: false, responsive: false });
  }
}

// On a narrow screen each cell of a table stands on a line of its own, after the heading of its column.
function headings(table) {
  const labels = [];
  for (const row of table.tHead.rows) {
    let column = 0;
    for (const cell of row.cells)
      for (let repeat = 0; repeat < cell.colSpan; repeat++, column++)
        labels[column] = [labels[column], cell.textContent.trim()].filter(Boolean).join(": ");
  }
  return labels;
}
for (const table of document.querySelectorAll("table")) {
  if (!table.tHead) continue;
  const labels = headings(table);
  for (const row of table.tBodies[0].rows) {
    let column = 0;
    for (const cell of row.cells) {
      cell.dataset.label = labels[column] || "";
      column += cell.colSpan;
    }
  }
}

let width = innerWidth;
addEventListener("resize", () => {
  if (innerWidth !== width) draw();
  width = innerWidth;
});
addEventListener("beforeprint", () => {
  // Paper cannot be opened: laws and sources are printed.
  for (const each of document.querySelectorAll("details.on-paper")) each.open = true;
  draw(true);
});
addEventListener("afterprint", () => draw());
dark.addEventListener("change", () => draw());
draw();
