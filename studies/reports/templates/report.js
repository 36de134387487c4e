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
